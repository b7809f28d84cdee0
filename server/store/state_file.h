#pragma once

#include <string>

#include "core/base/network.h"

namespace handgraft::server {

/// Where a server keeps what outlives it.
struct StateFile {
  std::string path;        ///< ":memory:": nowhere
  bool is_chosen = false;  ///< somebody named it: it must do
};

/// Of `folder` if it is given; else of $STATE_DIRECTORY (systemd's), $XDG_STATE_HOME/handgraft,
/// or ~/.local/state/handgraft. Servers of other domains or names have files of their own in
/// it. Makes the folder. Errors: InvalidInput naming it if that cannot be done.
StateFile stateFile(const std::string& folder, const Network& network);

}  // namespace handgraft::server
