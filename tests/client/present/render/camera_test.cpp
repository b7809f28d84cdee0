#include "client/present/render/camera.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::client::render {
namespace {

class CameraFit : public testing::TestWithParam<Projection> {};

TEST_P(CameraFit, ShowsEveryPointAndWastesNoRoom) {
  std::mt19937 generator(3);
  std::normal_distribution<float> normal;
  for (int round = 0; round < 30; ++round) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 50; ++i) {
      points.emplace_back(0.1F * normal(generator) + 3.0F, 0.02F * normal(generator),
                          0.05F * normal(generator) - 1.0F);
    }
    const Eigen::Vector3d from(normal(generator), normal(generator), normal(generator));
    const Camera camera =
        Camera::fitting(points, from, Eigen::Vector3d::UnitZ(), 640, 480, GetParam());
    float low_x = 1e9F;
    float high_x = -1e9F;
    float low_y = 1e9F;
    float high_y = -1e9F;
    for (const Eigen::Vector3f& p : points) {
      const ScreenPoint at = camera.toScreen(camera.toCamera(p));
      low_x = std::min(low_x, at.x);
      high_x = std::max(high_x, at.x);
      low_y = std::min(low_y, at.y);
      high_y = std::max(high_y, at.y);
    }
    EXPECT_GE(low_x, 0.0F);
    EXPECT_LE(high_x, 640.0F);
    EXPECT_GE(low_y, 0.0F);
    EXPECT_LE(high_y, 480.0F);
    EXPECT_TRUE(high_x - low_x > 400.0F || high_y - low_y > 300.0F)
        << high_x - low_x << " x " << high_y - low_y;
  }
}

TEST_P(CameraFit, PutsUpUpAndNearNear) {
  const std::vector<Eigen::Vector3f> points = {{-1, -1, -1}, {1, 1, 1}};
  const Camera camera = Camera::fitting(points, Eigen::Vector3d::UnitX(),
                                        Eigen::Vector3d::UnitZ(), 400, 400, GetParam());
  const auto at = [&](float x, float y, float z) {
    return camera.toScreen(camera.toCamera(Eigen::Vector3f(x, y, z)));
  };
  EXPECT_LT(at(0, 0, 1).y, at(0, 0, -1).y);  // +z is up; pixels grow downwards
  EXPECT_GT(at(0, 1, 0).x, at(0, -1, 0).x);  // seen from +x, +y is right
  EXPECT_GT(at(1, 0, 0).nearness, at(-1, 0, 0).nearness);
}

TEST_P(CameraFit, SurvivesScenesWithoutAnExtent) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3d from = Eigen::Vector3d::UnitZ();  // parallel to up
  for (const std::vector<Eigen::Vector3f>& points :
       {std::vector<Eigen::Vector3f>{}, {{nan, 0, 0}}, {{1, 2, 3}}}) {
    const Camera camera =
        Camera::fitting(points, from, Eigen::Vector3d::UnitZ(), 100, 100, GetParam());
    const Eigen::Vector3f target = points.size() == 1 && points[0].allFinite()
                                       ? points[0]
                                       : Eigen::Vector3f(Eigen::Vector3f::Zero());
    const ScreenPoint at = camera.toScreen(camera.toCamera(target));
    EXPECT_NEAR(at.x, 50.0F, 1.0F);
    EXPECT_NEAR(at.y, 50.0F, 1.0F);
  }
}

INSTANTIATE_TEST_SUITE_P(Projections,
                         CameraFit,
                         testing::Values(Projection::kPerspective, Projection::kOrthographic));

TEST(Camera, RefusesADirectionThatIsNone) {
  EXPECT_THROW(Camera::fitting({}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 10, 10,
                               Projection::kPerspective),
               InvalidInput);
}

}  // namespace
}  // namespace handgraft::client::render
