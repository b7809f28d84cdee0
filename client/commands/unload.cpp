#include <fmt/format.h>

#include "client/commands/commands.h"
#include "client/json_output.h"
#include "client/server_link.h"
#include "idl/names.h"

namespace handgraft::client {

int run(const UnloadOptions& options, const CommonOptions& common, Interruption& interruption) {
  ServerLink server(common.network, Absence::kFail, interruption);
  server.unload(options.kind, options.name);
  if (common.json) {
    fmt::print("{}\n", json::unloaded(options.kind, options.name));
  } else {
    fmt::print("unloaded {} {}\n", nameOf(options.kind), options.name);
  }
  return 0;
}

}  // namespace handgraft::client
