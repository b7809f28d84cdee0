#include "hardware/safety/output_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::safety {

namespace {

constexpr double kRelative = 1 + 1e-6;
// The third difference adds eight positions, each with an average's rounding of a few ulp.
constexpr double kRoundedUlps = 64;

}  // namespace

OutputGuard::OutputGuard(const std::vector<JointLimits>& limits, double period_s)
    : period_(period_s) {
  HANDGRAFT_REQUIRE(period_s > 0);
  joints_.reserve(limits.size());
  for (const JointLimits& limit : limits)
    joints_.push_back({limit, limit.lower, limit.upper});
}

void OutputGuard::reset(std::span<const double> start) {
  HANDGRAFT_REQUIRE(start.size() == joints_.size());
  for (std::size_t i = 0; i < start.size(); ++i) {
    Joint& joint = joints_[i];
    std::fill(joint.sent.begin(), joint.sent.end(), start[i]);
    // An average of equal numbers may be an ulp beside them.
    const double ulps = 8 * std::numeric_limits<double>::epsilon() * std::abs(start[i]);
    joint.lowest = std::min(joint.limits.lower, start[i] - ulps);
    joint.highest = std::max(joint.limits.upper, start[i] + ulps);
  }
}

bool OutputGuard::permits(const Joint& joint, double position) const {
  if (!std::isfinite(position) || position < joint.lowest || position > joint.highest)
    return false;
  const double noise =
      kRoundedUlps * std::numeric_limits<double>::epsilon() * std::max(1.0, std::abs(position));
  const auto& sent = joint.sent;
  const double first = position - sent[0];
  const double second = first - (sent[0] - sent[1]);
  const double third = second - (sent[0] - 2 * sent[1] + sent[2]);
  const double T = period_;
  return std::abs(first) <= joint.limits.velocity * T * kRelative + noise &&
         std::abs(second) <= joint.limits.acceleration * T * T * kRelative + noise &&
         std::abs(third) <= joint.limits.jerk * T * T * T * kRelative + noise;
}

bool OutputGuard::permits(std::span<const double> positions) {
  HANDGRAFT_REQUIRE(positions.size() == joints_.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!permits(joints_[i], positions[i])) return false;
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    auto& sent = joints_[i].sent;
    sent[2] = sent[1];
    sent[1] = sent[0];
    sent[0] = positions[i];
  }
  return true;
}

}  // namespace handgraft::safety
