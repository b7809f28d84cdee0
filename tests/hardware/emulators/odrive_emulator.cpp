#include "tests/hardware/emulators/odrive_emulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace handgraft::test {

namespace odrive = protocols::odrive;
using odrive::AxisState;
using odrive::Command;
using protocols::CanFrame;

ODriveEmulator::ODriveEmulator(const std::vector<int>& nodes, odrive::Firmware firmware)
    : firmware_(firmware) {
  for (const int node : nodes)
    axes_[node].servo.speed = 1.0;
}

void ODriveEmulator::fail(Axis& axis, std::uint32_t error) {
  axis.error |= error;
  axis.state = AxisState::kIdle;
}

void ODriveEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = heartbeat_due_ = estimate_due_ = now;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  const bool is_beat = now >= heartbeat_due_;
  const bool is_estimate = estimate_period > Duration::zero() && now >= estimate_due_;
  if (is_beat) heartbeat_due_ = now + heartbeat_period;
  if (is_estimate) estimate_due_ = now + estimate_period;
  for (auto& [node, axis] : axes_) {
    const bool is_on = axis.state == AxisState::kClosedLoop;
    if (is_on && axis.watchdog > Duration::zero() && now - axis.heard > axis.watchdog)
      fail(axis, firmware_ == odrive::Firmware::k06 ? odrive::kWatchdogExpired : 0x800U);
    axis.servo.move(seconds, axis.state == AxisState::kClosedLoop);
    if (axis.stop) axis.servo.position = std::min(axis.servo.position, *axis.stop);
    if (axis.taut) holdByLine(axis);
    if (axis.state == AxisState::kClosedLoop) {
      axis.largest_limit_A = std::max(axis.largest_limit_A, axis.current_limit_A);
      axis.largest_lead =
          std::max(axis.largest_lead, std::abs(axis.servo.goal - axis.servo.position));
      axis.largest_current_A =
          std::max(axis.largest_current_A, std::abs(double{currentOf(node)}));
    }
    if (axis.is_unplugged || now < axis.boots_until) continue;
    if (is_beat) {
      odrive::Heartbeat heartbeat;
      heartbeat.error = axis.error;
      heartbeat.state = axis.state;
      said_.push_back(odrive::makeHeartbeat(node, heartbeat, firmware_));
    }
    if (is_estimate) sayEstimates(node);
  }
}

void ODriveEmulator::sayEstimates(int node) {
  const EmulatedServo& servo = axes_.at(node).servo;
  said_.push_back(
      odrive::makeFloatPair(node, Command::kGetEncoderEstimates,
                            {static_cast<float>(servo.position + axes_.at(node).counts_from),
                             static_cast<float>(servo.velocity)}));
}

// A taut line is not wound in farther than the axis' current pulls it; but fingers bend before
// it pulls harder than kBlockedCurrent.
void ODriveEmulator::holdByLine(Axis& axis) {
  const double pull = std::max(axis.current_limit_A - axis.current_A, 0.0);
  if (pull >= double{kBlockedCurrent}) return;
  const double farthest = pull / kTautCurrent;
  const double wound = axis.winds * (axis.servo.position - *axis.taut);
  if (wound > farthest) axis.servo.position = *axis.taut + axis.winds * farthest;
}

void ODriveEmulator::restart(int node, Duration boot) {
  Axis& axis = axes_.at(node);
  axis.counts_from = -axis.servo.position;
  axis.servo.goal = axis.servo.position;
  axis.state = AxisState::kIdle;
  axis.error = 0;
  axis.current_limit_A = 10;
  axis.boots_until = time_ + boot;
}

float ODriveEmulator::currentOf(int node) const {
  const Axis& axis = axes_.at(node);
  if (axis.taut && axis.state == AxisState::kClosedLoop) {
    const double wound = axis.winds * (axis.servo.position - *axis.taut);
    const double pull = std::clamp(kTautCurrent * wound, 0.0, double{kBlockedCurrent});
    return static_cast<float>(axis.winds * (axis.current_A + pull));
  }
  const bool is_blocked = axis.stop && axis.state == AxisState::kClosedLoop &&
                          axis.servo.position >= *axis.stop && axis.servo.goal > *axis.stop;
  if (!is_blocked) return axis.current_A;
  return std::min(kBlockedCurrent, static_cast<float>(axis.current_limit_A));
}

