#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/present/hand_picture.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/model_text.h"
#include "client/present/output_file.h"
#include "client/present/png_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "core/base/error.h"

namespace handgraft::client {

int run(const InspectOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  std::optional<ModelFiles> files;
  if (isPath(options.hand)) files = handFiles(options.hand, options.reading, options.units);
  requireSafe({{"--png", options.png}, {"--sites", options.sites}}, inputsOf(files, "hand"));

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  const std::string name = nameOnServer(sender, options.hand, files);
  // With its meshes, since sites are found on the skin.
  const v1::ModelDescription description = server.describe(v1::MODEL_HAND, name, true).get();
  const v1::HandDescription& hand = description.hand();

  if (!options.sites.empty()) {
    if (hand.sites_file().empty()) {
      throw TransportError(fmt::format("the server sent no file of the sites of '{}'", name));
    }
    writeFile(options.sites, hand.sites_file());
  }
  if (!options.png.empty()) {
    const HandPicture picture = pictureOfSites(hand);
    writePng(options.png,
             render::renderTwoViews(picture.scene, picture.caption, picture.views));
  }
  progress.clear();
  fmt::print("{}", common.json ? json::written(json::description(description)) + "\n"
                               : text::description(description));
  return 0;
}

}  // namespace handgraft::client
