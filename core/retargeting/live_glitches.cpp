#include "core/retargeting/live_glitches.h"

#include "core/retargeting/live_beginning.h"

namespace handgraft::retargeting {

namespace {

// Faster than that, beside the wrist, no joint of a hand goes; noise comes on top.
constexpr double kFastestJoint = 2.5;  // m/s
constexpr double kJointNoise = 0.005;  // m
// Nor the wrist: a hand that throws goes at some 9 m/s.
constexpr double kFastestWrist = 10.0;  // m/s
constexpr double kWristNoise = 0.02;    // m
constexpr int kMostJumps = 2;           // in a row; then it is where the hand is

}  // namespace

const manipulation::DemonstratedFrame* LiveGlitches::steadyBefore(
    const manipulation::DemonstratedFrame& frame) {
  if (!jumps(frame)) return nullptr;
  ++jumped_;
  return &*steady_;
}

void LiveGlitches::takeSteady(const manipulation::DemonstratedFrame& frame) {
  steady_ = frame;
  jumped_ = 0;
}

bool LiveGlitches::jumps(const manipulation::DemonstratedFrame& frame) const {
  // What is not finite is for the tracker to refuse.
  if (!steady_ || jumped_ >= kMostJumps || !frame.joints_W.allFinite()) return false;
  const double step_s = frame.time_s - steady_->time_s;
  if (step_s <= 0.0 || step_s > kLivePause) return false;
  const double way = (frame.joints_W.col(0) - steady_->joints_W.col(0)).norm();
  if (way > kFastestWrist * step_s + kWristNoise) return true;
  const hand::JointPlaces now = frame.joints_W.colwise() - frame.joints_W.col(0);
  const hand::JointPlaces before = steady_->joints_W.colwise() - steady_->joints_W.col(0);
  const double farthest = (now - before).colwise().norm().maxCoeff();
  return farthest > kFastestJoint * step_s + kJointNoise;
}

}  // namespace handgraft::retargeting
