#include "core/retargeting/live_way.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/pose.h"

namespace handgraft::retargeting {
namespace {

using Eigen::Vector3d;

hand::HandPose standing(const Vector3d& p, double q = 0.0, double turn_rad = 0.0) {
  hand::HandPose pose;
  pose.X_WH.translation() = p;
  pose.X_WH.linear() = rotationFromVector(turn_rad * Vector3d::UnitZ());
  pose.q = Eigen::VectorXd::Constant(2, q);
  return pose;
}

TEST(LiveWay, LeadsFromItsBeginningToItsEnd) {
  const Vector3d middle(0.02, 0.0, -0.01);
  const hand::HandPose from = standing({0.12, 0.03, 0.0});
  const hand::HandPose to = standing({-0.05, 0.06, 0.02}, 0.7, 1.1);
  const LiveWay way(from, to, middle, 3.0);
  for (const double before : {2.0, 3.0}) {
    EXPECT_TRUE(way.at(before).X_WH.isApprox(from.X_WH, 1e-12));
    EXPECT_TRUE(way.at(before).q.isApprox(from.q));
  }
  for (const double behind : {way.end(), way.end() + 1.0}) {
    EXPECT_TRUE(way.at(behind).X_WH.isApprox(to.X_WH, 1e-12));
    EXPECT_TRUE(way.at(behind).q.isApprox(to.q));
  }
}

TEST(LiveWay, LetsGoBehindItsEnd) {
  const LiveWay way(standing({0.1, 0.0, 0.0}), standing({0.2, 0.0, 0.0}), Vector3d::Zero(),
                    3.0);
  EXPECT_EQ(way.firmness(3.0), 1.0);
  EXPECT_EQ(way.firmness(way.end()), 1.0);
  EXPECT_NEAR(way.firmness(way.end() + 0.125), 0.5, 1e-9);
  EXPECT_EQ(way.firmness(way.end() + 0.25), 0.0);
  EXPECT_EQ(way.firmness(way.end() + 9.0), 0.0);
}

TEST(LiveWay, GoesAboutTheObject) {
  const LiveWay way(standing({0.1, 0.0, 0.0}), standing({-0.1, 0.0, 0.0}), Vector3d::Zero(),
                    0.0);
  for (int k = 0; k <= 20; ++k)
    EXPECT_GE(way.at(way.end() * k / 20.0).X_WH.translation().norm(), 0.1 - 1e-12) << k;
  EXPECT_NEAR(way.at(0.5 * way.end()).X_WH.translation().norm(), 0.2, 1e-9) << "10 cm farther";
}

TEST(LiveWay, TakesAsLongAsItIs) {
  const auto seconds = [](const hand::HandPose& from, const hand::HandPose& to) {
    return LiveWay(from, to, Vector3d::Zero(), 0.0).end();
  };
  const hand::HandPose here = standing({0.1, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(seconds(here, here), 0.2) << "at least";
  EXPECT_NEAR(seconds(here, standing({0.2, 0.0, 0.0})), 0.4, 1e-9) << "10 cm out";
  EXPECT_NEAR(seconds(here, standing({0.1, 0.0, 0.0}, 1.5)), 0.5, 1e-9) << "joints by 1.5 rad";
  EXPECT_NEAR(seconds(here, standing({0.1, 0.0, 0.0}, 0.0, 2.1)), 0.7, 1e-9) << "2.1 rad";
  EXPECT_DOUBLE_EQ(seconds(here, standing({-0.1, 0.0, 0.0})), 0.8) << "at most";
  // About by 0.3 rad: 3 cm along, and 3 cm away and back.
  const double angle = 0.3;
  EXPECT_NEAR(seconds(here, standing({0.1 * std::cos(angle), 0.1 * std::sin(angle), 0.0})),
              0.09 / 0.25, 1e-9);
}

}  // namespace
}  // namespace handgraft::retargeting
