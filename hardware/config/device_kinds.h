#pragma once

#include <span>

namespace handgraft::config {

enum class DeviceKind { kSimulated, kDynamixel, kAbilityHand, kODrive, kInspire, kAllegro };

/// What a device hangs on. Adapters to a CAN bus are on a tty as well, or a network interface.
enum class DeviceWire { kNone, kTty, kCan };

/// What is true of all devices of a kind, whatever a config says.
struct DeviceTraits {
  DeviceKind kind;
  const char* name;  ///< in a config
  DeviceWire wire;
  int baud;         ///< of its tty, or its adapter's, where a config says nothing
  int can_bitrate;  ///< the same of its bus; 0: it is on none
  int own_motors;   ///< of a hand that comes as a whole, known by place; 0: motors have ids
  int highest_id;
  bool has_watchdog;  ///< it stops by itself when nobody commands it
  bool has_zeros;     ///< it knows where its joints are 0: nobody can or need put them there
  bool has_own_loop;  ///< it takes targets; else torques, and the position loop is ours
};

/// The least rate of a position loop that is ours.
inline constexpr int kLeastTorqueRate = 100;  // Hz

/// All kinds, a line each.
std::span<const DeviceTraits> deviceKinds();

const DeviceTraits& traitsOf(DeviceKind kind);

}  // namespace handgraft::config
