#include "hardware/tendon/elastic_posture.h"

#include <cmath>

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/hardware/tendon/hands.h"

namespace handgraft::tendon {
namespace {

using namespace test;
using Stretch = ElasticPosture::Stretch;

double energyOf(const TendonHand& hand, const std::vector<double>& q) {
  double energy = 0;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double bent = q[j] - hand.joints[j].rest;
    energy += hand.joints[j].stiffness * bent * bent / 2;
  }
  return energy;
}

/// Springs and constant arms without reachable stops, all tendons crossing all joints.
TendonHand openHand(std::mt19937& random, int joint_count, int tendon_count) {
  std::uniform_real_distribution<double> unit(0, 1);
  TendonHand hand;
  for (int j = 0; j < joint_count; ++j)
    hand.joints.push_back(
        {"joint_" + std::to_string(j), {-1e3, 1e3}, 0.1 + unit(random), unit(random) - 0.5});
  for (int i = 0; i < tendon_count; ++i) {
    Tendon tendon;
    tendon.name = "tendon_" + std::to_string(i);
    for (int j = 0; j < joint_count; ++j) {
      const double arm = 0.002 + 0.004 * unit(random) + (j % tendon_count == i ? 0.01 : 0);
      tendon.crossings.push_back({static_cast<std::size_t>(j), Extension::constantArm(arm)});
    }
    hand.tendons.push_back(tendon);
  }
  return hand;
}

TEST(ElasticPosture, IsTheWorkedExample) {
  ElasticPosture posture(workedFinger());
  ASSERT_TRUE(
      posture.solve(std::vector{0.013}, std::vector{0.0}, std::vector{100.0}, Stretch::kNone));
  EXPECT_NEAR(posture.tensions()[0], 19.070905, 1e-6);
  EXPECT_NEAR(posture.posture()[0], 0.572127, 1e-6);
  EXPECT_NEAR(posture.posture()[1], 0.667482, 1e-6);
  EXPECT_NEAR(posture.posture()[2], 0.635697, 1e-6);
}

TEST(ElasticPosture, IsTheClosedFormWhereNothingIsBounded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.02, 0.02);
  for (int trial = 0; trial < 30; ++trial) {
    const int n = 2 + trial % 5, m = 1 + trial % 2;
    const TendonHand hand = openHand(random, n, m);
    Eigen::MatrixXd R(m, n);
    Eigen::VectorXd q0(n), compliance(n), e(m);
    for (int i = 0; i < m; ++i) {
      e[i] = unit(random);
      for (int j = 0; j < n; ++j)
        R(i, j) = hand.tendons[i].crossings[j].extension.at(0).slope;
    }
    for (int j = 0; j < n; ++j) {
      q0[j] = hand.joints[j].rest;
      compliance[j] = 1 / hand.joints[j].stiffness;
    }
    const Eigen::MatrixXd G = R * compliance.asDiagonal() * R.transpose();
    const Eigen::VectorXd f = G.ldlt().solve(e - R * q0);
    const Eigen::VectorXd q = q0 + compliance.asDiagonal() * R.transpose() * f;

    ElasticPosture posture(hand);
    const std::vector<double> lowest(m, -1e6), highest(m, 1e6);
    ASSERT_TRUE(posture.solve({e.data(), static_cast<std::size_t>(m)}, lowest, highest,
                              Stretch::kNone));
    for (int j = 0; j < n; ++j)
      EXPECT_NEAR(posture.posture()[j], q[j], 1e-9);
    for (int i = 0; i < m; ++i)
      EXPECT_NEAR(posture.tensions()[i], f[i], 1e-6 * (1 + std::abs(f[i])));
  }
}

