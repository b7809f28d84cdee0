#include "tests/bench/retargeting/retargeting_picture.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "client/present/png_file.h"
#include "client/present/render/two_views.h"
#include "core/geometry/surface_point.h"

namespace handgraft::bench {

namespace {

namespace render = client::render;
using render::Color;

constexpr Color kHandColor{222, 190, 160};
constexpr Color kObjectColor{150, 170, 190};
constexpr std::array<Color, 8> kPatchColors{{{214, 39, 40},
                                             {31, 119, 180},
                                             {44, 160, 44},
                                             {255, 127, 14},
                                             {148, 103, 189},
                                             {140, 86, 75},
                                             {227, 119, 194},
                                             {23, 190, 207}}};
constexpr int kWidth = 1500;
constexpr int kHeight = 760;  // of each half

render::SurfaceMesh surface(const geometry::TriangleMesh& mesh, const Pose& X, Color color) {
  render::SurfaceMesh result;
  result.color = color;
  for (int v = 0; v < mesh.vertexCount(); ++v)
    result.vertices_W.emplace_back((X * mesh.vertex(v)).cast<float>());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    result.triangles.push_back({static_cast<std::uint32_t>(face[0]),
                                static_cast<std::uint32_t>(face[1]),
                                static_cast<std::uint32_t>(face[2])});
  }
  return result;
}

render::Scene sceneOf(const hand::HandModel& model,
                      const hand::HandPose& pose,
                      const Demonstration& demonstration) {
  render::Layer hand_layer{0.86, {}, {}};
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, pose);
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    for (const hand::Shape& shape : model.links()[i].surface())
      hand_layer.meshes.push_back(surface(shape.mesh_L, X_WL[i], kHandColor));
  }
  const geometry::TriangleMesh& object_O = *demonstration.object->mesh_O;
  render::Layer object_layer{0.66, {surface(object_O, Pose::Identity(), kObjectColor)}, {}};
  const std::vector<contact::Patch>& patches = demonstration.contacts.patches;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    std::vector<Eigen::Vector3f> loop;
    for (const geometry::SurfacePoint& point : patches[i].interpolation_boundary)
      loop.emplace_back(positionOf(object_O, point).cast<float>());
    object_layer.decals.push_back({loop, 0.006F, kPatchColors[i % kPatchColors.size()]});
  }
  render::Scene scene;
  scene.layers = {object_layer, hand_layer};
  scene.frameAbout(object_layer.meshes.front(), 0.12F);
  return scene;
}

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
    caption.legend.push_back({kPatchColors[i % kPatchColors.size()], text});
  }
  return caption;
}

}  // namespace

void drawGrasp(const std::filesystem::path& file,
               const MeasuredHand& hand,
               const MeasuredHand& demonstrator,
               const Demonstration& demonstration,
               const RetargetedGrasp& grasp) {
  const render::Scene shown =
      sceneOf(*demonstrator.hand.model, demonstration.pose, demonstration);
  const std::array<render::View, 2> views = render::viewsAllAround(shown);
  render::Caption above;
  above.title = demonstrator.name + ", as recorded";
  const render::PictureSize size{kWidth, kHeight};
  const std::array<render::Image, 2> halves{
      render::renderTwoViews(shown, above, views, size),
      render::renderTwoViews(sceneOf(*hand.hand.model, grasp.ours.pose, demonstration),
                             captionOf(grasp), views, size)};
  render::Image whole(kWidth, 2 * kHeight);
  for (int y = 0; y < 2 * kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      whole.at(x, y) = halves[static_cast<std::size_t>(y / kHeight)].at(x, y % kHeight);
  }
  std::filesystem::create_directories(file.parent_path());
  client::writePng(file, whole);
}

}  // namespace handgraft::bench
