#include "client/present/render/scene_renderer.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/present/render/corner_normals.h"
#include "client/present/render/text.h"
#include "client/present/render/two_views.h"
#include "core/base/error.h"

namespace handgraft::client::render {
namespace {

constexpr Color kWhite{255, 255, 255};
constexpr Color kRed{255, 0, 0};
constexpr Color kGreen{0, 255, 0};

// A square of side 2 h at height z, facing +z.
SurfaceMesh square(float h, float z, Color color) {
  return {{{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}}, {{0, 1, 2}, {0, 2, 3}}, color};
}

Camera fromAbove(const Scene& scene, int size) {
  return Camera::fitting(scene.points(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                         size, size, Projection::kOrthographic);
}

TEST(SceneRenderer, ShowsTheNearerOfTwoLayersAndTheFartherThroughIt) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kGreen)}, {}});
  scene.layers.push_back({1.0, {square(1.0F, 1.0F, kRed)}, {}});
  Image opaque = SceneRenderer(scene).draw(fromAbove(scene, 64), Image(64, 64));
  EXPECT_GT(opaque.at(32, 32).r, 150);
  EXPECT_LT(opaque.at(32, 32).g, 60);

  scene.layers[1].opacity = 0.5;
  Image mixed = SceneRenderer(scene).draw(fromAbove(scene, 64), Image(64, 64));
  EXPECT_GT(mixed.at(32, 32).g, opaque.at(32, 32).g + 50);

  std::swap(scene.layers[0], scene.layers[1]);  // order in the list changes nothing
  EXPECT_EQ(SceneRenderer(scene).draw(fromAbove(scene, 64), Image(64, 64)).pixels(),
            mixed.pixels());
}

TEST(SceneRenderer, LeavesTheBackgroundWhereNothingIs) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kRed)}, {}});
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 100), Image(100, 100, kWhite));
  EXPECT_EQ(image.at(0, 0), kWhite);
  EXPECT_NE(image.at(50, 50), kWhite);
}

TEST(SceneRenderer, PrintsDecalsInsideTheirLoopOnly) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kWhite)}, {}});
  Decal decal;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 24.0;
    decal.loop_W.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.0);
  }
  decal.color = kRed;
  scene.layers[0].decals.push_back(decal);
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 100), Image(100, 100));
  EXPECT_LT(image.at(50, 50).g, 120);
  EXPECT_GT(image.at(50, 84).g, 180);
}

TEST(SceneRenderer, PrintsNothingOnSurfacesOutOfReach) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kWhite)}, {}});
  scene.layers[0].decals.push_back(
      {{{-0.5F, -0.5F, 0.1F}, {0.5F, -0.5F, 0.1F}, {0.0F, 0.5F, 0.1F}}, 0.01F, kRed});
  scene.layers[0].decals.push_back({{{0, 0, 0}, {1, 1, 0}}, 0.01F, kRed});  // no loop
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 100), Image(100, 100));
  EXPECT_EQ(image.at(50, 50).r, image.at(50, 50).g);
}

TEST(SceneRenderer, DrawsLinesOverTheSurfaceThatTheyLieOn) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kWhite)}, {}});
  scene.segments.push_back({{-0.9F, 0, 0}, {0.9F, 0, 0}, 4.0F, kRed});
  scene.segments.push_back({{-0.9F, 0.5F, -0.1F}, {0.9F, 0.5F, -0.1F}, 4.0F, kGreen});  // below
  const Image image = SceneRenderer(scene).draw(fromAbove(scene, 100), Image(100, 100));
  EXPECT_EQ(image.at(50, 50), kRed);
  for (int y = 20; y < 40; ++y)
    EXPECT_FALSE(image.at(50, y) == kGreen);
}

