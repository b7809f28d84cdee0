#include "hardware/bridge/follower_joints.h"

#include <algorithm>

namespace handgraft::bridge {

std::vector<LedJoint> ledJoints(const config::HandConfig& config,
                                const std::vector<std::string>& told) {
  std::vector<LedJoint> led;
  const auto is_told = [&told](const std::string& name) {
    return std::find(told.begin(), told.end(), name);
  };
  for (const tendon::MimicJoint& follower : config.transmission.followers) {
    const std::string& name = config.governor.names.at(follower.joint);
    const auto leader = is_told(config.governor.names.at(follower.leader));
    if (leader == told.end() || is_told(name) != told.end()) continue;
    led.push_back({name, static_cast<std::size_t>(leader - told.begin()), follower.ratio,
                   follower.offset});
  }
  return led;
}

void appendLed(const std::vector<LedJoint>& led,
               std::size_t told_count,
               std::vector<double>& joint_rad) {
  if (joint_rad.size() != told_count) return;
  for (const LedJoint& joint : led)
    joint_rad.push_back(joint.ratio * joint_rad[joint.leader] + joint.offset);
}

}  // namespace handgraft::bridge
