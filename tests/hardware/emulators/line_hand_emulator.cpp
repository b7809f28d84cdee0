#include "tests/hardware/emulators/line_hand_emulator.h"

#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace handgraft::test {

using devices::LineFraming;
using devices::LineState;

LineHandEmulator::LineHandEmulator() {
  for (EmulatedServo& servo : servos) {
    servo.position = servo.goal = 3000;
    servo.speed = 20'000;  // 2 rad/s
  }
}

void LineHandEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = heard_ = now;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  if (broken_motor >= 0) state = LineState::kBroken;
  const bool is_left = watchdog > Duration::zero() && now - heard_ > watchdog;
  if (state == LineState::kOn && is_left) state = LineState::kWatchdogFired;
  for (EmulatedServo& servo : servos)
    servo.move(seconds, state == LineState::kOn);
}

void LineHandEmulator::hear(protocols::Bytes bytes, TimePoint now) {
  advance(now);
  reader_.feed(bytes, [&](protocols::Bytes frame) {
    obey({reinterpret_cast<const char*>(frame.data()), frame.size()}, now);
  });
}

void LineHandEmulator::obey(std::string_view text, TimePoint now) {
  heard_ = now;
  std::array<int, 3> goal{};
  if (text == "off") state = broken_motor >= 0 ? LineState::kBroken : LineState::kOff;
  if (text == "on" && state == LineState::kOff) state = LineState::kOn;
  if (std::sscanf(std::string(text).c_str(), ">%d,%d,%d", &goal[0], &goal[1], &goal[2]) == 3) {
    for (std::size_t i = 0; i < goal.size(); ++i)
      servos[i].goal = goal[i];
  }
  std::array<long, 3> at{};
  for (std::size_t i = 0; i < at.size(); ++i)
    at[i] = std::lround(servos[i].position);
  protocols::ByteBuffer wire;
  LineFraming::encode(fmt::format("={},{},{},{},{},{}", state, watchdog.count(), broken_motor,
                                  at[0], at[1], at[2]),
                      wire);
  say(wire.bytes(), now);
}

}  // namespace handgraft::test
