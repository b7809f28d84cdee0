#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"

namespace handgraft::client {

int run(const SessionsOptions& /*options*/,
        const CommonOptions& common,
        Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const v1::SessionList list = server.listSessions().get();
  fmt::print("{}", common.json ? json::document(list) + "\n" : text::sessions(list));
  return 0;
}

}  // namespace handgraft::client
