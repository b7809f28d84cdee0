#include "hardware/bridge/hand_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

constexpr std::size_t kMostJoints = 512;  // the bound of every joint sequence in the contract
constexpr double kFarthest = 1000;        // rad: of a joint without limits
// What motors that are not there draw a joint by, where it slides.
constexpr double kPinion = 0.01;  // m/rad
constexpr double kSame = 1e-3;    // rad: files round

safety::JointLimits limitsOf(const v1::JointInfo& joint, const MotionBounds& bounds) {
  if (!(joint.lower() <= joint.upper()) || joint.lower() == HUGE_VAL ||
      joint.upper() == -HUGE_VAL) {
    rejectInput("joint {}: its limits [{}, {}] leave no room", quoted(joint.name()),
                joint.lower(), joint.upper());
  }
  const double modelled = joint.velocity_limit();
  if (!(modelled >= 0)) {
    rejectInput("joint {}: velocity limit {} is not in [0, inf]", quoted(joint.name()),
                modelled);
  }
  safety::JointLimits limits;
  limits.lower = joint.lower();
  limits.upper = joint.upper();
  const bool slides = joint.kind() == v1::JOINT_PRISMATIC;
  limits.velocity = slides ? bounds.prismatic_velocity : bounds.revolute_velocity;
  if (modelled > 0) limits.velocity = std::min(limits.velocity, modelled);
  limits.acceleration = slides ? bounds.prismatic_acceleration : bounds.revolute_acceleration;
  limits.jerk = slides ? bounds.prismatic_jerk : bounds.revolute_jerk;
  if (!slides) return limits;
  limits.slides = true;
  limits.travel = kPinion;
  limits.margin *= kPinion;
  return limits;
}

/// How a joint of the model follows the one that leads it, through all that lie between.
tendon::MimicJoint leadOf(const v1::MimicInfo& mimic,
                          const v1::HandDescription& description,
                          std::string& leader) {
  tendon::MimicJoint lead;
  lead.ratio = mimic.multiplier();
  lead.offset = mimic.offset();
  leader = mimic.source();
  // More steps than there are mimics would be a loop, which no server reads.
  for (std::size_t step = 0; step < description.mimics().size(); ++step) {
    const auto& mimics = description.mimics();
    const auto next = std::find_if(mimics.begin(), mimics.end(), [&](const v1::MimicInfo& m) {
      return m.joint() == leader;
    });
    if (next == mimics.end()) break;
    lead.offset += lead.ratio * next->offset();
    lead.ratio *= next->multiplier();
    leader = next->source();
  }
  return lead;
}

/// How a follower of the config differs from its joint in the model; empty: it does not, or the
/// model knows of none.
std::string differenceOf(const tendon::MimicJoint& follower,
                         const v1::HandDescription& description,
                         const safety::GovernorOptions& governor) {
  const std::vector<std::string>& names = governor.names;
  const safety::JointLimits& led = governor.limits[follower.joint];
  const double leaders_travel = governor.limits[follower.leader].travel;
  const auto& mimics = description.mimics();
  const auto found = std::find_if(mimics.begin(), mimics.end(), [&](const v1::MimicInfo& m) {
    return m.joint() == names[follower.joint];
  });
  if (found == mimics.end()) return "";
  std::string leader;
  const tendon::MimicJoint lead = leadOf(*found, description, leader);
  const bool is_same =
      leader == names[follower.leader] &&
      std::abs(lead.ratio - follower.ratio) * leaders_travel <= kSame * led.travel &&
      std::abs(lead.offset - follower.offset) <= kSame * led.travel;
  if (is_same) return "";
  return fmt::format(
      "joint {} follows {} with ratio {:.4g} and offset {:.4g} {}, in its model {} with ratio "
      "{:.4g} and offset {:.4g} {}",
      quoted(names[follower.joint]), quoted(names[follower.leader]), follower.ratio,
      follower.offset, safety::unitOf(led), handgraft::quoted(leader), lead.ratio, lead.offset,
      safety::unitOf(led));
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
    const bool is_told = i < description.rest_positions().size();
    const double told = is_told ? description.rest_positions()[i] : 0.0;
    plan.names.push_back(joint.name());
    plan.limits.push_back(limits);
    plan.rest.push_back(
        std::clamp(std::isfinite(told) ? told : 0.0, limits.lower, limits.upper));
  }
  return plan;
}