void ODriveEmulator::answer(int node, std::uint8_t command) {
  if (command == static_cast<std::uint8_t>(Command::kGetEncoderEstimates)) sayEstimates(node);
  if (command == static_cast<std::uint8_t>(Command::kGetTemperature) &&
      firmware_ == odrive::Firmware::k06) {
    said_.push_back(odrive::makeFloatPair(node, Command::kGetTemperature, axes_.at(node).heat));
  }
  const bool tells = axes_.at(node).tells_current;
  if (tells && command == static_cast<std::uint8_t>(Command::kGetIq))
    said_.push_back(odrive::makeFloatPair(node, Command::kGetIq, {0.5f, currentOf(node)}));
}

void ODriveEmulator::hear(const CanFrame& frame, TimePoint now) {
  advance(now);
  const auto address = odrive::addressOf(frame);
  if (!address || axes_.count(address->node) == 0) return;
  Axis& axis = axes_.at(address->node);
  if (axis.is_unplugged || now < axis.boots_until) return;
  axis.heard = now;
  if (frame.is_remote) return answer(address->node, address->command);
  if (const auto state = odrive::axisStateOf(frame)) {
    if (*state == AxisState::kClosedLoop && axis.error != 0) return;
    if (axis.error == 0 || *state == AxisState::kIdle) axis.state = *state;
  }
  if (const auto input = odrive::inputPositionOf(frame))
    axis.servo.goal = input->position_rev - axis.counts_from;
  if (const auto limits = odrive::limitsOf(frame)) {
    axis.servo.speed = limits->first;
    axis.current_limit_A = limits->second;
  }
  if (const auto told = odrive::absolutePositionOf(frame); told && axis.takes_positions) {
    axis.counts_from = *told - axis.servo.position;
    axis.servo.goal = axis.servo.position;
  }
  if (address->command == static_cast<std::uint8_t>(Command::kEstop))
    fail(axis, odrive::kEstopRequested);
  if (address->command == static_cast<std::uint8_t>(Command::kClearErrors) && !axis.is_broken)
    axis.error = 0;
}

std::vector<CanFrame> ODriveEmulator::takeFrames() {
  return std::exchange(said_, {});
}

// === The adapter

void SlcanEmulator::advance(TimePoint now) {
  bus_.advance(now);
  passOn(now);
}

void SlcanEmulator::hear(protocols::Bytes bytes, TimePoint now) {
  reader_.feed(bytes, [&](protocols::Bytes content) {
    const auto line = protocols::slcan::lineOf(content);
    if (line.kind != protocols::slcan::Line::Kind::kFrame) {
      obey({content.begin(), content.end()}, now);
    } else if (is_open) {
      if (answers) sayText("z\r", now);
      bus_.hear(line.frame, now);
    } else {
      sayText("\a", now);
    }
  });
  passOn(now);
}

void SlcanEmulator::obey(const std::string& line, TimePoint now) {
  bool is_fine = true;
  switch (line[0]) {
    case 'C':
      is_fine = std::exchange(is_open, false);
      break;
    case 'O':
      is_open = true;
      break;
    case 'S':
      is_fine = !is_open;
      if (is_fine) rate = line.at(1);
      break;
    default:
      is_fine = line == "\r";
  }
  if (answers) sayText(is_fine ? "\r" : "\a", now);
}

void SlcanEmulator::sayText(const std::string& text, TimePoint now) {
  say(bytesOf(text), now);
}

void SlcanEmulator::passOn(TimePoint now) {
  for (const CanFrame& frame : bus_.takeFrames()) {
    protocols::ByteBuffer line;
    protocols::slcan::encode(frame, line);
    if (is_open) say(line.bytes(), now);
  }
}

}  // namespace handgraft::test
