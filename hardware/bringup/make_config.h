#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handgraft::bringup {

/// What a config is made for.
struct ConfigPlan {
  std::string kind = "dynamixel";  ///< of the device
  std::string port = "/dev/ttyUSB0";
  int baud = 0;          ///< 0: the kind's usual one
  std::vector<int> ids;  ///< of the motors, in the order of the joints; shorter: counted on
};

/// A config to fill in for the hand of a URDF: a motor for each joint that moves by itself,
/// mimic joints as its followers, limits as the model has them, and cautious numbers, each
/// marked, where only the hand itself knows. It reads as it is, so that `jog` and `check` work
/// on it; its loop is as fast as the wire permits, 50 Hz at most.
/// Errors: InvalidInput for a file that is no URDF, has no joint that moves, or more than the
/// wire at its rate can carry.
std::string makeConfig(const std::filesystem::path& urdf, const ConfigPlan& plan);

}  // namespace handgraft::bringup
