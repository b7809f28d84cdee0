#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/present/contacts_output.h"
#include "client/present/interactive_client.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"

namespace handgraft::client {

int run(const ImportOptions& options, const CommonOptions& common, Interruption& interruption) {
  std::optional<ModelFiles> object;
  if (isPath(options.object)) object = objectFiles(options.object, options.units);
  std::optional<ModelFiles> map = contactFiles(options.map, "", options.reading, options.units);
  if (!options.name.empty()) map->name = options.name;
  std::vector<NamedFile> inputs = inputsOf(map, "map");
  const std::vector<NamedFile> more = inputsOf(object, "--object");
  inputs.insert(inputs.end(), more.begin(), more.end());
  requireSafe({{"--out", options.out}, {"--png", options.png}}, inputs);

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  map->object = nameOnServer(sender, options.object, object);
  // A scan and its contact map come in the same units.
  if (object) map->units = object->units;
  const std::string name = sender.import(*map, !options.name.empty());
  const ContactsOutput output{options.out, options.png, common.json};
  const std::string text = outputOf(server, name, {}, output);
  progress.clear();
  fmt::print("{}", text);
  return 0;
}

}  // namespace handgraft::client
