#pragma once

#include <string>

#include "core/base/network.h"

namespace handgraft::server {

/// Where a server keeps what outlives it.
struct StateFile {
  std::string path;  ///< ":memory:": nowhere
  std::string why;   ///< not where it would be by default
};

/// In `folder` if it is given; else in $STATE_DIRECTORY (systemd's), $XDG_STATE_HOME/handgraft,
/// or ~/.local/state/handgraft. Servers of other domains or names have files of their own in
/// it. Makes the folder. Errors: InvalidInput naming a folder that was chosen and cannot be
/// made; where nobody chose one (a container without a home), nothing is kept.
StateFile stateFile(const std::string& folder, const Network& network);

}  // namespace handgraft::server