TEST(ElasticPosture, KeepsStopsTensionsAndBalance) {
  const TendonHand hand = coupledHand();
  ElasticPosture posture(hand);
  std::mt19937 random(5);
  const std::vector<double> lowest(3, 1.0), highest(3, 34.0);
  int stopped = 0, at_pretension = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<double> e = excursionsOf(hand, randomPose(hand, random));
    ASSERT_TRUE(posture.solve(e, lowest, highest, Stretch::kNone));
    const std::vector<double>& q = posture.posture();
    const std::vector<double>& f = posture.tensions();
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_GE(f[i], 1.0);
      ASSERT_LE(f[i], 34.0);
      const double extra = posture.excursionOf(i) - e[i];
      if (f[i] == 1.0) {
        EXPECT_GE(extra, -1e-12) << "at the pretension it may be pulled in more";
        ++at_pretension;
      } else {
        EXPECT_NEAR(extra, 0, 1e-12);
      }
    }
    for (std::size_t j = 0; j < 4; ++j) {
      const TendonJoint& joint = hand.joints[j];
      double torque = -joint.stiffness * (q[j] - joint.rest);
      for (std::size_t i = 0; i < 3; ++i) {
        for (const Crossing& crossing : hand.tendons[i].crossings)
          if (crossing.joint == j) torque += f[i] * crossing.extension.at(q[j]).slope;
      }
      if (q[j] == joint.range.lower || q[j] == joint.range.upper) {
        const double inwards = q[j] == joint.range.lower ? torque : -torque;
        EXPECT_LE(inwards, 1e-9) << "it is pressed against its stop";
        ++stopped;
      } else {
        EXPECT_NEAR(torque, 0, 1e-9);
      }
    }
  }
  EXPECT_GT(stopped, 10);
  EXPECT_GT(at_pretension, 10);
}

TEST(ElasticPosture, HasLessEnergyThanAnyOtherPostureThatTautTendonsPermit) {
  const TendonHand hand = workedFinger();
  ElasticPosture posture(hand);
  std::mt19937 random(7);
  std::normal_distribution<double> step(0, 0.05);
  for (double e = 0.002; e < 0.03; e += 0.004) {
    ASSERT_TRUE(
        posture.solve(std::vector{e}, std::vector{0.0}, std::vector{100.0}, Stretch::kNone));
    const std::vector<double> best = posture.posture();
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<double> q = best;
      q[0] += step(random);
      q[1] += step(random);
      q[2] = (e - 0.009 * q[0] - 0.007 * q[1]) / 0.005;  // the same excursion
      bool is_inside = true;
      for (std::size_t j = 0; j < 3; ++j)
        is_inside = is_inside && q[j] >= hand.joints[j].range.lower &&
                    q[j] <= hand.joints[j].range.upper;
      if (is_inside) {
        EXPECT_GE(energyOf(hand, q), energyOf(hand, best) - 1e-12);
      }
    }
  }
}

TEST(ElasticPosture, LeavesJointsAtRestWhereTendonsAreSlack) {
  ElasticPosture posture(workedFinger());
  ASSERT_TRUE(
      posture.solve(std::vector{-0.004}, std::vector{0.0}, std::vector{100.0}, Stretch::kNone));
  EXPECT_EQ(posture.tensions()[0], 0);
  for (const double q : posture.posture())
    EXPECT_NEAR(q, 0, 1e-15);
}

TEST(ElasticPosture, EndsAtTheLargestTensionWhenEveryJointIsStopped) {
  ElasticPosture posture(workedFinger());
  posture.solve(std::vector{1.0}, std::vector{0.0}, std::vector{100.0}, Stretch::kNone);
  EXPECT_EQ(posture.tensions()[0], 100.0);
  EXPECT_EQ(posture.posture(), (std::vector{1.6, 1.9, 1.4}));
}

TEST(ElasticPosture, AStretchingTendonTakesWhatItsTensionStretches) {
  TendonHand hand = workedFinger();
  hand.tendons[0].stiffness = 5000;
  ElasticPosture posture(hand);
  ASSERT_TRUE(posture.solve(std::vector{0.013}, std::vector{0.0}, std::vector{100.0},
                            Stretch::kTendons));
  // (R K^-1 R^T + 1/k) f = e
  EXPECT_NEAR(posture.tensions()[0], 0.013 / (6.816666666666667e-4 + 1 / 5000.0), 1e-9);
}

TEST(ElasticPosture, GivesEqualAnswersWhateverCameBefore) {
  const TendonHand hand = coupledHand();
  ElasticPosture fresh(hand), used(hand);
  const std::vector<double> lowest(3, 1.0), highest(3, 34.0);
  used.solve(std::vector{0.02, 0.02, 0.01}, lowest, highest, Stretch::kNone);
  const std::vector<double> e{0.005, 0.006, 0.004};
  fresh.solve(e, lowest, highest, Stretch::kNone);
  used.solve(e, lowest, highest, Stretch::kNone);
  for (std::size_t j = 0; j < 4; ++j)
    EXPECT_NEAR(fresh.posture()[j], used.posture()[j], 1e-12);
}

}  // namespace
}  // namespace handgraft::tendon
