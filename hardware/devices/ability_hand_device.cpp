#include "hardware/devices/ability_hand_device.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "hardware/devices/stream_replies.h"

namespace handgraft::devices {

namespace ah = protocols::ability_hand;

namespace {

constexpr std::array<const char*, ah::kMotorCount> kNames = {
    "index", "middle", "ring", "pinky", "thumb flexor", "thumb rotator"};
constexpr std::chrono::milliseconds kDeviceWatchdog(300);
constexpr int kAttempts = 3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

AbilityHandDevice::AbilityHandDevice(AbilityHandConfig config, ByteChannel& bytes, Clock clock)
    : config_(config), bytes_(bytes), clock_(std::move(clock)) {
  for (std::size_t i = 0; i < scales_.size(); ++i) {
    scales_[i] = {ah::kRadPerCount, 0.0, 1, config_.lower[i], config_.upper[i]};
    validate(scales_[i], kNames[i], -ah::kLargestCount, ah::kLargestCount);
  }
  auto sorted = config_.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (sorted[i] != i) rejectInput("Ability Hand order: motor {} is not there once", i);
  }
  if (config_.address == 0) rejectInput("Ability Hand address 0 is outside 1 to 255");
  if (config_.reply_timeout <= Duration::zero() || config_.tolerated_misses < 0 ||
      config_.hot_patience < Duration::zero()) {
    rejectInput("Ability Hand timings have to be positive");
  }
  if (config_.longest_gap <= Duration::zero() || config_.longest_gap >= kDeviceWatchdog)
    rejectInput("Ability Hand gap is outside 0 to 300 ms");
}

std::size_t AbilityHandDevice::motorCount() const {
  return ah::kMotorCount;
}

DeviceCounters AbilityHandDevice::counters() const {
  return withFramesOf(reader_, counters_);
}

std::span<const double> AbilityHandDevice::touch() const {
  if (config_.reply == ah::Reply::kMotors) return {};
  return touch_;
}

void AbilityHandDevice::doOpen() {
  bytes_.open();
  obeys_ = is_owed_ = false;
  misses_ = 0;
  // Whoever commanded it before us does so no more.
  doStop();
  askSurely();
  free_time_.fill(time_);
}

void AbilityHandDevice::doArm() {
  askSurely();
  ah::Counts here = last_.position;
  for (std::int16_t& count : here)
    count = std::max(count, static_cast<std::int16_t>(-ah::kLargestCount));
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    yieldToStop();
    ah::encodeCommand(config_.address, ah::Mode::kPosition, config_.reply, here, out_);
    send();
    if (!takeReply()) continue;
    obeys_ = true;
    free_time_.fill(time_);
    return;
  }
  throw DeviceError("the Ability Hand does not answer");
}

void AbilityHandDevice::doRead(DeviceState& state) {
  const TimePoint now = clock_();
  if (obeys_ && now - sent_time_ > config_.longest_gap) {
    latch({Fault::Kind::kStarved, -1, 0});
    return;
  }
  if (!is_owed_) askForState();
  if (takeReply()) {
    misses_ = 0;
  } else if (++misses_ > config_.tolerated_misses && (obeys_ || now - time_ > kIdlePatience)) {
    latch({Fault::Kind::kSilent, -1, 0});
  }
  for (std::size_t i = 0; i < touch_.size(); ++i)
    touch_[i] = ah::touchForce(last_.touch[i]);
  const bool has_velocity = last_.reply != ah::Reply::kTouchCurrent;
  const bool has_current = last_.reply != ah::Reply::kTouchVelocity;
  state.time = time_;
  for (std::size_t ours = 0; ours < ah::kMotorCount; ++ours) {
    const std::size_t i = config_.order[ours];
    state.position[ours] = scales_[i].angle(last_.position[i]);
    state.velocity[ours] =
        has_velocity ? last_.velocity[i] * ah::kRotorRadPerSecondPerCount / ah::kGearRatio[i]
                     : kNaN;
    state.current[ours] = has_current ? last_.current[i] * ah::kAmperePerCount : kNaN;
    state.limited[ours] = static_cast<std::uint8_t>(last_.limited >> i & 1U);
  }
  watchLimited(time_);
}

void AbilityHandDevice::watchLimited(TimePoint now) {
  for (std::size_t ours = 0; ours < ah::kMotorCount; ++ours) {
    const std::size_t i = config_.order[ours];
    if ((last_.limited >> i & 1) == 0) free_time_[i] = now;
    if (obeys_ && now - free_time_[i] > config_.hot_patience)
      latch({Fault::Kind::kHot, static_cast<int>(ours), last_.limited});
  }
}

void AbilityHandDevice::doWrite(std::span<const double> targets) {
  if (clock_() - sent_time_ > config_.longest_gap) {
    latch({Fault::Kind::kStarved, -1, 0});
    return;
  }
  ah::Counts counts;
  for (std::size_t ours = 0; ours < counts.size(); ++ours) {
    const std::size_t i = config_.order[ours];
    counts[i] = static_cast<std::int16_t>(
        scales_[i].wholeUnits(targets[ours], -ah::kLargestCount, ah::kLargestCount));
  }
  ah::encodeCommand(config_.address, ah::Mode::kPosition, config_.reply, counts, out_);
  send();
}

bool AbilityHandDevice::doDisarm() {
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    doStop();
  askSurely();  // so that the hand is known to listen
  return true;
}

void AbilityHandDevice::doStop() {
  obeys_ = is_owed_ = false;
  ah::encodeSimple(config_.address, ah::Simple::kExitApi, out_);
  bytes_.send(out_.bytes());
}

void AbilityHandDevice::doHeal() {
  doStop();
}

// === The wire

void AbilityHandDevice::send() {
  // What comes before the reply to this is late.
  bytes_.discard();
  reader_.clear();
  bytes_.send(out_.bytes());
  sent_time_ = clock_();
  is_owed_ = true;
}

void AbilityHandDevice::askForState() {
  ah::encodeReadOnly(config_.address, config_.reply, out_);
  send();
}

bool AbilityHandDevice::takeReply() {
  is_owed_ = false;
  return awaitReply(bytes_, reader_, clock_() + config_.reply_timeout, counters_,
                    [&](protocols::Bytes content) {
                      const auto state = ah::stateOf(content);
                      if (!state || state->reply != config_.reply) return false;
                      last_ = *state;
                      time_ = clock_();
                      return true;
                    });
}

void AbilityHandDevice::askSurely() {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    askForState();
    if (takeReply()) return;
  }
  throw DeviceError("the Ability Hand does not answer");
}

}  // namespace handgraft::devices
