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
#include "client/present/skin_file.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

int run(const SkinOptions& options, const CommonOptions& common, Interruption& interruption) {
  std::optional<ModelFiles> files;
  if (isPath(options.hand)) files = handFiles(options.hand, options.reading, options.units);
  requireSafe({{"--out", options.out}, {"--png", options.png}}, inputsOf(files, "hand"));

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  const std::string name = nameOnServer(sender, options.hand, files);
  const v1::HandDescription hand = server.describe(v1::MODEL_HAND, name, true).get().hand();
  if (hand.skin_report().empty()) {
    throw TransportError(fmt::format("the server sent no report of the skin of '{}'", name));
  }
  const v1::SkinReport& report = hand.skin_report().front();

  writeFile(options.out, skinPly(hand));
  if (!options.png.empty()) {
    const HandPicture picture = pictureOfSkin(hand);
    writePng(options.png,
             render::renderTwoViews(picture.scene, picture.caption, picture.views));
  }
  progress.clear();
  if (common.json) {
    fmt::print("{}\n", json::written({{"hand", hand.name()}, {"skin", json::jsonOf(report)}}));
  } else {
    fmt::print("skin of {}\n{}", text::plain(hand.name()), text::skin(report));
  }
  return 0;
}

}  // namespace handgraft::client
