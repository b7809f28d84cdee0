#include "tests/bench/retargeting/retargeting_picture.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "client/present/png_file.h"
#include "client/present/render/two_views.h"

#include "tests/bench/retargeting/grasp_scene.h"

namespace handgraft::bench {

namespace {

constexpr int kWidth = 1500;
constexpr int kHeight = 760;  // of each half

render::Caption captionOf(const RetargetedGrasp& grasp) {
  const GraspMeasure& measure = grasp.ours.measure;
  render::Caption caption;
  caption.title = fmt::format("{} grasps {}", grasp.hand, grasp.grasp);
  caption.subtitle = fmt::format(
      "{} of {} patches reached, {:.1f} mm, {:.0f} deg; deepest {:.1f} mm, self {:.1f} mm",
      measure.reached, grasp.asked, measure.mean_mm, measure.facing_deg,
      1e3 * measure.penetration.deepest(), 1e3 * measure.penetration.self_m);
  for (std::size_t i = 0; i < grasp.patches.size(); ++i) {
    std::string text = grasp.patches[i].name;
    if (!grasp.patches[i].dropped.empty()) text += " dropped";
    for (const PatchMeasure& patch : measure.patches) {
      if (patch.patch == static_cast<int>(i)) text += fmt::format(" {:.1f} mm", patch.mean_mm);
    }
    caption.legend.push_back({patchColor(i), text});
  }
  return caption;
}

}  // namespace

void drawGrasp(const std::filesystem::path& file,
               const MeasuredHand& hand,
               const MeasuredHand& demonstrator,
               const Demonstration& demonstration,
               const RetargetedGrasp& grasp) {
  const geometry::TriangleMesh& object_O = *demonstration.object->mesh_O;
  const render::Scene shown =
      sceneOf(*demonstrator.hand.model, demonstration.pose, object_O, demonstration.contacts);
  const std::array<render::View, 2> views = render::viewsAllAround(shown);
  render::Caption above;
  above.title = demonstrator.name + ", as recorded";
  const render::PictureSize size{kWidth, kHeight};
  const render::Image whole =
      tiled({render::renderTwoViews(shown, above, views, size),
             render::renderTwoViews(
                 sceneOf(*hand.hand.model, grasp.ours.pose, object_O, demonstration.contacts),
                 captionOf(grasp), views, size)},
            1);
  std::filesystem::create_directories(file.parent_path());
  client::writePng(file, whole);
}

}  // namespace handgraft::bench
