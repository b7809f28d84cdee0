#pragma once

#include <map>
#include <optional>
#include <string>

#include "hardware/protocols/odrive_can.h"
#include "hardware/protocols/slcan.h"

#include "tests/hardware/emulators/can_bus.h"
#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// ODrive axes on a CAN bus: states, heartbeats, estimates that come by themselves or on
/// request, watchdog, emergency stop, errors that stay until they are cleared.
class ODriveEmulator final : public CanBus {
 public:
  struct Axis {
    EmulatedServo servo;           ///< turns of the shaft, whatever its encoder tells
    double counts_from = 0;        ///< turns: the encoder tells the shaft's turns plus this
    double current_limit_A = 10;   ///< of Set_Limits; what the axis saved until it is told
    double largest_current_A = 0;  ///< that it ever drew in its loop
    double largest_limit_A = 0;    ///< the largest current limit that it ever had in its loop
    double largest_lead = 0;       ///< turns: its goal was ever ahead of it in its loop
    bool takes_positions = true;   ///< Set_Absolute_Position: firmware 0.6 alone
    bool tells_current = true;     ///< answers Get_Iq
    TimePoint boots_until;
    protocols::odrive::FloatPair heat{35.0f, 40.0f};  ///< degrees Celsius
    protocols::odrive::AxisState state = protocols::odrive::AxisState::kIdle;
    std::uint32_t error = 0;
    bool is_broken = false;  ///< its error cannot be cleared
    bool is_unplugged = false;
    std::optional<double> stop;  ///< turns: the servo gets no farther upwards
    /// Turns: from here on a line pulls back, the more the farther it is wound in `winds`,
    /// until at kBlockedCurrent the fingers bend.
    std::optional<double> taut;
    double winds = 1;
    float current_A = 0.25f;                             ///< told while it moves freely
    Duration watchdog = std::chrono::milliseconds(200);  ///< 0: not enabled
    TimePoint heard;
  };

  ODriveEmulator(const std::vector<int>& nodes, protocols::odrive::Firmware firmware);

  void hear(const protocols::CanFrame& frame, TimePoint now) override;
  void advance(TimePoint now) override;
  std::vector<protocols::CanFrame> takeFrames() override;

  /// A, told by an axis that presses against its stop.
  static constexpr float kBlockedCurrent = 3.0f;
  /// A per turn of a taut line.
  static constexpr double kTautCurrent = 60.0;

  Axis& axis(int node) { return axes_.at(node); }

  static void fail(Axis& axis, std::uint32_t error);

  /// Power off and on: silent for a while, idle, counting from 0, errors and limits forgotten.
  void restart(int node, Duration boot = std::chrono::milliseconds(400));

  Duration heartbeat_period = std::chrono::milliseconds(100);
  Duration estimate_period = std::chrono::milliseconds(10);  ///< 0: on request alone

 private:
  void answer(int node, std::uint8_t command);
  void sayEstimates(int node);
  [[nodiscard]] float currentOf(int node) const;
  static void holdByLine(Axis& axis);

  std::map<int, Axis> axes_;
  protocols::odrive::Firmware firmware_;
  std::vector<protocols::CanFrame> said_;
  TimePoint time_, heartbeat_due_, estimate_due_;
};

/// A CAN adapter that speaks lines, with devices on its bus.
class SlcanEmulator final : public EmulatedDevice {
 public:
  explicit SlcanEmulator(CanBus& bus) : bus_(bus) {}

  void hear(protocols::Bytes bytes, TimePoint now) override;
  void advance(TimePoint now) override;

  bool is_open = false;
  bool answers = true;  ///< some adapters do not
  char rate = '\0';

 private:
  void obey(const std::string& line, TimePoint now);
  void sayText(const std::string& text, TimePoint now);
  void passOn(TimePoint now);

  CanBus& bus_;
  protocols::StreamReader<protocols::slcan::Framing> reader_;
};

}  // namespace handgraft::test
