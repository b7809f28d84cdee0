#include "tests/hardware/emulators/dynamixel_emulator.h"

#include <algorithm>

namespace handgraft::test {

namespace dxl = protocols::dynamixel;
using protocols::numberAt;

namespace {

constexpr std::chrono::milliseconds kBootTime(200);
constexpr std::size_t kTorque = 64, kReturnLevel = 68, kHardwareError = 70, kWatchdog = 98,
                      kGoalPosition = 116, kFirstReadOnly = 120;

std::int64_t valueAt(protocols::Bytes memory, const dxl::Register& entry) {
  const std::size_t at = entry.address;
  switch (entry.size) {
    case 1:
      return memory[at];
    case 2:
      return entry.is_signed ? std::int64_t{numberAt<std::int16_t>(memory, at)}
                             : std::int64_t{numberAt<std::uint16_t>(memory, at)};
    default:
      return numberAt<std::int32_t>(memory, at);
  }
}

void store(std::array<std::uint8_t, 256>& memory, const dxl::Register& entry, std::int64_t v) {
  for (int i = 0; i < entry.size; ++i)
    memory[static_cast<std::size_t>(entry.address + i)] =
        static_cast<std::uint8_t>(v >> (8 * i));
}

bool isWatchdogTripped(const DynamixelEmulator::Motor& motor) {
  return motor.memory[kWatchdog] == dxl::kWatchdogTripped;
}

}  // namespace

DynamixelEmulator::DynamixelEmulator(const std::vector<std::uint8_t>& ids) {
  for (const std::uint8_t id : ids) {
    Motor& motor = motors_[id];
    motor.servo.position = 2048.0;
    motor.servo.speed = 4096.0;
    boot(motor, id, false);
  }
}

void DynamixelEmulator::boot(Motor& motor, std::uint8_t id, bool keeps_eeprom) {
  for (const dxl::Register& entry : dxl::controlTable()) {
    if (keeps_eeprom && entry.is_eeprom) continue;
    store(motor.memory, entry, entry.start);
  }
  motor.memory[7] = id;
  for (int i = 0; i < dxl::kIndirectCount; ++i) {
    const auto at = static_cast<std::size_t>(dxl::kIndirectAddresses + 2 * i);
    motor.memory[at] = static_cast<std::uint8_t>(dxl::kIndirectData + i);
    motor.memory[at + 1] = 0;
  }
  motor.servo.goal = motor.servo.position;
  if (motor.is_broken) motor.memory[kHardwareError] = dxl::kOverload;
}

std::int64_t DynamixelEmulator::get(std::uint8_t id, const char* name) {
  return valueAt(motors_.at(id).memory, dxl::registerNamed(name));
}

void DynamixelEmulator::set(std::uint8_t id, const char* name, std::int64_t value) {
  store(motors_.at(id).memory, dxl::registerNamed(name), value);
}

void DynamixelEmulator::powerCycle() {
  for (auto& [id, motor] : motors_) {
    boot(motor, id, true);
    motor.boots_until = time_ + kBootTime;
  }
}

void DynamixelEmulator::fail(std::uint8_t id, std::uint8_t error) {
  Motor& motor = motors_.at(id);
  motor.memory[kHardwareError] = error;
  motor.memory[kTorque] = 0;
}

void DynamixelEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = heard_ = now;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  for (auto& [id, motor] : motors_) {
    const int watchdog = motor.memory[kWatchdog];
    const bool is_on = motor.memory[kTorque] != 0;
    if (is_on && watchdog >= 1 && watchdog <= dxl::kLongestWatchdog &&
        now - heard_ > watchdog * std::chrono::milliseconds(dxl::kWatchdogUnitMs)) {
      motor.memory[kWatchdog] = dxl::kWatchdogTripped;
    }
    motor.servo.goal = numberAt<std::int32_t>(motor.memory, kGoalPosition);
    motor.servo.move(seconds, is_on && !isWatchdogTripped(motor));
    if (motor.stop) pushAgainstStop(motor, is_on && !isWatchdogTripped(motor));
    const auto& position = dxl::registerNamed("present_position");
    store(motor.memory, position, std::llround(motor.servo.position));
    store(motor.memory, dxl::registerNamed("present_velocity"),
          std::llround(motor.servo.velocity * dxl::kRadPerCount / dxl::kVelocityUnit));
  }
}

// As hard as its goal current permits.
void DynamixelEmulator::pushAgainstStop(Motor& motor, bool is_on) {
  const auto limit = valueAt(motor.memory, dxl::registerNamed("goal_current"));
  const bool is_blocked = is_on && motor.servo.goal > *motor.stop;
  motor.servo.position = std::min(motor.servo.position, *motor.stop);
  store(motor.memory, dxl::registerNamed("present_current"),
        is_blocked && motor.servo.position >= *motor.stop ? limit : 20);
  if (is_on)
    motor.largest_current_limit =
        std::max(motor.largest_current_limit, static_cast<int>(limit));
}

void DynamixelEmulator::hear(protocols::Bytes bytes, TimePoint now) {
  advance(now);
  reader_.feed(bytes, [&](protocols::Bytes frame) {
    obey(dxl::packetOf(frame), now);
  });
}

