#include "client/cli/commands/kept_session.h"

#include <cstdio>

#include <fmt/format.h>

namespace handgraft::client {

void KeptSession::keep(bool tells) {
  kept_ = true;
  if (tells) fmt::print("session {} stays open\n", id());
  if (server_.isPrivate()) {
    fmt::print(
        stderr,
        "--keep has no effect: the session ends with the server that this command started\n");
  }
}

}  // namespace handgraft::client
