#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"

namespace handgraft::client {

int run(const CloseOptions& options, const CommonOptions& common, Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  server.closeSession(session_id).get();
  if (common.json) {
    fmt::print("{}\n", json::written({{"session_id", session_id}, {"closed", true}}));
  } else {
    fmt::print("closed session {}\n", session_id);
  }
  return 0;
}

}  // namespace handgraft::client