void DynamixelEmulator::obey(const Packet& packet, TimePoint now) {
  heard_ = now;
  const auto instruction = static_cast<dxl::Instruction>(packet.instruction);
  const protocols::Bytes parameters = packet.parameters;
  if (instruction == dxl::Instruction::kSyncRead && parameters.size() > 4) {
    const std::size_t address = numberAt<std::uint16_t>(parameters, 0);
    const std::size_t size = numberAt<std::uint16_t>(parameters, 2);
    for (const std::uint8_t id : parameters.subspan(4)) {
      const auto found = motors_.find(id);
      if (found == motors_.end()) continue;
      reply(id, dxl::Error::kNone, read(found->second, address, size), now);
    }
    return;
  }
  if (instruction == dxl::Instruction::kSyncWrite && parameters.size() > 4) {
    const std::size_t address = numberAt<std::uint16_t>(parameters, 0);
    const std::size_t size = numberAt<std::uint16_t>(parameters, 2);
    for (std::size_t at = 4; at + 1 + size <= parameters.size(); at += 1 + size) {
      const auto found = motors_.find(parameters[at]);
      if (found == motors_.end() || now < found->second.boots_until) continue;
      write(found->second, address, parameters.subspan(at + 1, size));
    }
    return;
  }
  for (auto& [id, motor] : motors_) {
    if (packet.id == id || packet.id == dxl::kBroadcastId) obeyOne(id, packet, now);
  }
}

void DynamixelEmulator::obeyOne(std::uint8_t id, const Packet& packet, TimePoint now) {
  Motor& motor = motors_.at(id);
  if (now < motor.boots_until) return;
  const protocols::Bytes parameters = packet.parameters;
  switch (static_cast<dxl::Instruction>(packet.instruction)) {
    case dxl::Instruction::kPing: {
      const ByteVector data = {motor.memory[0], motor.memory[1], motor.memory[6]};
      return reply(id, dxl::Error::kNone, data, now);
    }
    case dxl::Instruction::kRead: {
      if (parameters.size() != 4) return reply(id, dxl::Error::kDataLength, {}, now);
      return reply(id, dxl::Error::kNone,
                   read(motor, numberAt<std::uint16_t>(parameters, 0),
                        numberAt<std::uint16_t>(parameters, 2)),
                   now);
    }
    case dxl::Instruction::kWrite: {
      if (parameters.size() < 3) return reply(id, dxl::Error::kDataLength, {}, now);
      const dxl::Error error =
          write(motor, numberAt<std::uint16_t>(parameters, 0), parameters.subspan(2));
      if (packet.id != dxl::kBroadcastId && motor.memory[kReturnLevel] == 2)
        reply(id, error, {}, now);
      return;
    }
    case dxl::Instruction::kReboot: {
      reply(id, dxl::Error::kNone, {}, now);
      boot(motor, id, true);
      motor.boots_until = now + kBootTime;
      return;
    }
    default:
      return reply(id, dxl::Error::kInstruction, {}, now);
  }
}

dxl::Error DynamixelEmulator::write(Motor& motor, std::size_t address, protocols::Bytes data) {
  if (address + data.size() > motor.memory.size()) return dxl::Error::kAccess;
  const bool is_on = motor.memory[kTorque] != 0;
  const bool is_indirect = address >= dxl::kIndirectAddresses && address < dxl::kIndirectData;
  if (address < kTorque || is_indirect) {
    if (is_on) return dxl::Error::kAccess;
  } else if (address >= kFirstReadOnly) {
    return dxl::Error::kAccess;
  }
  if (address >= 100 && address < 120 && isWatchdogTripped(motor)) {
    ++motor.refused_goals;
    return dxl::Error::kDataRange;
  }
  if (address == kTorque && data[0] != 0 && motor.memory[kHardwareError] != 0)
    return dxl::Error::kResultFail;
  std::copy(data.begin(), data.end(),
            motor.memory.begin() + static_cast<std::ptrdiff_t>(address));
  return dxl::Error::kNone;
}

ByteVector DynamixelEmulator::read(const Motor& motor,
                                   std::size_t address,
                                   std::size_t size) const {
  ByteVector data;
  for (std::size_t at = address; at < address + size; ++at) {
    std::size_t source = at;
    const auto model = dxl::modelNumbered(numberAt<std::uint16_t>(motor.memory, 0));
    const std::size_t first = model ? model->indirect_data : dxl::kIndirectData;
    if (at >= first && at < first + dxl::kIndirectCount)
      source =
          numberAt<std::uint16_t>(motor.memory, dxl::kIndirectAddresses + 2 * (at - first));
    data.push_back(motor.memory.at(source));
  }
  return data;
}

void DynamixelEmulator::reply(std::uint8_t id,
                              dxl::Error error,
                              protocols::Bytes data,
                              TimePoint now) {
  const Motor& motor = motors_.at(id);
  if (motor.is_unplugged || now < motor.boots_until) return;
  protocols::ByteBuffer wire;
  dxl::encodeStatus({id, motor.memory[kHardwareError] != 0, error, data}, wire);
  say(wire.bytes(), now);
}

}  // namespace handgraft::test
