#pragma once

#include <array>

#include "hardware/devices/device.h"
#include "hardware/devices/motor_scale.h"
#include "hardware/protocols/inspire_table.h"
#include "hardware/protocols/modbus_rtu.h"

namespace handgraft::devices {

struct InspireConfig {
  std::uint8_t address = 1;
  /// In the hand's own order; units are thousandths of a finger's way, 1000 open.
  std::array<MotorScale, protocols::inspire::kMotorCount> scales;
  std::array<std::size_t, protocols::inspire::kMotorCount> order{0, 1, 2, 3, 4, 5};
  double force_N = 3;  ///< where a finger stops, 0.1 to 9.8
  std::uint16_t speed = protocols::inspire::kFullSpeed;
  Duration reply_timeout = std::chrono::milliseconds(10);
  int tolerated_misses = 3;  ///< answers in a row
};

/// An Inspire RH56 hand on a serial line, by Modbus RTU, in angle mode.
///
/// In each cycle its angles are read and written, and one of forces, currents, errors and
/// temperatures in turn. It has no switch for its motors: armed means that fingers have a
/// speed; disarmed they have none, and their screws hold them.
///
/// **It has no watchdog**: should this process die, its fingers end what they were told last,
/// which is never farther than a period's way when the governor leads them, and hold there.
class InspireHand final : public Device {
 public:
  /// `bytes` has to live as long as this. Errors: InvalidInput, naming the value.
  InspireHand(const InspireConfig& config, ByteChannel& bytes, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override { return config_.scales.size(); }

  [[nodiscard]] DeviceCounters counters() const override;

  [[nodiscard]] std::string meaningOf(std::uint32_t code) const override;

  /// N at the fingertips, in the hand's own order.
  [[nodiscard]] std::span<const double> touch() const override { return forces_; }

 private:
  using Registers = std::array<std::uint16_t, protocols::inspire::kMotorCount>;

  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;

  // Sends what is in `out_`, having forgotten what came before.
  void ask();
  // Waits for an answer to the function; its values, if it is a read's, into `into`.
  bool take(std::uint8_t function, std::span<std::uint16_t> into);
  bool read(std::uint16_t address, std::span<std::uint16_t> into);
  void readSurely(std::uint16_t address, std::span<std::uint16_t> into, const char* what);
  void writeSurely(std::uint16_t address, const Registers& values, const char* what);
  void takeWhatIsOwed();
  void readOneMore();
  void findFaults();

  InspireConfig config_;
  ByteChannel& bytes_;
  Clock clock_;
  protocols::StreamReader<protocols::modbus::ReplyFraming> reader_;
  protocols::ByteBuffer out_;
  Registers angles_{};
  std::array<double, protocols::inspire::kMotorCount> velocities_{};  // units/s
  std::array<double, protocols::inspire::kMotorCount> forces_{};
  std::array<double, protocols::inspire::kMotorCount> currents_{};
  std::array<double, protocols::inspire::kMotorCount> temperatures_{};
  std::array<std::uint8_t, protocols::inspire::kMotorCount> errors_{};
  TimePoint time_;  // of `angles_`
  std::size_t turn_ = 0;
  bool is_owed_ = false;  // an answer to a write
  bool expects_power_ = false;
  int misses_ = 0;
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
