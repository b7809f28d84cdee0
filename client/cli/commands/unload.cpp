#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "idl/fields.h"

namespace handgraft::client {

int run(const UnloadOptions& options, const CommonOptions& common, Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  server.unload(options.kind, options.name).get();
  if (common.json) {
    fmt::print("{}\n", json::written({{"kind", nameOf(options.kind)},
                                      {"name", options.name},
                                      {"unloaded", true}}));
  } else {
    fmt::print("unloaded {} {}\n", nameOf(options.kind), options.name);
  }
  return 0;
}

}  // namespace handgraft::client
