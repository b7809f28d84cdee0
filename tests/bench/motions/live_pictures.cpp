#include "tests/bench/motions/live_pictures.h"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "client/present/png_file.h"
#include "client/present/render/two_views.h"

#include "tests/bench/retargeting/grasp_scene.h"

namespace handgraft::bench {

namespace {

// Shares of the sequence: just closed, soon after, in the middle, at the end.
constexpr std::array<double, 4> kShown = {0.36, 0.45, 0.7, 1.0};
constexpr render::PictureSize kCell{640, 420};

std::string subtitleOf(const LiveFrame& frame) {
  if (!frame.pose_O) return "waits";
  return fmt::format("{} of {} reached, {:.1f} mm{}", frame.reached, frame.touches,
                     frame.mean_mm, frame.is_led ? ", led" : "");
}

}  // namespace

void drawLiveGrasp(const std::filesystem::path& folder,
                   const Demonstration& grasp,
                   const hand::HandModel& demonstrator,
                   const hand::HandModel& hand,
                   const std::vector<demonstration::PosedFrame>& frames,
                   const std::vector<LiveFrame>& shown) {
  const geometry::TriangleMesh& object_O = *grasp.object->mesh_O;
  const std::array<render::View, 2> views =
      render::viewsAllAround(sceneOf(demonstrator, grasp.pose, object_O, grasp.contacts));
  std::vector<render::Image> above;
  std::vector<render::Image> below;
  for (const double share : kShown) {
    const auto k = static_cast<std::size_t>(share * static_cast<double>(frames.size() - 1));
    render::Caption caption;
    caption.title = fmt::format("{:.2f} s", frames[k].time_s);
    const hand::HandPose demonstrated_O{inverse(frames[k].X_WO) * frames[k].pose.X_WH,
                                        frames[k].pose.q};
    above.push_back(
        render::renderTwoViews(sceneOf(demonstrator, demonstrated_O, object_O, grasp.contacts),
                               caption, views, kCell));
    caption.title = hand.name();
    caption.subtitle = subtitleOf(shown[k]);
    below.push_back(render::renderTwoViews(
        sceneOf(hand, shown[k].pose_O, object_O, grasp.contacts), caption, views, kCell));
  }
  above.insert(above.end(), below.begin(), below.end());
  std::string name = fmt::format("{}_{}.png", grasp.name, hand.name());
  std::replace(name.begin(), name.end(), '/', '_');
  std::filesystem::create_directories(folder);
  client::writePng(folder / name, tiled(above, static_cast<int>(kShown.size())));
}

}  // namespace handgraft::bench