config::HandConfig simulatedConfig(const HandPlan& plan, double period_s) {
  using std::chrono::milliseconds;
  config::HandConfig config;
  config.hand = plan.hand;
  config.device.kind = config::DeviceKind::kSimulated;
  config.governor.names = plan.names;
  config.governor.limits = plan.limits;
  config.governor.period_s = period_s;
  config.governor.stale_after = milliseconds(1000);
  config.governor.brake_within = milliseconds(10'000);
  config.governor.step = {kFarthest, kFarthest * kPinion};
  config.governor.ramp_share = 1;  // no need to move slowly to a far pose
  config.governor.longest_gap = milliseconds(3'600'000);
  config.governor.overruns_in_a_row = 1'000'000;
  for (std::size_t i = 0; i < plan.jointCount(); ++i) {
    config::MotorConfig motor;
    safety::JointLimits& limits = config.governor.limits[i];
    motor.name = plan.names[i];
    limits.lower = std::max(limits.lower, -kFarthest * limits.travel);
    limits.upper = std::min(limits.upper, kFarthest * limits.travel);
    motor.range_rad = {limits.lower / limits.travel, limits.upper / limits.travel};
    motor.velocity_rad_s = limits.velocity / limits.travel;
    config.motors.push_back(motor);
  }
  return config;
}

std::vector<double> restOfMotors(const HandPlan& plan) {
  std::vector<double> motor_rad;
  for (std::size_t i = 0; i < plan.jointCount(); ++i)
    motor_rad.push_back(plan.rest[i] / plan.limits[i].travel);
  return motor_rad;
}

std::string kindsThatDiffer(const v1::HandDescription& description,
                            const config::HandConfig& config) {
  const auto& names = config.governor.names;
  std::string text;
  const auto compare = [&](const std::string& joint, v1::JointKind kind) {
    const auto found = std::find(names.begin(), names.end(), joint);
    if (found == names.end()) return;
    const bool slides = kind == v1::JOINT_PRISMATIC;
    const bool config_slides =
        config.governor.limits[static_cast<std::size_t>(found - names.begin())].slides;
    if (config_slides == slides) return;
    text += fmt::format("{}joint {} {} in the config and {} in its model",
                        text.empty() ? "" : "; ", quoted(joint),
                        config_slides ? "slides" : "turns", slides ? "slides" : "turns");
  };
  for (const v1::JointInfo& joint : description.joints())
    compare(joint.name(), joint.kind());
  for (const v1::MimicInfo& follower : description.mimics())
    compare(follower.joint(), follower.kind());
  return text;
}

std::string differencesOf(const v1::HandDescription& description,
                          const config::HandConfig& config) {
  const auto& names = config.governor.names;
  std::string text = kindsThatDiffer(description, config);
  const auto add = [&text](const std::string& what) {
    text += (text.empty() ? "" : "; ") + what;
  };
  for (const v1::JointInfo& joint : description.joints()) {
    const auto found = std::find(names.begin(), names.end(), joint.name());
    if (found == names.end()) {
      add(fmt::format("the model's joint {} is not in the config", quoted(joint.name())));
      continue;
    }
    const auto& limits =
        config.governor.limits[static_cast<std::size_t>(found - names.begin())];
    if (limits.slides != (joint.kind() == v1::JOINT_PRISMATIC)) continue;
    const double slack = kSame * limits.travel;
    if (limits.lower < joint.lower() - slack || limits.upper > joint.upper() + slack) {
      add(fmt::format(
          "joint {} may go from {:.4g} to {:.4g} {}, its model from {:.4g} to {:.4g}",
          quoted(joint.name()), limits.lower, limits.upper, safety::unitOf(limits),
          joint.lower(), joint.upper()));
    }
  }
  const auto& followers = config.transmission.followers;
  for (const tendon::MimicJoint& follower : followers) {
    const std::string difference = differenceOf(follower, description, config.governor);
    if (!difference.empty()) add(difference);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    // A server knows it by its leader.
    const bool is_led = std::any_of(followers.begin(), followers.end(), [i](const auto& each) {
      return each.joint == i;
    });
    if (is_led) continue;
    const auto& joints = description.joints();
    const bool is_there =
        std::any_of(joints.begin(), joints.end(), [&](const v1::JointInfo& j) {
          return j.name() == name;
        });
    if (!is_there) add(fmt::format("the config's joint {} is not in the model", quoted(name)));
  }
  return text.empty() ? text : "config and model differ: " + text;
}

bool movesAlike(const HandPlan& a, const HandPlan& b) {
  const auto same_limits = [](const safety::JointLimits& x, const safety::JointLimits& y) {
    return x.lower == y.lower && x.upper == y.upper && x.velocity == y.velocity &&
           x.acceleration == y.acceleration && x.jerk == y.jerk && x.margin == y.margin &&
           x.slides == y.slides && x.travel == y.travel;
  };
  return a.hand == b.hand && a.names == b.names &&
         std::equal(a.limits.begin(), a.limits.end(), b.limits.begin(), b.limits.end(),
                    same_limits);
}

}  // namespace handgraft::bridge
