#include "hardware/protocols/odrive_can.h"

#include <algorithm>
#include <cmath>

namespace handgraft::protocols::odrive {

namespace {

constexpr std::uint32_t kCommandBits = 5;
constexpr double kFeedForwardUnit = 0.001;  // rev/s or Nm

template <class... Values>
CanFrame make(int node, Command command, Values... values) {
  ByteBuffer bytes;
  (bytes.put(values), ...);
  return makeCanFrame(idOf(node, command), bytes.bytes());
}

bool carries(const CanFrame& frame, Command command, std::size_t size) {
  const auto address = addressOf(frame);
  return address && !frame.is_remote && frame.size >= size &&
         address->command == static_cast<std::uint8_t>(command);
}

std::optional<FloatPair> pairOf(const CanFrame& frame, Command command) {
  if (!carries(frame, command, 8)) return std::nullopt;
  return FloatPair{numberAt<float>(frame.bytes(), 0), numberAt<float>(frame.bytes(), 4)};
}

// Rounds to the nearest. Differs: the vendor's code truncates, one unit less at times.
std::int16_t feedForward(double value) {
  HANDGRAFT_REQUIRE(std::isfinite(value));
  return static_cast<std::int16_t>(
      std::clamp(std::round(value / kFeedForwardUnit), -32767.0, 32767.0));
}

}  // namespace

std::uint32_t idOf(int node, Command command) {
  HANDGRAFT_REQUIRE(node >= 0 && node <= kHighestNode);
  return static_cast<std::uint32_t>(node) << kCommandBits | static_cast<std::uint32_t>(command);
}

std::optional<Address> addressOf(const CanFrame& frame) {
  if (frame.is_extended || frame.id > kHighestStandardId) return std::nullopt;
  return Address{static_cast<int>(frame.id >> kCommandBits),
                 static_cast<std::uint8_t>(frame.id & ((1U << kCommandBits) - 1U))};
}

// === To the axis

CanFrame askFor(int node, Command command) {
  CanFrame frame;
  frame.id = idOf(node, command);
  frame.is_remote = true;
  frame.size = 8;
  return frame;
}

CanFrame setAxisState(int node, AxisState state) {
  return make(node, Command::kSetAxisState, static_cast<std::uint32_t>(state), 0U);
}

CanFrame setControllerMode(int node, ControlMode control, InputMode input) {
  return make(node, Command::kSetControllerMode, static_cast<std::uint32_t>(control),
              static_cast<std::uint32_t>(input));
}

CanFrame setInputPosition(int node, float position_rev, double velocity_rev_s, double torque) {
  HANDGRAFT_REQUIRE(std::isfinite(position_rev));
  return make(node, Command::kSetInputPosition, position_rev, feedForward(velocity_rev_s),
              feedForward(torque));
}

CanFrame setInputVelocity(int node, float velocity_rev_s, float torque) {
  HANDGRAFT_REQUIRE(std::isfinite(velocity_rev_s) && std::isfinite(torque));
  return make(node, Command::kSetInputVelocity, velocity_rev_s, torque);
}

CanFrame setInputTorque(int node, float torque) {
  HANDGRAFT_REQUIRE(std::isfinite(torque));
  return make(node, Command::kSetInputTorque, torque, 0U);
}

CanFrame setLimits(int node, float velocity_rev_s, float current_A) {
  HANDGRAFT_REQUIRE(std::isfinite(velocity_rev_s) && std::isfinite(current_A));
  return make(node, Command::kSetLimits, velocity_rev_s, current_A);
}

CanFrame clearErrors(int node) {
  return make(node, Command::kClearErrors, std::uint8_t{0});
}

CanFrame setAbsolutePosition(int node, float position_rev) {
  HANDGRAFT_REQUIRE(std::isfinite(position_rev));
  return make(node, Command::kSetAbsolutePosition, position_rev);
}

CanFrame estop(int node) {
  return make(node, Command::kEstop);
}

// === From the axis

std::optional<Heartbeat> heartbeatOf(const CanFrame& frame, Firmware firmware) {
  if (!carries(frame, Command::kHeartbeat, 8)) return std::nullopt;
  Heartbeat heartbeat;
  heartbeat.error = numberAt<std::uint32_t>(frame.bytes(), 0);
  heartbeat.state = static_cast<AxisState>(frame.data[4]);
  if (firmware == Firmware::k06) {
    heartbeat.procedure_result = frame.data[5];
    heartbeat.is_trajectory_done = (frame.data[6] & 0x01) != 0;
  } else {
    heartbeat.motor_error = (frame.data[5] & 0x01) != 0;
    heartbeat.encoder_error = (frame.data[6] & 0x01) != 0;
    heartbeat.controller_error = (frame.data[7] & 0x01) != 0;
    heartbeat.is_trajectory_done = (frame.data[7] & 0x80) != 0;
  }
  return heartbeat;
}

std::optional<FloatPair> encoderEstimatesOf(const CanFrame& frame) {
  return pairOf(frame, Command::kGetEncoderEstimates);
}

std::optional<FloatPair> iqOf(const CanFrame& frame) {
  return pairOf(frame, Command::kGetIq);
}

std::optional<FloatPair> temperatureOf(const CanFrame& frame) {
  return pairOf(frame, Command::kGetTemperature);
}

std::optional<ErrorReport> errorReportOf(const CanFrame& frame) {
  if (!carries(frame, Command::kGetError, 8)) return std::nullopt;
  return ErrorReport{numberAt<std::uint32_t>(frame.bytes(), 0),
                     numberAt<std::uint32_t>(frame.bytes(), 4)};
}

// === What devices send and understand

CanFrame makeHeartbeat(int node, const Heartbeat& heartbeat, Firmware firmware) {
  const auto bit = [](bool is_set, unsigned value) {
    return static_cast<std::uint8_t>(is_set ? value : 0U);
  };
  const auto state = static_cast<std::uint8_t>(heartbeat.state);
  if (firmware == Firmware::k06) {
    return make(node, Command::kHeartbeat, heartbeat.error, state, heartbeat.procedure_result,
                bit(heartbeat.is_trajectory_done, 0x01), std::uint8_t{0});
  }
  return make(node, Command::kHeartbeat, heartbeat.error, state,
              bit(heartbeat.motor_error, 0x01), bit(heartbeat.encoder_error, 0x01),
              static_cast<std::uint8_t>(bit(heartbeat.controller_error, 0x01) |
                                        bit(heartbeat.is_trajectory_done, 0x80)));
}

CanFrame makeFloatPair(int node, Command command, FloatPair pair) {
  return make(node, command, pair.first, pair.second);
}

CanFrame makeErrorReport(int node, const ErrorReport& report) {
  return make(node, Command::kGetError, report.active, report.disarm_reason);
}

std::optional<AxisState> axisStateOf(const CanFrame& frame) {
  if (!carries(frame, Command::kSetAxisState, 4)) return std::nullopt;
  return static_cast<AxisState>(numberAt<std::uint32_t>(frame.bytes(), 0));
}

std::optional<ControllerMode> controllerModeOf(const CanFrame& frame) {
  if (!carries(frame, Command::kSetControllerMode, 8)) return std::nullopt;
  return ControllerMode{static_cast<ControlMode>(numberAt<std::uint32_t>(frame.bytes(), 0)),
                        static_cast<InputMode>(numberAt<std::uint32_t>(frame.bytes(), 4))};
}

std::optional<InputPosition> inputPositionOf(const CanFrame& frame) {
  if (!carries(frame, Command::kSetInputPosition, 8)) return std::nullopt;
  return InputPosition{numberAt<float>(frame.bytes(), 0),
                       kFeedForwardUnit * numberAt<std::int16_t>(frame.bytes(), 4),
                       kFeedForwardUnit * numberAt<std::int16_t>(frame.bytes(), 6)};
}

std::optional<float> absolutePositionOf(const CanFrame& frame) {
  if (!carries(frame, Command::kSetAbsolutePosition, 4)) return std::nullopt;
  return numberAt<float>(frame.bytes(), 0);
}

std::optional<FloatPair> limitsOf(const CanFrame& frame) {
  return pairOf(frame, Command::kSetLimits);
}

}  // namespace handgraft::protocols::odrive
