#include "hardware/tendon/tendon_map.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/tendon/hands.h"

namespace handgraft::tendon {
namespace {

using namespace test;

struct Followed {
  std::vector<double> motors, residual, measured;
};

Followed follow(TendonMap& map, const std::vector<double>& q) {
  Followed result{std::vector<double>(map.motorCount()), std::vector<double>(q.size()),
                  std::vector<double>(q.size())};
  map.command(q, result.motors, result.residual);
  map.measure(result.motors, result.measured);
  return result;
}

TEST(TendonMap, IsTheWorkedExample) {
  TendonMap map(workedFinger());
  const Followed done = follow(map, {0.6, 0.8, 0.4});
  EXPECT_NEAR(done.motors[0], 2.1666667, 1e-6);
  EXPECT_NEAR(done.motors[0] / (2 * std::numbers::pi), 0.344836, 1e-6);
  EXPECT_NEAR(done.motors[0] * 4096 / (2 * std::numbers::pi), 1412.45, 5e-3);
  EXPECT_NEAR(map.tensions()[0], 19.070905, 1e-6);
  EXPECT_NEAR(done.residual[0], 0.027873, 1e-6);
  EXPECT_NEAR(done.residual[1], 0.132518, 1e-6);
  EXPECT_NEAR(done.residual[2], -0.235697, 1e-6);
}

TEST(TendonMap, MeasuresThePoseThatItPromised) {
  std::mt19937 random(1);
  for (const TendonHand& hand : {workedFinger(), coupledHand(), antagonists()}) {
    TendonMap map(hand);
    for (int trial = 0; trial < 200; ++trial) {
      const std::vector<double> q = randomPose(hand, random);
      const Followed done = follow(map, q);
      for (std::size_t j = 0; j < q.size(); ++j)
        EXPECT_NEAR(done.measured[j], q[j] - done.residual[j], 1e-9) << hand.joints[j].name;
    }
  }
}

TEST(TendonMap, FollowsAPoseThatItPromisedBeforeExactly) {
  // What the hand can take is taken: projecting twice changes nothing.
  std::mt19937 random(2);
  for (const TendonHand& hand : {workedFinger(), coupledHand()}) {
    TendonMap map(hand);
    for (int trial = 0; trial < 100; ++trial) {
      const Followed first = follow(map, randomPose(hand, random));
      const Followed second = follow(map, first.measured);
      for (std::size_t j = 0; j < first.measured.size(); ++j)
        EXPECT_NEAR(second.residual[j], 0, 1e-8);
      for (std::size_t i = 0; i < first.motors.size(); ++i)
        EXPECT_NEAR(second.motors[i], first.motors[i], 1e-7);
    }
  }
}

TEST(TendonMap, ARigidHandFollowsEveryPose) {
  std::mt19937 random(4);
  const TendonHand hand = antagonists();
  TendonMap map(hand);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<double> q = randomPose(hand, random);
    const Followed done = follow(map, q);
    for (std::size_t j = 0; j < q.size(); ++j) {
      EXPECT_EQ(done.residual[j], 0);
      EXPECT_NEAR(done.measured[j], q[j], 1e-12);
    }
  }
}

TEST(TendonMap, ArmsAreTheDerivativesOfExcursions) {
  const TendonHand hand = coupledHand();
  const TendonMap map(hand);
  std::mt19937 random(6);
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<double> q = randomPose(hand, random);
    const Eigen::MatrixXd R = map.arms(q);
    for (std::size_t j = 0; j < q.size(); ++j) {
      std::vector<double> before = q, after = q;
      before[j] -= kStep;
      after[j] += kStep;
      const auto e0 = excursionsOf(hand, before), e1 = excursionsOf(hand, after);
      for (std::size_t i = 0; i < e0.size(); ++i)
        EXPECT_NEAR(R(static_cast<int>(i), static_cast<int>(j)), (e1[i] - e0[i]) / (2 * kStep),
                    1e-9);
    }
  }
}

TEST(TendonMap, WindsInWhatTheTendonStretches) {
  TendonHand hand = workedFinger();
  TendonMap stiff(hand);
  hand.tendons[0].stiffness = 10000;
  TendonMap soft(hand);
  const std::vector<double> q{0.6, 0.8, 0.4};
  const double extra = follow(soft, q).motors[0] - follow(stiff, q).motors[0];
  EXPECT_NEAR(extra * 0.006, 19.070905 / 10000, 1e-9);
}

TEST(TendonMap, TakesUpSlackToThePretension) {
  TendonHand hand = workedFinger();
  hand.tendons[0].pretension = 2;
  TendonMap map(hand);
  const Followed done = follow(map, {-0.3, -0.3, -0.3});
  EXPECT_EQ(map.tensions()[0], 2);
  // q = K^-1 R^T 2 N
  EXPECT_NEAR(done.measured[0], 0.009 * 2 / 0.3, 1e-12);
  EXPECT_NEAR(done.residual[0], -0.3 - 0.06, 1e-12);
}

TEST(TendonMap, MotorsStayWithinTheRangesThatItTells) {
  std::mt19937 random(8);
  for (const TendonHand& hand : {workedFinger(), coupledHand(), antagonists()}) {
    TendonMap map(hand);
    std::vector<Range> joints;
    for (const TendonJoint& joint : hand.joints)
      joints.push_back(joint.range);
    const std::vector<Range> motors = map.motorRanges(joints);
    for (int trial = 0; trial < 500; ++trial) {
      std::vector<double> q = randomPose(hand, random);
      for (std::size_t j = 0; j < q.size(); ++j) {
        if (trial % 3 == 0) q[j] = random() % 2 == 0 ? joints[j].lower : joints[j].upper;
      }
      const Followed done = follow(map, q);
      for (std::size_t i = 0; i < motors.size(); ++i) {
        EXPECT_GE(done.motors[i], motors[i].lower - 1e-9);
        EXPECT_LE(done.motors[i], motors[i].upper + 1e-9);
      }
    }
  }
}

TEST(TendonMap, MotorsAreNoFasterThanTheSpeedsThatItTells) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  constexpr double kStep = 1e-5;
  const TendonHand hand = antagonists();
  TendonMap map(hand);
  const std::vector<Range> joints(2, Range{-1, 1});
  const std::vector<double> joint_speeds{2.0, 3.0};
  const std::vector<double> speeds = map.motorSpeeds(joints, joint_speeds);
  double fastest = 0;
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> q = randomPose(hand, random);
    const Followed before = follow(map, q);
    for (std::size_t j = 0; j < q.size(); ++j)
      q[j] += kStep * joint_speeds[j] * (unit(random) > 0 ? 1 : -1);
    const Followed after = follow(map, q);
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const double speed = std::abs(after.motors[i] - before.motors[i]) / kStep;
      EXPECT_LE(speed, speeds[i] * (1 + 1e-6));
      fastest = std::max(fastest, speed / speeds[i]);
    }
  }
  EXPECT_GT(fastest, 0.99) << "the bound is attained";
}

TEST(TendonMap, RefusesAHandWithAllOfItsProblems) {
  TendonHand hand = workedFinger();
  hand.joints[1].range = {1, 0};
  hand.tendons[0].spool.radius_m = 0;
  try {
    TendonMap map(hand);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("'pip'"), std::string::npos) << text;
    EXPECT_NE(text.find("spool radius"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace handgraft::tendon
