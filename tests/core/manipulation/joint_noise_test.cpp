// Joints as cameras measure them, against ways and noise that are known.
#include "core/manipulation/joint_noise.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace handgraft::manipulation {
namespace {

/// A hand that goes to and fro by a decimetre a second, its object with it or not.
std::vector<DemonstratedFrame> movingHand(double noise_m, double rate_hz = 60.0) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 240; ++k) {
    DemonstratedFrame frame;
    frame.time_s = k / rate_hz;
    const double way = 0.1 * std::sin(M_PI * frame.time_s);
    for (int joint = 0; joint < frame.joints_W.cols(); ++joint)
      for (int axis = 0; axis < 3; ++axis)
        frame.joints_W(axis, joint) = 0.01 * joint + way + noise_m * noise(random);
    frame.X_WO.translation() = Eigen::Vector3d(0.3, way, 0.0);
    frames.push_back(frame);
  }
  return frames;
}

double rmsBetween(const std::vector<DemonstratedFrame>& a,
                  const std::vector<DemonstratedFrame>& b) {
  double sum = 0.0;
  double count = 0.0;
  // What lies at the ends has less beside it.
  for (std::size_t k = 30; k + 30 < a.size(); ++k) {
    sum += (a[k].joints_W - b[k].joints_W).squaredNorm();
    count += static_cast<double>(a[k].joints_W.size());
  }
  return std::sqrt(sum / count);
}

TEST(JointNoise, IsMeasuredWhileTheHandMoves) {
  for (const double noise_m : {0.0005, 0.002, 0.005}) {
    EXPECT_NEAR(jointNoise(movingHand(noise_m)), noise_m, 0.1 * noise_m);
    EXPECT_NEAR(jointNoise(movingHand(noise_m, 30.0)), noise_m, 0.1 * noise_m);
  }
  EXPECT_LT(jointNoise(movingHand(0.0)), 1e-5);
}

TEST(JointNoise, OfAFewFramesIsNotKnown) {
  std::vector<DemonstratedFrame> few = movingHand(0.002);
  few.resize(15);
  EXPECT_EQ(jointNoise(few), 0.0);
}

TEST(JointNoise, IsEvenedOutAndTheWayStays) {
  const std::vector<DemonstratedFrame> still = movingHand(0.0);
  const std::vector<DemonstratedFrame> noisy = movingHand(0.002);
  const EvenedFrames evened = evenedOut(noisy, jointNoise(noisy));
  const std::vector<DemonstratedFrame>& even = evened.frames;
  ASSERT_EQ(even.size(), noisy.size());
  EXPECT_LT(rmsBetween(even, still), 0.45 * rmsBetween(noisy, still));
  EXPECT_NEAR(evened.noise_m, rmsBetween(even, still), 0.1 * evened.noise_m);
  for (std::size_t k = 0; k < even.size(); ++k)
    EXPECT_EQ(even[k].time_s, noisy[k].time_s);
}

TEST(JointNoise, FineJointsStayToTheBit) {
  const std::vector<DemonstratedFrame> fine = movingHand(0.0002);
  const std::vector<DemonstratedFrame> same = evenedOut(fine, jointNoise(fine)).frames;
  for (std::size_t k = 0; k < fine.size(); ++k)
    EXPECT_EQ(same[k].joints_W, fine[k].joints_W);
}

// A way that a parabola is, is found again at its ends, too, and over a gap.
TEST(JointNoise, AParabolaStays) {
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 60; ++k) {
    if (k > 20 && k < 26) continue;
    DemonstratedFrame frame;
    frame.time_s = k / 60.0;
    frame.joints_W.setConstant(0.1 + 0.3 * frame.time_s - 0.8 * frame.time_s * frame.time_s);
    frames.push_back(frame);
  }
  const std::vector<DemonstratedFrame> even = evenedOut(frames, 0.002).frames;
  for (std::size_t k = 0; k < frames.size(); ++k)
    EXPECT_TRUE(even[k].joints_W.isApprox(frames[k].joints_W, 1e-9)) << frames[k].time_s;
}

}  // namespace
}  // namespace handgraft::manipulation
