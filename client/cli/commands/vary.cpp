#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/model_text.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"

namespace handgraft::client {

int run(const VaryOptions& options, const CommonOptions& common, Interruption& interruption) {
  std::optional<ModelFiles> files;
  if (isPath(options.hand)) files = handFiles(options.hand, options.reading, options.units);
  requireSafe({{"--urdf", options.urdf}}, inputsOf(files, "hand"));

  // A server of this command's own would take the variant along when it ends; its URDF stays.
  const Absence absence = options.urdf.empty() ? Absence::kFail : Absence::kStartPrivate;
  ProgressLine progress;
  Client server(interactiveClient(common.network, absence, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  v1::VariantRequest request;
  request.hand(nameOnServer(sender, options.hand, files));
  request.name(options.name);
  request.changes(options.changes);
  const v1::ModelSummary summary = server.makeVariant(request).get();
  // With its meshes, since that makes its skin and says how good it is.
  const v1::ModelDescription description =
      server.describe(v1::MODEL_HAND, summary.name(), true).get();
  if (!options.urdf.empty()) writeFile(options.urdf, description.hand().urdf());
  progress.clear();
  fmt::print("{}", common.json ? json::written(json::description(description)) + "\n"
                               : text::description(description));
  return 0;
}

}  // namespace handgraft::client
