#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/model_text.h"
#include "client/present/text_output.h"

namespace handgraft::client {

int run(const ModelsOptions& options, const CommonOptions& common, Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  if (!options.show) {
    const v1::ModelList list = server.listModels().get();
    fmt::print("{}", common.json ? json::document(list) + "\n" : text::models(list));
    return 0;
  }
  // An object is its mesh: without it there would be nothing to count.
  const bool with_meshes = options.show->kind == v1::MODEL_OBJECT;
  const v1::ModelDescription description =
      server.describe(options.show->kind, options.show->name, with_meshes).get();
  fmt::print("{}", common.json ? json::written(json::description(description)) + "\n"
                               : text::description(description));
  return 0;
}

}  // namespace handgraft::client
