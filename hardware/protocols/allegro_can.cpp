#include "hardware/protocols/allegro_can.h"

#include "core/base/error.h"

namespace handgraft::protocols::allegro {

namespace {

constexpr std::uint32_t kShift = 2;  // the two lowest bits are the sender's

CanFrame make(Command command, std::size_t finger, const Numbers& numbers) {
  ByteBuffer bytes;
  for (const std::int16_t number : numbers)
    bytes.put(number);
  return makeCanFrame(idOf(command, finger), bytes.bytes());
}

std::optional<std::size_t> fingerOf(const CanFrame& frame, Command command, std::size_t size) {
  if (frame.is_extended || frame.is_remote || frame.size < size) return std::nullopt;
  const std::uint32_t told = frame.id >> kShift;
  const auto first = static_cast<std::uint32_t>(command);
  if (told < first || told >= first + kFingerCount) return std::nullopt;
  return told - first;
}

std::optional<FingerNumbers> numbersOf(const CanFrame& frame, Command command) {
  const auto finger = fingerOf(frame, command, 8);
  if (!finger) return std::nullopt;
  FingerNumbers read{*finger, {}};
  for (std::size_t i = 0; i < read.numbers.size(); ++i)
    read.numbers[i] = numberAt<std::int16_t>(frame.bytes(), 2 * i);
  return read;
}

}  // namespace

std::uint32_t idOf(Command command, std::size_t finger) {
  HANDGRAFT_REQUIRE(finger < kFingerCount);
  return (static_cast<std::uint32_t>(command) + static_cast<std::uint32_t>(finger)) << kShift;
}

CanFrame systemOn() {
  return makeCanFrame(idOf(Command::kSystemOn), {});
}

CanFrame systemOff() {
  return makeCanFrame(idOf(Command::kSystemOff), {});
}

CanFrame askFor(Command command, std::size_t finger) {
  CanFrame frame;
  frame.id = idOf(command, finger);
  frame.is_remote = true;
  frame.size = 0;
  return frame;
}

CanFrame setTorque(std::size_t finger, const Numbers& pwm) {
  return make(Command::kSetTorque, finger, pwm);
}

std::optional<FingerNumbers> poseOf(const CanFrame& frame) {
  return numbersOf(frame, Command::kFingerPose);
}

std::optional<FingerNumbers> torqueOf(const CanFrame& frame) {
  return numbersOf(frame, Command::kSetTorque);
}

std::optional<FingerNumbers> temperatureOf(const CanFrame& frame) {
  const auto finger = fingerOf(frame, Command::kTemperature, 4);
  if (!finger) return std::nullopt;
  FingerNumbers read{*finger, {}};
  for (std::size_t i = 0; i < read.numbers.size(); ++i)
    read.numbers[i] = frame.bytes()[i];
  return read;
}

CanFrame makePose(std::size_t finger, const Numbers& counts) {
  return make(Command::kFingerPose, finger, counts);
}

CanFrame makeTemperature(std::size_t finger, const std::array<std::uint8_t, 4>& celsius) {
  return makeCanFrame(idOf(Command::kTemperature, finger), celsius);
}

}  // namespace handgraft::protocols::allegro
