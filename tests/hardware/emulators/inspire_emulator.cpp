#include "tests/hardware/emulators/inspire_emulator.h"

#include <cmath>

namespace handgraft::test {

namespace inspire = protocols::inspire;
namespace modbus = protocols::modbus;

namespace {

constexpr std::uint8_t kAddress = 1;
constexpr std::size_t kFingers = inspire::kMotorCount;

/// Which finger a register of two bytes is of, from `first` on.
bool isOf(std::size_t address, std::uint16_t first, std::size_t& finger) {
  if (address < first || address >= first + 2 * kFingers) return false;
  finger = (address - first) / 2;
  return true;
}

}  // namespace

InspireEmulator::InspireEmulator() {
  for (Finger& finger : fingers)
    finger.servo.position = finger.servo.goal = 800;
}

void InspireEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = now;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  for (Finger& finger : fingers) {
    finger.servo.speed = finger.speed;  // a second from end to end at full speed
    finger.servo.goal = finger.set;
    const bool is_on = finger.speed > 0 && (finger.error & ~inspire::kStalled) == 0;
    finger.servo.move(seconds, is_on);
  }
}

void InspireEmulator::hear(protocols::Bytes bytes, TimePoint now) {
  advance(now);
  reader_.feed(bytes, [&](protocols::Bytes content) {
    const auto request = modbus::requestOf(content);
    if (request && request->device == kAddress) obey(*request, now);
  });
}

std::uint16_t InspireEmulator::registerAt(std::size_t address) const {
  std::size_t i = 0;
  if (isOf(address, inspire::kAngleSet, i)) return fingers[i].set;
  if (isOf(address, inspire::kForceSet, i)) return fingers[i].force;
  if (isOf(address, inspire::kSpeedSet, i)) return fingers[i].speed;
  if (isOf(address, inspire::kAngleAct, i))
    return static_cast<std::uint16_t>(std::lround(fingers[i].servo.position));
  if (isOf(address, inspire::kForceAct, i))
    return static_cast<std::uint16_t>(fingers[i].force_g);
  if (isOf(address, inspire::kCurrentAct, i))
    return static_cast<std::uint16_t>(fingers[i].current_milliamp);
  const auto both = [&](auto field, std::size_t first) {
    return static_cast<std::uint16_t>(fingers[first].*field | fingers[first + 1].*field << 8);
  };
  if (address >= inspire::kError && address < inspire::kError + kFingers)
    return both(&Finger::error, address - inspire::kError);
  if (address >= inspire::kTemperature && address < inspire::kTemperature + kFingers)
    return both(&Finger::temperature, address - inspire::kTemperature);
  return 0;
}

void InspireEmulator::obey(const modbus::Request& request, TimePoint now) {
  protocols::ByteBuffer wire;
  if (request.function == modbus::kReadRegisters) {
    if (request.count == 0 || request.count > modbus::kMostRegisters) return;
    std::array<std::uint16_t, modbus::kMostRegisters> values{};
    for (std::size_t k = 0; k < request.count; ++k)
      values[k] = registerAt(request.address + 2 * k);
    modbus::encodeReadReply(kAddress, {values.data(), request.count}, wire);
    return say(wire.bytes(), now);
  }
  for (std::size_t k = 0; k < request.count; ++k) {
    const std::size_t address = request.address + 2 * k;
    const std::uint16_t value = modbus::registerAt(request.values, k);
    std::size_t i = 0;
    if (isOf(address, inspire::kAngleSet, i) && value <= inspire::kFullAngle)
      fingers[i].set = value;
    if (isOf(address, inspire::kForceSet, i)) fingers[i].force = value;
    if (isOf(address, inspire::kSpeedSet, i)) fingers[i].speed = value;
    if (address == inspire::kClearError && value == 1) {
      for (Finger& finger : fingers)
        finger.error = finger.is_broken ? finger.error : 0;
    }
  }
  modbus::encodeWriteReply(kAddress, request.address, request.count, wire);
  say(wire.bytes(), now);
}

}  // namespace handgraft::test
