#pragma once

#include <map>
#include <optional>

#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/dynamixel_table.h"

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// XC330 motors on a bus: control table, EEPROM lock, indirect addresses, bus watchdog,
/// hardware errors that cut the torque until a reboot.
class DynamixelEmulator final : public EmulatedDevice {
 public:
  struct Motor {
    std::array<std::uint8_t, 256> memory{};
    EmulatedServo servo;     ///< counts
    bool is_broken = false;  ///< the hardware error comes back after every reboot
    bool is_unplugged = false;
    TimePoint boots_until;
    std::optional<double> stop;     ///< counts: the servo gets no farther upwards
    int largest_current_limit = 0;  ///< mA, of the goal current while its torque was on
    int refused_goals = 0;          ///< written after the watchdog had fired
  };

  explicit DynamixelEmulator(const std::vector<std::uint8_t>& ids);

  void hear(protocols::Bytes bytes, TimePoint now) override;
  void advance(TimePoint now) override;

  Motor& motor(std::uint8_t id) { return motors_.at(id); }

  std::int64_t get(std::uint8_t id, const char* name);
  /// As the motor itself does, whatever access others have.
  void set(std::uint8_t id, const char* name, std::int64_t value);
  /// Power off and on, of all: silent for a while, torque off, RAM as it starts.
  void powerCycle();
  /// A hardware error: the torque goes off and stays off.
  void fail(std::uint8_t id, std::uint8_t error);

 private:
  using Packet = protocols::dynamixel::Packet;

  void obey(const Packet& packet, TimePoint now);
  void obeyOne(std::uint8_t id, const Packet& packet, TimePoint now);
  static void pushAgainstStop(Motor& motor, bool is_on);
  void boot(Motor& motor, std::uint8_t id, bool keeps_eeprom);
  protocols::dynamixel::Error write(Motor& motor, std::size_t address, protocols::Bytes data);
  ByteVector read(const Motor& motor, std::size_t address, std::size_t size) const;
  void reply(std::uint8_t id,
             protocols::dynamixel::Error error,
             protocols::Bytes data,
             TimePoint now);

  std::map<std::uint8_t, Motor> motors_;
  protocols::StreamReader<protocols::dynamixel::Framing> reader_;
  TimePoint time_;
  TimePoint heard_;
};

}  // namespace handgraft::test
