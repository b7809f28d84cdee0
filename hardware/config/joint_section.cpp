#include "hardware/config/joint_section.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace handgraft::config {

namespace {

using safety::JointLimits;

// What is permitted in m is a hundredth of what is permitted in rad.
constexpr double kMetres = 0.01;
constexpr double kLongestTravel = 0.2;  // m/rad
constexpr double kUntold = 0.0;

/// Keys of a joint that turns or slides, and what they may be.
struct Keys {
  explicit Keys(bool joint_slides) : slides(joint_slides) {}

  [[nodiscard]] std::string of(const char* what, const char* per = "") const {
    return fmt::format("{}_{}{}", what, slides ? "m" : "rad", per);
  }

  [[nodiscard]] std::string lower() const { return of("lower"); }

  [[nodiscard]] std::string upper() const { return of("upper"); }

  [[nodiscard]] std::string velocity() const { return of("velocity", "_s"); }

  bool slides;
  double unit = slides ? kMetres : 1.0;
};

/// Keys of `section` over `standard`; without one everything is required.
JointLimits motionOf(Section& section,
                     const Keys& keys,
                     const std::optional<JointLimits>& standard) {
  const auto given = [&](double JointLimits::*field) -> std::optional<double> {
    if (!standard) return std::nullopt;
    return (*standard).*field;
  };
  JointLimits limits;
  limits.slides = keys.slides;
  limits.velocity = section.number(keys.velocity(), 1e-3 * keys.unit, 100 * keys.unit,
                                   given(&JointLimits::velocity));
  limits.acceleration = section.number(keys.of("acceleration", "_s2"), 1e-2 * keys.unit,
                                       10'000 * keys.unit, given(&JointLimits::acceleration));
  limits.jerk = section.number(keys.of("jerk", "_s3"), 0.1 * keys.unit, 1e7 * keys.unit,
                               given(&JointLimits::jerk));
  limits.margin = section.number(keys.of("margin"), 0, keys.unit,
                                 standard ? standard->margin : 1e-4 * keys.unit);
  return limits;
}

const tendon::MimicJoint* leadOf(std::size_t joint, const HandConfig& config) {
  const auto& followers = config.transmission.followers;
  const auto found =
      std::find_if(followers.begin(), followers.end(), [joint](const auto& follower) {
        return follower.joint == joint;
      });
  return found == followers.end() ? nullptr : &*found;
}

}  // namespace

void readJoints(Section& file, HandConfig& config) {
  const Keys turning(false);
  const Keys sliding(true);
  std::optional<JointLimits> of_turning;
  std::optional<JointLimits> of_sliding;
  if (file.has("motion")) {
    Section motion = file.section("motion", true);
    if (motion.has(sliding.velocity())) of_sliding = motionOf(motion, sliding, std::nullopt);
    if (!of_sliding || motion.has(turning.velocity()))
      of_turning = motionOf(motion, turning, std::nullopt);
    motion.finish();
  }
  for (Section& joint : file.list("joints", 1, kMostJoints)) {
    config.governor.names.push_back(joint.text("name"));
    const bool slides = joint.has(sliding.lower()) || joint.has(sliding.upper());
    const Keys& keys = slides ? sliding : turning;
    const double farthest = kFarthestTurn * keys.unit;
    const double lower = joint.number(keys.lower(), -farthest, farthest);
    const double upper = joint.number(keys.upper(), -farthest, farthest);
    JointLimits limits = motionOf(joint, keys, slides ? of_sliding : of_turning);
    limits.lower = lower;
    limits.upper = upper;
    if (slides) limits.travel = joint.number("travel_m_rad", 1e-6, kLongestTravel, kUntold);
    if (!(lower < upper))
      joint.object(keys.upper(),
                   fmt::format("{} is not above {} {}", upper, keys.lower(), lower));
    joint.finish();
    config.governor.limits.push_back(limits);
  }
}

void takeTravels(Section& file, HandConfig& config) {
  std::vector<JointLimits>& limits = config.governor.limits;
  for (std::size_t j = 0; j < limits.size(); ++j) {
    if (!limits[j].slides) continue;
    const std::string& name = config.governor.names[j];
    if (config.transmission.kind != TransmissionKind::kDirect) {
      file.object("transmission.kind",
                  fmt::format("joint {} slides; of such ones the motors are direct",
                              handgraft::quoted(name)));
      return;
    }
    const bool is_told = limits[j].travel != kUntold;
    const std::string key = fmt::format("joints[{}].travel_m_rad", j);
    if (const tendon::MimicJoint* lead = leadOf(j, config)) {
      if (is_told)
        file.object(
            key, fmt::format("{} follows {}, whose motor moves both", handgraft::quoted(name),
                             handgraft::quoted(config.governor.names[lead->leader])));
      limits[j].travel = std::abs(lead->ratio) * limits[lead->leader].travel;
    } else if (!is_told && !file.isWrong(key)) {
      file.object(key,
                  "is missing: by so many metres the joint moves for a radian of its motor (a "
                  "pinion's radius, a screw's lead / 6.283)");
    }
  }
}

}  // namespace handgraft::config
