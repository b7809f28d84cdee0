#pragma once

#include <optional>

#include "hardware/devices/dynamixel_bus.h"
#include "hardware/devices/motor_scale.h"

namespace handgraft::devices {

struct DynamixelGains {
  std::uint16_t position_p, position_i, position_d;
};

/// One motor: counts of 4096 a turn.
struct DynamixelMotor {
  std::uint8_t id = 1;
  MotorScale scale{protocols::dynamixel::kRadPerCount};
  int current_limit_milliamp = 350;  ///< also what it may use to reach its target
  /// Of the motor's own profile: it bounds how fast a goal is run to; 0: it does not.
  double velocity_limit_rad_s = 0;
  std::optional<DynamixelGains> gains = std::nullopt;  ///< those of the motor unless told
};

struct DynamixelConfig {
  std::vector<DynamixelMotor> motors;
  std::chrono::milliseconds watchdog{100};  ///< of the motors; rounded up to 20 ms
  Duration reply_timeout = std::chrono::milliseconds(5);  ///< of all motors together
  int tolerated_misses = 3;  ///< answers in a row that a motor may owe
  int return_delay_us = 0;   ///< before a motor answers; even, at most 508
};

/// A hand of X-series motors with current control on one bus, in current-based position mode;
/// models whose indirect data lie elsewhere (the 330 and the others) are not mixed.
///
/// In each cycle one sync read brings, of every motor, current, velocity, position, hardware
/// error, temperature, watchdog and torque, through indirect addresses; one sync write sends
/// the targets. The motors stop by themselves when the bus falls silent for `watchdog`.
///
/// Each `open` sets what safety rests on and the EEPROM may have otherwise: operating and drive
/// mode, no torque at power-up, the errors that cut the torque, the current limit. The homing
/// offset is left as it is.
class DynamixelHand final : public Device {
 public:
  /// `bytes` has to live as long as this.
  /// Errors: InvalidInput, naming motor and value: no motors, an id twice or out of range,
  /// limits beyond +-256 turns, a current limit outside 1 to 6000 mA, a watchdog outside 20 ms
  /// to 2.54 s, timings that are not positive.
  DynamixelHand(DynamixelConfig config, ByteChannel& bytes, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override { return config_.motors.size(); }

  [[nodiscard]] DeviceCounters counters() const override { return counters_; }

  [[nodiscard]] std::string meaningOf(std::uint32_t code) const override;

 private:
  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;

  /// What a sync read brings of one motor.
  struct Block {
    std::int16_t current = 0;
    std::int32_t velocity = 0;
    std::int32_t position = 0;
    std::uint8_t error = 0;
    std::uint8_t temperature = 0;
    std::uint8_t watchdog = 0;
    std::uint8_t torque = 0;
    bool alert = false;
    TimePoint time;
    int misses = 0;  ///< in a row
    bool is_known = false;
  };

  void setUp(std::size_t index);
  // Reads all blocks; false if one is missing.
  bool readBlocks();
  // The same, with further attempts.
  bool readBlocksSurely();
  void findFaults();
  // In the unit of the motor's model, rounded down.
  [[nodiscard]] std::int64_t currentLimit(std::size_t index) const;

  DynamixelConfig config_;
  Clock clock_;
  ByteChannel& bytes_;
  DynamixelBus bus_;
  std::vector<std::uint8_t> ids_;
  std::vector<double> current_units_milliamp_;  // of each motor's model
  std::uint16_t indirect_data_ = protocols::dynamixel::kIndirectData;
  std::vector<Block> blocks_;
  std::vector<std::int32_t> goals_;
  int watchdog_units_;
  bool expects_power_ = false;
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
