#include "hardware/tendon/synergy_map.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::tendon {
namespace {

const std::vector<Range> three_ranges{{-0.2, 1.5}, {0, 1.6}, {0, 1.2}};

struct Followed {
  std::vector<double> motors, residual, measured;
};

Followed follow(SynergyMap& map, const std::vector<double>& q) {
  Followed result{std::vector<double>(map.motorCount()), std::vector<double>(q.size()),
                  std::vector<double>(q.size())};
  map.command(q, result.motors, result.residual);
  map.measure(result.motors, result.measured);
  return result;
}

TEST(SynergyMap, DirectDriveFollowsEveryPose) {
  SynergyMap map = SynergyMap::direct(three_ranges);
  const Followed done = follow(map, {0.3, 0.4, 0.5});
  EXPECT_EQ(done.motors, (std::vector{0.3, 0.4, 0.5}));
  EXPECT_EQ(done.residual, (std::vector{0.0, 0.0, 0.0}));
}

TEST(SynergyMap, AMimicJointFollowsItsLeaderAndTellsWhatItCannot) {
  SynergyMap map = mimicMap(three_ranges, {{2, 1, 0.5, 0.1}});
  ASSERT_EQ(map.motorCount(), 2u);
  const Followed done = follow(map, {0.3, 0.8, 0.9});
  EXPECT_NEAR(done.motors[1], 0.8, 1e-15) << "the leader alone decides";
  EXPECT_NEAR(done.measured[2], 0.5 * 0.8 + 0.1, 1e-15);
  EXPECT_NEAR(done.residual[2], 0.9 - 0.5, 1e-15);
  EXPECT_NEAR(done.residual[0], 0, 1e-15);
}

TEST(SynergyMap, AMotorDrawsWhatSlidesByItsTravel) {
  SynergyMap map = mimicMap({{0.0, 0.036}, {-0.02, 0.02}, {0, 1.2}}, {{1, 0, -0.5, 0.01}},
                            {0.012, 0.006, 1.0});
  const Followed done = follow(map, {0.024, 0.0, 0.7});
  ASSERT_EQ(done.motors.size(), 2u);
  EXPECT_NEAR(done.motors[0], 2.0, 1e-12) << "rad";
  EXPECT_NEAR(done.motors[1], 0.7, 1e-12);
  EXPECT_NEAR(done.measured[0], 0.024, 1e-15) << "m";
  EXPECT_NEAR(done.measured[1], -0.5 * 0.024 + 0.01, 1e-15);
  const std::vector<Range> joints{{0.0, 0.036}, {-0.02, 0.02}, {0, 1.2}};
  EXPECT_NEAR(map.motorRanges(joints)[0].upper, 3.0, 1e-12);
  EXPECT_NEAR(map.motorSpeeds(joints, std::vector{0.048, 0.1, 2.0})[0], 4.0, 1e-12);
  EXPECT_THROW(mimicMap(joints, {}, {0.012, 0.0, 1.0}), InvalidInput);
  EXPECT_THROW(mimicMap(joints, {}, {0.012}), InvalidInput);
}

TEST(SynergyMap, ProjectsByWeightedLeastSquares) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd S(5, 2);
  Eigen::VectorXd offset(5), weights(5);
  for (int j = 0; j < 5; ++j) {
    S.row(j) << normal(random), normal(random);
    offset[j] = normal(random);
    weights[j] = 0.1 + std::abs(normal(random));
  }
  SynergyMap map(S, offset, weights, {{-50, 50}, {-50, 50}});
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> q(5);
    for (double& value : q)
      value = normal(random);
    const Followed done = follow(map, q);
    // At the optimum the weighted residual is orthogonal to every synergy.
    const Eigen::Map<const Eigen::VectorXd> residual(done.residual.data(), 5);
    EXPECT_NEAR((S.transpose() * weights.asDiagonal() * residual).norm(), 0, 1e-12);
    for (std::size_t j = 0; j < 5; ++j)
      EXPECT_NEAR(done.measured[j], q[j] - done.residual[j], 1e-12);
  }
}

TEST(SynergyMap, ClampsSynergiesAndTellsTheResidual) {
  SynergyMap map(Eigen::MatrixXd::Ones(2, 1), Eigen::VectorXd::Zero(2),
                 Eigen::VectorXd::Ones(2), {{0, 0.5}});
  const Followed done = follow(map, {1.0, 1.0});
  EXPECT_EQ(done.motors[0], 0.5);
  EXPECT_NEAR(done.residual[0], 0.5, 1e-15);
}

TEST(SynergyMap, MotorsStayWithinTheRangesAndSpeedsThatItTells) {
  SynergyMap map = mimicMap(three_ranges, {{2, 1, 0.5, 0.1}});
  const std::vector<Range> ranges = map.motorRanges(three_ranges);
  EXPECT_NEAR(ranges[0].lower, -0.2, 1e-15);
  EXPECT_NEAR(ranges[1].upper, 1.6, 1e-15);
  const std::vector<double> speeds = map.motorSpeeds(three_ranges, std::vector{1.0, 2.0, 9.0});
  EXPECT_NEAR(speeds[0], 1, 1e-15);
  EXPECT_NEAR(speeds[1], 2, 1e-15) << "followers set no speed";
}

TEST(SynergyMap, RefusesFollowersThatLeadNowhere) {
  EXPECT_THROW(mimicMap(three_ranges, {{0, 0}}), InvalidInput);
  EXPECT_THROW(mimicMap(three_ranges, {{0, 7}}), InvalidInput);
  EXPECT_THROW(mimicMap(three_ranges, {{0, 1}, {0, 2}}), InvalidInput);
  EXPECT_THROW(mimicMap(three_ranges, {{0, 1}, {1, 2}}), InvalidInput)
      << "a follower's follower";
}

TEST(SynergyMap, RefusesSynergiesThatDependOnEachOther) {
  EXPECT_THROW(SynergyMap(Eigen::MatrixXd::Ones(3, 2), Eigen::VectorXd::Zero(3),
                          Eigen::VectorXd::Ones(3), {{0, 1}, {0, 1}}),
               InvalidInput);
  EXPECT_THROW(SynergyMap(Eigen::MatrixXd::Ones(2, 1), Eigen::VectorXd::Zero(2),
                          -Eigen::VectorXd::Ones(2), {{0, 1}}),
               InvalidInput);
  EXPECT_THROW(SynergyMap(Eigen::MatrixXd::Ones(2, 1), Eigen::VectorXd::Zero(2),
                          Eigen::VectorXd::Ones(2), {{1, 0}}),
               InvalidInput);
  EXPECT_THROW(SynergyMap(Eigen::MatrixXd::Ones(2, 1), Eigen::VectorXd::Zero(3),
                          Eigen::VectorXd::Ones(2), {{0, 1}}),
               InvalidInput);
}

}  // namespace
}  // namespace handgraft::tendon
