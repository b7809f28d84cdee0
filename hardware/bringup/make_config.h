#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handgraft::bringup {

/// What a config is made for.
struct ConfigPlan {
  std::string kind = "dynamixel";     ///< of the device
  std::string port = "/dev/ttyUSB0";  ///< of a CAN bus also a network interface, "can0"
  int baud = 0;                       ///< 0: the kind's usual one
  int can_bitrate = 0;                ///< the same
  /// Of the motors, in the order of the joints; shorter: counted on. Of a hand that comes as a
  /// whole, their places in it.
  std::vector<int> ids;
};

/// A config to fill in for the hand of a URDF: a motor for each joint that moves by itself,
/// mimic joints as its followers, limits as the model has them, and cautious numbers, each
/// marked, where only the hand itself knows. It reads as it is, so that `jog` and `check` work
/// on it, unless its device has no watchdog: that its owner has to accept, nobody else can. Its
/// loop is as fast as the wire permits, 50 Hz at most, or what a position loop of ours needs.
/// Errors: InvalidInput for a kind that there is not, a file that is no URDF, has no joint that
/// moves, more than the wire at its rate can carry, or another number than such a hand has.
std::string makeConfig(const std::filesystem::path& urdf, const ConfigPlan& plan);

}  // namespace handgraft::bringup
