#include "tests/bench/retargeting/grasp_scene.h"

#include <array>

#include "core/base/error.h"
#include "core/geometry/surface_point.h"

namespace handgraft::bench {

namespace {

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

}  // namespace

render::Color patchColor(std::size_t patch) {
  return kPatchColors[patch % kPatchColors.size()];
}

render::Scene sceneOf(const hand::HandModel& model,
                      const std::optional<hand::HandPose>& pose_O,
                      const geometry::TriangleMesh& object_O,
                      const contact::ContactSet& contacts) {
  render::Layer hand_layer{0.86, {}, {}};
  if (pose_O) {
    const hand::LinkPoses X_OL = hand::forwardKinematics(model, *pose_O);
    for (std::size_t i = 0; i < X_OL.size(); ++i) {
      for (const hand::Shape& shape : model.links()[i].surface())
        hand_layer.meshes.push_back(surface(shape.mesh_L, X_OL[i], kHandColor));
    }
  }
  render::Layer object_layer{0.66, {surface(object_O, Pose::Identity(), kObjectColor)}, {}};
  const std::vector<contact::Patch>& patches = contacts.patches;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    std::vector<Eigen::Vector3f> loop;
    for (const geometry::SurfacePoint& point : patches[i].interpolation_boundary)
      loop.emplace_back(positionOf(object_O, point).cast<float>());
    object_layer.decals.push_back({loop, 0.006F, patchColor(i)});
  }
  render::Scene scene;
  scene.layers.push_back(object_layer);
  if (pose_O) scene.layers.push_back(hand_layer);
  scene.frameAbout(object_layer.meshes.front(), 0.12F);
  return scene;
}

render::Image tiled(const std::vector<render::Image>& images, int columns) {
  HANDGRAFT_REQUIRE(!images.empty() && columns >= 1);
  const int width = images.front().width();
  const int height = images.front().height();
  const int rows = (static_cast<int>(images.size()) + columns - 1) / columns;
  render::Image whole(columns * width, rows * height);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const int left = static_cast<int>(i) % columns * width;
    const int top = static_cast<int>(i) / columns * height;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        whole.at(left + x, top + y) = images[i].at(x, y);
    }
  }
  return whole;
}

}  // namespace handgraft::bench
