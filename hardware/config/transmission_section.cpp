#include "hardware/config/transmission_section.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::config {

namespace {

constexpr double kLongestArm = 0.2;  // m: no hand is larger
constexpr std::size_t kMost = 512;

std::size_t jointNamed(Section& section, const char* key, const HandConfig& config) {
  const std::vector<std::string>& names = config.governor.names;
  const std::string name = section.text(key);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  section.object(key, "no joint is named " + handgraft::quoted(name));
  return 0;
}

tendon::MimicJoint followerOf(Section& section, const HandConfig& config) {
  tendon::MimicJoint follower{};
  follower.joint = jointNamed(section, "joint", config);
  follower.leader = jointNamed(section, "leader", config);
  // Of what turns with a joint that slides, in rad/m.
  follower.ratio = section.number("ratio", -1e4, 1e4);
  const bool slides =
      !config.governor.limits.empty() && config.governor.limits[follower.joint].slides;
  follower.offset = slides ? section.number("offset_m", -1, 1, 0)
                           : section.number("offset_rad", -100, 100, 0);
  section.finish();
  return follower;
}

/// `arm_m` alone, with `curvature_m`, or `channel_m: [before, after, height]`.
tendon::Crossing crossingOf(Section& section, const HandConfig& config) {
  const std::size_t joint = jointNamed(section, "joint", config);
  tendon::Extension extension = tendon::Extension::constantArm(1e-2);
  if (section.has("channel_m")) {
    const std::vector<double> exits = section.numbers("channel_m", 3, 0, kLongestArm);
    if (exits.size() == 3 && exits[0] > 0 && exits[1] > 0) {
      extension = tendon::Extension::channel(exits[0], exits[1], exits[2]);
    } else if (exits.size() == 3) {
      section.object("channel_m", "before and after the axis must be above 0");
    }
  } else {
    const double arm = section.number("arm_m", -kLongestArm, kLongestArm);
    const double curvature = section.number("curvature_m", -kLongestArm, kLongestArm, 0);
    extension = curvature == 0 ? tendon::Extension::constantArm(arm)
                               : tendon::Extension::quadratic(arm, curvature);
  }
  section.finish();
  return {joint, extension};
}

tendon::Tendon tendonOf(Section& section, const HandConfig& config, bool is_elastic) {
  tendon::Tendon tendon;
  tendon.name = section.text("name");
  tendon.spool.radius_m = section.number("spool_radius_m", 1e-4, kLongestArm);
  tendon.spool.growth_m = section.number("spool_growth_m", 0, 0.01, 0);
  if (section.has("stiffness_N_m")) tendon.stiffness = section.number("stiffness_N_m", 1, 1e9);
  if (is_elastic) {
    tendon.pretension = section.number("pretension_N", 0, 1e4, 0);
    tendon.largest_tension = section.number("largest_tension_N", 1e-3, 1e4);
  } else {
    tendon.closed_loop = section.flag("closed_loop", false);
  }
  for (Section& crossing : section.list("crossings", 1, kMost))
    tendon.crossings.push_back(crossingOf(crossing, config));
  section.finish();
  return tendon;
}

void readTendons(Section& section, const HandConfig& config, tendon::TendonHand& hand) {
  for (std::size_t j = 0; j < config.jointCount(); ++j) {
    const safety::JointLimits& limits = config.governor.limits[j];
    hand.joints.push_back({config.governor.names[j], {limits.lower, limits.upper}, 0, 0});
  }
  std::size_t spring_count = 0;
  for (Section& spring : section.list("springs", 0, kMost)) {
    const std::size_t j = jointNamed(spring, "joint", config);
    const double stiffness = spring.number("stiffness_Nm_rad", 1e-6, 1e3);
    const double rest = spring.number("rest_rad", -10, 10, 0);
    // Printed stops lie where the joint's limits do unless told otherwise.
    const double lower = spring.number("stop_lower_rad", -10, 10, hand.joints[j].range.lower);
    const double upper = spring.number("stop_upper_rad", -10, 10, hand.joints[j].range.upper);
    spring.finish();
    if (hand.joints[j].stiffness > 0) spring.object("joint", "has two springs");
    hand.joints[j] = {hand.joints[j].name, {lower, upper}, stiffness, rest};
    ++spring_count;
  }
  for (Section& tendon : section.list("tendons", 1, kMost))
    hand.tendons.push_back(tendonOf(tendon, config, spring_count > 0));
}

}  // namespace

TransmissionConfig readTransmission(Section section, const HandConfig& config) {
  TransmissionConfig transmission;
  transmission.kind =
      section.choice<TransmissionKind>("kind",
                                       {{"direct", TransmissionKind::kDirect},
                                        {"synergies", TransmissionKind::kSynergies},
                                        {"tendons", TransmissionKind::kTendons}},
                                       TransmissionKind::kDirect);
  if (section.isWrong("kind")) {  // which keys there are depends on it
    section.allow({"followers", "rest_rad", "synergies", "springs", "tendons"});
    section.finish();
    return transmission;
  }
  // Joints are told by name; without any there is nothing more to read.
  if (config.jointCount() == 0) return transmission;
  switch (transmission.kind) {
    case TransmissionKind::kDirect:
      for (Section& follower : section.list("followers", 0, kMost))
        transmission.followers.push_back(followerOf(follower, config));
      break;
    case TransmissionKind::kSynergies:
      transmission.rest_rad = section.numbers("rest_rad", config.jointCount(), -10, 10);
      for (Section& synergy : section.list("synergies", 1, kMost)) {
        transmission.synergies.push_back(
            {synergy.numbers("column", config.jointCount(), -100, 100)});
        synergy.finish();
      }
      break;
    case TransmissionKind::kTendons:
      readTendons(section, config, transmission.tendons);
      break;
  }
  section.finish();
  return transmission;
}

}  // namespace handgraft::config
