#include "tests/hardware/emulators/ability_hand_emulator.h"

#include <cmath>

namespace handgraft::test {

namespace ah = protocols::ability_hand;

namespace {

constexpr std::chrono::milliseconds kPatience(300);

}  // namespace

AbilityHandEmulator::AbilityHandEmulator() {
  for (EmulatedServo& servo : servos) {
    servo.speed = 2.0 / ah::kRadPerCount;
    servo.position = servo.goal = 2000.0;
  }
  servos[ah::kThumbRotator].position = servos[ah::kThumbRotator].goal = -2000.0;
}

void AbilityHandEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = heard_ = now;
  if (now - heard_ > kPatience) is_in_api_mode = false;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  for (std::size_t i = 0; i < servos.size(); ++i)
    servos[i].move(seconds, is_in_api_mode && (limited >> i & 1) == 0);
}

void AbilityHandEmulator::hear(protocols::Bytes bytes, TimePoint now) {
  advance(now);
  reader_.feed(bytes, [&](protocols::Bytes content) {
    const auto command = ah::commandOf(content);
    if (command && command->address == ah::kDefaultAddress) obey(*command, now);
  });
}

void AbilityHandEmulator::obey(const ah::Command& command, TimePoint now) {
  heard_ = now;
  if (command.header == static_cast<std::uint8_t>(ah::Simple::kExitApi)) {
    is_in_api_mode = false;
    ++exits;
    return;
  }
  if (command.counts && command.mode() == ah::Mode::kPosition) {
    is_in_api_mode = true;
    for (std::size_t i = 0; i < servos.size(); ++i)
      servos[i].goal = (*command.counts)[i];
  }
  ah::State state;
  state.reply = command.reply();
  state.header = command.header;
  state.touch = touch;
  state.limited = limited;
  for (std::size_t i = 0; i < servos.size(); ++i) {
    state.position[i] = static_cast<std::int16_t>(std::lround(servos[i].position));
    const double rotor = servos[i].velocity * ah::kRadPerCount * ah::kGearRatio[i];
    state.velocity[i] =
        static_cast<std::int16_t>(std::lround(rotor / ah::kRotorRadPerSecondPerCount));
  }
  protocols::ByteBuffer wire;
  ah::encodeState(state, wire);
  say(wire.bytes(), now);
}

}  // namespace handgraft::test
