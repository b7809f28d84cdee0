#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/server_link.h"
#include "client/present/json_output.h"
#include "idl/fields.h"

namespace handgraft::client {

int run(const UnloadOptions& options, const CommonOptions& common, Interruption& interruption) {
  ServerLink server(common.network, Absence::kFail, interruption);
  server.unload(options.kind, options.name);
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
