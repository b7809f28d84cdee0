#include "hardware/bridge/hand_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

constexpr std::size_t kMostJoints = 512;  // the bound of every joint sequence in the contract

safety::JointLimits limitsOf(const v1::JointInfo& joint, const MotionBounds& bounds) {
  if (!(joint.lower_rad() <= joint.upper_rad()) || joint.lower_rad() == HUGE_VAL ||
      joint.upper_rad() == -HUGE_VAL) {
    rejectInput("joint {}: its limits [{}, {}] leave no room", quoted(joint.name()),
                joint.lower_rad(), joint.upper_rad());
  }
  const double modelled = joint.velocity_limit_rad_s();
  if (!(modelled >= 0)) {
    rejectInput("joint {}: velocity limit {} is not in [0, inf]", quoted(joint.name()),
                modelled);
  }
  safety::JointLimits limits;
  limits.lower = joint.lower_rad();
  limits.upper = joint.upper_rad();
  const bool slides = joint.prismatic();
  limits.velocity = slides ? bounds.prismatic_velocity : bounds.revolute_velocity;
  if (modelled > 0) limits.velocity = std::min(limits.velocity, modelled);
  limits.acceleration = slides ? bounds.prismatic_acceleration : bounds.revolute_acceleration;
  limits.jerk = slides ? bounds.prismatic_jerk : bounds.revolute_jerk;
  if (slides) limits.margin /= 10;  // 0.01 mm
  return limits;
}

}  // namespace

HandPlan planHand(const v1::HandDescription& description, const MotionBounds& bounds) {
  const auto& joints = description.joints();
  if (joints.empty() || joints.size() > kMostJoints) {
    rejectInput("hand {}: {} joints, of 1 to {}", quoted(description.name()), joints.size(),
                kMostJoints);
  }
  HandPlan plan;
  plan.hand = description.name();
  std::set<std::string> seen;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const v1::JointInfo& joint = joints[i];
    if (joint.name().empty() || !seen.insert(joint.name()).second) {
      rejectInput("hand {}: joint name {} is empty or twice", quoted(description.name()),
                  quoted(joint.name()));
    }
    const safety::JointLimits limits = limitsOf(joint, bounds);
    const bool is_told = i < description.rest_rad().size();
    const double told = is_told ? description.rest_rad()[i] : 0.0;
    plan.names.push_back(joint.name());
    plan.limits.push_back(limits);
    plan.rest.push_back(
        std::clamp(std::isfinite(told) ? told : 0.0, limits.lower, limits.upper));
  }
  return plan;
}

}  // namespace handgraft::bridge
