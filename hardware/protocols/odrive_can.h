#pragma once

#include <cstdint>
#include <optional>

#include "hardware/protocols/can_frame.h"

/// Messages of ODrive's "CANSimple": an 11-bit id that holds axis and command, up to eight
/// bytes, numbers low byte first. Axes answer remote frames of what they can tell. Source:
/// ODrive, docs/can-protocol (firmware 0.5) and ros_odrive (0.6).
namespace handgraft::protocols::odrive {

inline constexpr int kHighestNode = 63;

enum class Command : std::uint8_t {
  kHeartbeat = 0x01,  ///< from the axis, every 100 ms
  kEstop = 0x02,
  kGetError = 0x03,
  kSetAxisState = 0x07,
  kGetEncoderEstimates = 0x09,  ///< from the axis, every 10 ms, or when asked
  kSetControllerMode = 0x0B,
  kSetInputPosition = 0x0C,
  kSetInputVelocity = 0x0D,
  kSetInputTorque = 0x0E,
  kSetLimits = 0x0F,
  kGetIq = 0x14,
  kGetTemperature = 0x15,
  kReboot = 0x16,
  kClearErrors = 0x18,
  kSetAbsolutePosition = 0x19,  ///< firmware 0.6
};

enum class AxisState : std::uint8_t {
  kUndefined = 0,
  kIdle = 1,
  kStartup = 2,
  kFullCalibration = 3,
  kClosedLoop = 8,
  kHoming = 11,
};

enum class ControlMode : std::uint32_t {
  kVoltage = 0,
  kTorque = 1,
  kVelocity = 2,
  kPosition = 3
};

enum class InputMode : std::uint32_t {
  kInactive = 0,
  kPassthrough = 1,
  kVelocityRamp = 2,
  kPositionFilter = 3,
  kTrapezoidal = 5,
};

/// Bits of an axis' error, firmware 0.6.
inline constexpr std::uint32_t kWatchdogExpired = 0x01000000;
inline constexpr std::uint32_t kEstopRequested = 0x02000000;

/// Which of the two layouts of the heartbeat an axis sends.
enum class Firmware : std::uint8_t { k05, k06 };

// === Ids

/// Errors: BrokenContract for a node above kHighestNode.
std::uint32_t idOf(int node, Command command);

/// The axis that a frame is from or for, and its command's number; none if no axis' id.
struct Address {
  int node = 0;
  std::uint8_t command = 0;
};

std::optional<Address> addressOf(const CanFrame& frame);

// === To the axis

CanFrame askFor(int node, Command command);
CanFrame setAxisState(int node, AxisState state);
CanFrame setControllerMode(int node, ControlMode control, InputMode input);
/// rev; rev/s and Nm, to the nearest 0.001 and at most 32.767 either way.
/// Errors: BrokenContract if a number is not finite.
CanFrame setInputPosition(int node,
                          float position_rev,
                          double velocity_rev_s = 0.0,
                          double torque = 0.0);
CanFrame setInputVelocity(int node, float velocity_rev_s, float torque);
CanFrame setInputTorque(int node, float torque);
CanFrame setLimits(int node, float velocity_rev_s, float current_A);
CanFrame clearErrors(int node);
/// Firmware 0.6: the encoder tells `position_rev` where it stands, until the axis restarts.
CanFrame setAbsolutePosition(int node, float position_rev);
/// Disarms the axis with the error `kEstopRequested`, which stays until it is cleared.
CanFrame estop(int node);

// === From the axis. Each is none for a frame of another command, a remote frame, or too few
// bytes.

struct Heartbeat {
  std::uint32_t error = 0;
  AxisState state = AxisState::kUndefined;
  std::uint8_t procedure_result = 0;  ///< firmware 0.6
  /// Firmware 0.5: motor, encoder and controller have an error that `error` may not tell.
  bool motor_error = false, encoder_error = false, controller_error = false;
  bool is_trajectory_done = false;

  /// Whether anything is wrong.
  [[nodiscard]] bool isFaulty() const {
    return error != 0 || motor_error || encoder_error || controller_error;
  }

  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

std::optional<Heartbeat> heartbeatOf(const CanFrame& frame, Firmware firmware = Firmware::k06);

/// Two floats, as several commands carry them.
struct FloatPair {
  float first = 0, second = 0;

  friend bool operator==(const FloatPair&, const FloatPair&) = default;
};

/// rev and rev/s.
std::optional<FloatPair> encoderEstimatesOf(const CanFrame& frame);
/// A: what is asked of the motor, and what flows.
std::optional<FloatPair> iqOf(const CanFrame& frame);
/// Degrees Celsius: of the power stage and of the motor (firmware 0.6).
std::optional<FloatPair> temperatureOf(const CanFrame& frame);

struct ErrorReport {
  std::uint32_t active = 0;
  std::uint32_t disarm_reason = 0;
};

/// Firmware 0.6.
std::optional<ErrorReport> errorReportOf(const CanFrame& frame);

// === What devices send and understand, for emulators

CanFrame makeHeartbeat(int node, const Heartbeat& heartbeat, Firmware firmware = Firmware::k06);
CanFrame makeFloatPair(int node, Command command, FloatPair pair);
CanFrame makeErrorReport(int node, const ErrorReport& report);
std::optional<AxisState> axisStateOf(const CanFrame& frame);

struct ControllerMode {
  ControlMode control = ControlMode::kPosition;
  InputMode input = InputMode::kPassthrough;
};

std::optional<ControllerMode> controllerModeOf(const CanFrame& frame);

struct InputPosition {
  float position_rev = 0;
  double velocity_rev_s = 0;
  double torque = 0;  ///< Nm
};

std::optional<InputPosition> inputPositionOf(const CanFrame& frame);
std::optional<float> absolutePositionOf(const CanFrame& frame);
/// rev/s and A.
std::optional<FloatPair> limitsOf(const CanFrame& frame);

}  // namespace handgraft::protocols::odrive
