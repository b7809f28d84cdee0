#include "hardware/devices/examples/line_hand.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::devices {

namespace {

constexpr int kAttempts = 3;
constexpr int kFarthest = 60'000;  // 6 rad either way

}  // namespace

LineHand::LineHand(LineHandConfig config, ByteChannel& bytes, Clock clock)
    : config_(config), clock_(clock), wire_(bytes, std::move(clock), config.reply_timeout) {
  for (std::size_t i = 0; i < config_.scales.size(); ++i)
    validate(config_.scales[i], std::to_string(i), -kFarthest, kFarthest);
}

// Whoever was here before may have left it on.
void LineHand::doOpen() {
  wire_.open();
  expects_power_ = is_owed_ = false;
  misses_ = 0;
  ask("off");
  findFaults();
}

void LineHand::doArm() {
  ask("?");
  const std::chrono::milliseconds watchdog(wire_.told().watchdog_ms);
  if (watchdog <= Duration::zero() || watchdog > config_.watchdog) {
    latch({Fault::Kind::kNoWatchdog, -1, 0});
    throw DeviceError("cannot arm: " + describe(fault()));
  }
  yieldToStop();
  wire_.sayTargets(wire_.told().position);  // to stay where it is, before the power comes
  if (!wire_.hear()) throw DeviceError("the hand does not take its targets");
  yieldToStop();
  ask("on");
  if (wire_.told().state != LineState::kOn) throw DeviceError("the hand does not switch on");
  expects_power_ = true;
}

void LineHand::doRead(DeviceState& state) {
  const TimePoint time = wire_.time();
  if (std::exchange(is_owed_, false)) wire_.hear();  // as it was a period ago
  wire_.say("?");
  if (wire_.hear()) {
    misses_ = 0;
  } else if (++misses_ > config_.tolerated_misses &&
             (expects_power_ || clock_() - time > kIdlePatience)) {
    latch({Fault::Kind::kSilent, -1, 0});
  }
  state.time = wire_.time();
  const double seconds = std::chrono::duration<double>(wire_.time() - time).count();
  for (std::size_t i = 0; i < config_.scales.size(); ++i) {
    const double last = state.position[i];
    state.position[i] = config_.scales[i].angle(wire_.told().position[i]);
    if (seconds > 0) state.velocity[i] = (state.position[i] - last) / seconds;
  }
  findFaults();
}

void LineHand::findFaults() {
  const LineState& told = wire_.told();
  if (told.state == LineState::kBroken) latch({Fault::Kind::kHardware, told.broken_motor, 1});
  if (told.state == LineState::kWatchdogFired) latch({Fault::Kind::kWatchdog, -1, 0});
  if (expects_power_ && told.state != LineState::kOn) latch({Fault::Kind::kPowerLost, -1, 0});
}

void LineHand::doWrite(std::span<const double> targets) {
  LineUnits units{};
  for (std::size_t i = 0; i < units.size(); ++i)
    units[i] = config_.scales[i].wholeUnits(targets[i], -kFarthest, kFarthest);
  wire_.sayTargets(units);
  is_owed_ = true;
}

bool LineHand::doDisarm() {
  expects_power_ = is_owed_ = false;
  ask("off");
  return wire_.told().state != LineState::kOn;
}

// The next thing on the wire, and nothing is waited for.
void LineHand::doStop() {
  expects_power_ = is_owed_ = false;
  wire_.say("off");
}

void LineHand::doHeal() {
  ask("off");
}

void LineHand::ask(const char* text) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    wire_.say(text);
    if (wire_.hear()) return;
  }
  throw DeviceError("the hand does not answer");
}

}  // namespace handgraft::devices
