#pragma once

#include <string>
#include <vector>

#include "hardware/config/hand_config.h"

namespace handgraft::bridge {

/// A joint that a pose leaves out, since another one leads it.
struct LedJoint {
  std::string name;
  std::size_t leader = 0;  ///< of the names that are told
  double ratio = 1.0;
  double offset = 0.0;  ///< rad, or m if it slides
};

/// The joints that follow others by the config and are not among `told`, though their leaders
/// are: a server streams the joints that move by themselves alone.
std::vector<LedJoint> ledJoints(const config::HandConfig& config,
                                const std::vector<std::string>& told);

/// Appends where they are to a pose of the joints that were told. One of another length stays
/// as it is, to be refused.
void appendLed(const std::vector<LedJoint>& led,
               std::size_t told_count,
               std::vector<double>& joint_rad);

}  // namespace handgraft::bridge
