#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include "client/present/render/scene_renderer.h"
#include "client/present/render/two_views.h"
#include "client/present/render/views.h"
#include "core/base/error.h"

namespace handgraft::client::render {
namespace {

constexpr Color kWhite{255, 255, 255};
constexpr Color kRed{255, 0, 0};
constexpr Color kBlue{0, 0, 255};

// A square of side 2 h at height z, facing +z.
SurfaceMesh square(float h, float z) {
  return {{{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}}, {{0, 1, 2}, {0, 2, 3}}, kWhite, {}};
}

Camera fromAbove(const Scene& scene, int size) {
  return Camera::fitting(scene.points(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                         size, size, Projection::kOrthographic);
}

TEST(VertexColors, BlendAcrossTriangles) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F)}, {}});
  scene.layers[0].meshes[0].vertex_colors = {kRed, kBlue, kBlue, kRed};
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 101), Image(101, 101));
  EXPECT_GT(image.at(10, 50).r, 8 * image.at(10, 50).b);
  EXPECT_GT(image.at(90, 50).b, 8 * image.at(90, 50).r);
  EXPECT_NEAR(image.at(50, 50).r, image.at(50, 50).b, 6);
  scene.layers[0].meshes[0].vertex_colors.pop_back();
  EXPECT_THROW(SceneRenderer{scene}, InvalidInput);
}

TEST(Rims, LieBesideTheirLineAndUnderOthers) {
  Scene scene;
  SurfaceMesh ground = square(1.0F, 0.0F);
  ground.color = {40, 40, 40};
  scene.layers.push_back({1.0, {ground}, {}});
  scene.lift_m = 0.01F;
  scene.segments.push_back({{-0.9F, 0, 0}, {0.9F, 0, 0}, 4.0F, kRed});
  scene.segments.push_back({{0, -0.9F, 0}, {0, 0.9F, 0}, 4.0F, kBlue, 6.0F});
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 100), Image(100, 100));
  EXPECT_EQ(image.at(50, 20), kBlue);
  EXPECT_EQ(image.at(45, 20), kWhite);
  EXPECT_LT(image.at(40, 20).r, 100);
  EXPECT_EQ(image.at(45, 50), kRed) << "the rim covers another line";
}

TEST(Frame, IsAboutAMeshAndWhatIsNear) {
  Scene scene;
  scene.layers.push_back({1.0, {square(0.1F, 0.0F)}, {}});
  scene.layers.push_back({1.0, {square(0.1F, 0.05F), square(0.1F, 0.9F)}, {}});
  scene.markers.push_back({{0, 0, 0.02F}, 2.0F, kRed});
  EXPECT_EQ(scene.points().size(), 13u);
  scene.frameAbout(scene.layers[0].meshes[0], 0.06F);
  EXPECT_EQ(scene.points().size(), 9u) << "the square at 0.9 m is in no picture's way";
  EXPECT_FLOAT_EQ(scene.framed_W.max().x(), 0.16F);
  // All of the other layer is far: a picture without it would say nothing.
  scene.layers[1].meshes.erase(scene.layers[1].meshes.begin());
  scene.frameAbout(scene.layers[0].meshes[0], 0.06F);
  EXPECT_EQ(scene.points().size(), 9u) << "everything there is";
  EXPECT_TRUE(scene.framed_W.isEmpty());
}

TEST(Views, TurnTowardsContactWhereverItIs) {
  for (const Eigen::Vector3f& axis :
       {Eigen::Vector3f(0, 0, -1), Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(1, 0, 0)}) {
    Scene scene;
    // A cube whose face along `axis` bears a patch.
    for (int k = 0; k < 3; ++k) {
      for (const float side : {-1.0F, 1.0F}) {
        Eigen::Vector3f n = Eigen::Vector3f::Zero();
        n[k] = side;
        const Eigen::Vector3f u(n.y(), n.z(), n.x());
        const Eigen::Vector3f v = n.cross(u);
        SurfaceMesh face{
            {n - u - v, n + u - v, n + u + v, n - u + v}, {{0, 1, 2}, {0, 2, 3}}, kWhite, {}};
        if (n == axis) {
          if (scene.layers.empty()) scene.layers.push_back({1.0, {}, {}});
          scene.layers[0].decals.push_back({{n - 0.5F * u - 0.5F * v, n + 0.5F * u - 0.5F * v,
                                             n + 0.5F * u + 0.5F * v, n - 0.5F * u + 0.5F * v},
                                            0.1F,
                                            kRed});
        }
        if (scene.layers.empty()) scene.layers.push_back({1.0, {}, {}});
        scene.layers[0].meshes.push_back(face);
      }
    }
    const auto views = viewsAllAround(scene);
    EXPECT_GT(views[0].from_W.dot(axis.cast<double>()), 0.7) << axis.transpose();
    EXPECT_LT(views[0].from_W.dot(views[1].from_W), std::cos(79.0 * std::numbers::pi / 180.0));
  }
}

TEST(Views, ShowSmallContactBesideLarge) {
  // Two plates back to back, a large patch on one and a small one on the other.
  Scene scene;
  SurfaceMesh back = square(1.0F, -0.1F);
  for (auto& triangle : back.triangles)
    std::swap(triangle[0], triangle[1]);
  scene.layers.push_back({1.0, {square(1.0F, 0.1F), back}, {}});
  const auto decal = [](float h, float z) {
    return Decal{{{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}}, 0.05F, kRed};
  };
  scene.layers[0].decals = {decal(0.8F, 0.1F), decal(0.1F, -0.1F)};
  const auto views = viewsAllAround(scene);
  EXPECT_GT(views[0].from_W.z(), 0.5);
  EXPECT_LT(views[1].from_W.z(), -0.5);
}

TEST(Labels, AreLeftOutWhereTheirPlaceTurnsAway) {
  Scene bare;
  bare.layers.push_back({1.0, {square(0.1F, 0.0F)}, {}});
  const std::array<View, 2> views = {
      {{Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), ""},
       {-Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), ""}}};
  Scene scene = bare;
  scene.labels.push_back({{0, 0, 0}, "palm", kRed, Eigen::Vector3f::UnitZ()});
  const Image without = renderTwoViews(bare, {}, views, {600, 300});
  const Image with = renderTwoViews(scene, {}, views, {600, 300});
  int left = 0;
  int right = 0;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 600; ++x)
      (x < 300 ? left : right) += with.at(x, y) == without.at(x, y) ? 0 : 1;
  }
  EXPECT_GT(left, 100);
  EXPECT_EQ(right, 0);
}

TEST(Labels, StandBesideTheirPlacesWithoutOverlapping) {
  Scene bare;
  bare.layers.push_back({1.0, {square(0.1F, 0.0F)}, {}});
  const std::array<View, 2> views = {
      {{Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), "above"},
       {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), ""}}};
  const Image without = renderTwoViews(bare, {}, views, {600, 300});
  Scene one = bare;
  one.labels.push_back({{0, 0, 0}, "palm", kRed});
  Scene two = one;
  two.labels.push_back({{0, 0, 0}, "palm", kRed});
  const auto changed = [&](const Scene& scene) {
    const Image image = renderTwoViews(scene, {}, views, {600, 300});
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x)
        count += image.at(x, y) == without.at(x, y) ? 0 : 1;
    }
    return count;
  };
  EXPECT_GT(changed(one), 100);
  EXPECT_GT(changed(two), 3 * changed(one) / 2);  // else the second covers the first
}

}  // namespace
}  // namespace handgraft::client::render