TEST(SceneRenderer, SeesContactFromItsOwnSideOnly) {
  Scene scene;
  scene.layers.push_back({1.0, {square(1.0F, 0.0F, kWhite), square(1.0F, -0.5F, kWhite)}, {}});
  scene.layers[0].decals.push_back(
      {{{-0.5F, -0.5F, 0}, {0.5F, -0.5F, 0}, {0.5F, 0.5F, 0}, {-0.5F, 0.5F, 0}}, 0.1F, kRed});
  const SceneRenderer renderer(scene);
  const Camera above = fromAbove(scene, 50);
  const Camera below =
      Camera::fitting(scene.points(), -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), 50,
                      50, Projection::kOrthographic);
  EXPECT_NEAR(renderer.visibleContact(above, 50, 50), 0.25 * 0.92 * 0.92, 0.03);
  EXPECT_EQ(renderer.visibleContact(below, 50, 50), 0.0);
}

TEST(SceneRenderer, RefusesTrianglesWithoutTheirVertices) {
  Scene scene;
  scene.layers.push_back({1.0, {{{{0, 0, 0}}, {{0, 1, 2}}, kRed}}, {}});
  EXPECT_THROW(SceneRenderer{scene}, InvalidInput);
}

TEST(CornerNormals, RoundASphereAndKeepTheEdgesOfACube) {
  // Two faces of a cube that share an edge: normals stay those of the faces.
  const SurfaceMesh bend{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2}, {0, 3, 1}}, {}};
  const auto sharp = cornerNormals(bend, 0.7);
  EXPECT_TRUE(sharp[0].isApprox(Eigen::Vector3f::UnitZ()));
  EXPECT_TRUE(sharp[3].isApprox(Eigen::Vector3f::UnitY()));
  // Two faces 0.2 rad apart, not sharing vertices but places: the common edge gets the mean.
  const float a = 0.2F;
  const SurfaceMesh roof{
      {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 0}, {std::cos(a), 0, -std::sin(a)}, {0, 1, 0}},
      {{0, 1, 2}, {3, 4, 5}},
      {}};
  const auto round = cornerNormals(roof, 0.7);
  const Eigen::Vector3f mean(std::sin(a / 2), 0, std::cos(a / 2));
  EXPECT_LT((round[0] - mean).norm(), 1e-5F);
  EXPECT_LT((round[3] - mean).norm(), 1e-5F);
}

TEST(Text, IsAsWideAsItSays) {
  Image image(200, 20);
  drawText(image, 0, 0, 2, {0, 0, 0}, "Hg");
  int rightmost = 0;
  int lowest = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (image.at(x, y) == kWhite) continue;
      rightmost = std::max(rightmost, x);
      lowest = std::max(lowest, y);
    }
  }
  EXPECT_EQ(rightmost + 1, textWidth("Hg", 2));
  EXPECT_EQ(lowest + 1, textHeight(2));
  EXPECT_EQ(textWidth("", 2), 0);
}

TEST(Text, ShowsUnknownCharactersAndCutsAtTheRim) {
  Image known(20, 10);
  Image unknown(20, 10);
  drawText(known, 0, 0, 1, {0, 0, 0}, "?");
  drawText(unknown, 0, 0, 1, {0, 0, 0}, "\x01");
  EXPECT_EQ(known.pixels(), unknown.pixels());
  drawText(known, 18, 5, 3, {0, 0, 0}, "\xff cut");
  drawText(known, -100, -100, 3, {0, 0, 0}, "far");
}

TEST(TwoViews, HasTheSizeThatWasAskedFor) {
  Scene scene;
  scene.layers.push_back({1.0, {square(0.1F, 0.0F, kRed)}, {}});
  const Caption caption{
      "title", "subtitle", {{kRed, "thumb 1.0 mm"}, {kGreen, "index 2.0 mm"}}};
  const Image image = renderTwoViews(scene, caption, {500, 300});
  EXPECT_EQ(image.width(), 500);
  EXPECT_EQ(image.height(), 300);
  EXPECT_THROW(renderTwoViews(scene, caption, {100, 300}), InvalidInput);
  EXPECT_NO_THROW(renderTwoViews(Scene{}, {}, {200, 200}));
}

}  // namespace
}  // namespace handgraft::client::render
