#include "hardware/devices/inspire_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "hardware/devices/stream_replies.h"

namespace handgraft::devices {

namespace inspire = protocols::inspire;
namespace modbus = protocols::modbus;

namespace {

constexpr int kAttempts = 3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, inspire::kMotorCount> kNames = {
    "little", "ring", "middle", "index", "thumb bending", "thumb turning"};

// Two bytes a register: the first finger's is the low one.
std::uint8_t byteOf(std::span<const std::uint16_t> registers, std::size_t finger) {
  const std::uint16_t both = registers[finger / 2];
  return static_cast<std::uint8_t>(finger % 2 == 0 ? both & 0xFF : both >> 8);
}

}  // namespace

InspireHand::InspireHand(const InspireConfig& config, ByteChannel& bytes, Clock clock)
    : config_(config), bytes_(bytes), clock_(std::move(clock)) {
  for (std::size_t i = 0; i < config_.scales.size(); ++i)
    validate(config_.scales[i], kNames[i], 0, inspire::kFullAngle);
  auto sorted = config_.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (sorted[i] != i) rejectInput("Inspire order: motor {} is not there once", i);
  }
  if (config_.address == 0 || config_.address > 254)
    rejectInput("Inspire address {} is outside 1 to 254", config_.address);
  if (!(config_.force_N >= 0.1) || !(config_.force_N <= 9.8))
    rejectInput("Inspire force {} N is outside 0.1 to 9.8", config_.force_N);
  if (config_.speed == 0 || config_.speed > inspire::kFullSpeed)
    rejectInput("Inspire speed {} is outside 1 to {}", config_.speed, inspire::kFullSpeed);
  if (config_.reply_timeout <= Duration::zero() || config_.tolerated_misses < 0)
    rejectInput("Inspire timings have to be positive");
}

DeviceCounters InspireHand::counters() const {
  return withFramesOf(reader_, counters_);
}

std::string InspireHand::meaningOf(std::uint32_t code) const {
  static constexpr std::array<ErrorBit, 5> kBits = {
      {{inspire::kStalled, "stalled"},
       {inspire::kOverheated, "overheated"},
       {inspire::kOverCurrent, "over current"},
       {inspire::kMotor, "motor"},
       {inspire::kCommunication, "communication"}}};
  return wordsOf(code, kBits);
}

void InspireHand::doOpen() {
  bytes_.open();
  expects_power_ = is_owed_ = false;
  misses_ = 0;
  velocities_.fill(0.0);
  currents_.fill(kNaN);
  temperatures_.fill(kNaN);
  errors_.fill(0);
  writeSurely(inspire::kSpeedSet, {}, "its speeds");
  readSurely(inspire::kAngleAct, angles_, "its angles");
  time_ = clock_();
  for (int i = 0; i < 4; ++i)
    readOneMore();
  findFaults();
}

void InspireHand::doArm() {
  readSurely(inspire::kAngleAct, angles_, "its angles");
  time_ = clock_();
  Registers here{}, forces{}, speeds{}, told{};
  for (std::size_t i = 0; i < here.size(); ++i) {
    here[i] = std::min(angles_[i], inspire::kFullAngle);
    const double grams = config_.force_N / inspire::kNewtonPerGram;
    forces[i] = static_cast<std::uint16_t>(
        std::clamp(grams, 1.0, static_cast<double>(inspire::kFullForce)));
    speeds[i] = config_.speed;
  }
  yieldToStop();
  writeSurely(inspire::kForceSet, forces, "its forces");
  yieldToStop();
  writeSurely(inspire::kAngleSet, here,
              "its targets");  // before the speed, which is its switch
  readSurely(inspire::kAngleSet, told, "its targets");
  if (told != here) throw DeviceError("the Inspire hand does not keep its targets");
  yieldToStop();
  writeSurely(inspire::kSpeedSet, speeds, "its speeds");
  expects_power_ = true;
}

void InspireHand::doRead(DeviceState& state) {
  takeWhatIsOwed();
  const Registers before = angles_;
  if (read(inspire::kAngleAct, angles_)) {
    const TimePoint now = clock_();
    const double seconds = std::chrono::duration<double>(now - time_).count();
    for (std::size_t i = 0; seconds > 0 && i < angles_.size(); ++i)
      velocities_[i] = (angles_[i] - before[i]) / seconds;
    time_ = now;
    misses_ = 0;
    readOneMore();
  } else {
    angles_ = before;
    const bool is_silent = expects_power_ || clock_() - time_ > kIdlePatience;
    if (++misses_ > config_.tolerated_misses && is_silent) latch({Fault::Kind::kSilent, -1, 0});
  }
  state.time = time_;
  for (std::size_t ours = 0; ours < angles_.size(); ++ours) {
    const std::size_t i = config_.order[ours];
    const MotorScale& scale = config_.scales[i];
    state.position[ours] = scale.angle(angles_[i]);
    state.velocity[ours] = scale.direction * scale.rad_per_unit * velocities_[i];
    state.current[ours] = currents_[i];
    state.temperature[ours] = temperatures_[i];
    // A finger that was stopped by its force limit does as it is told.
    state.limited[ours] = (errors_[i] & inspire::kStalled) != 0 ? 1 : 0;
  }
  findFaults();
}

void InspireHand::findFaults() {
  for (std::size_t ours = 0; ours < errors_.size(); ++ours) {
    const auto error =
        static_cast<std::uint8_t>(errors_[config_.order[ours]] & ~inspire::kStalled);
    if (error != 0) latch({Fault::Kind::kHardware, static_cast<int>(ours), error});
  }
}

// One of what changes slowly.
void InspireHand::readOneMore() {
  Registers told{};
  std::array<std::uint16_t, inspire::kMotorCount / 2> bytes{};
  const auto signed_of = [&](std::size_t i) {
    return static_cast<double>(static_cast<std::int16_t>(told[i]));
  };
  switch (turn_++ % 4) {
    case 0:
      if (!read(inspire::kError, bytes)) return;
      for (std::size_t i = 0; i < errors_.size(); ++i)
        errors_[i] = byteOf(bytes, i);
      return;
    case 1:
      if (!read(inspire::kForceAct, told)) return;
      for (std::size_t i = 0; i < told.size(); ++i)
        forces_[i] = inspire::kNewtonPerGram * signed_of(i);
      return;
    case 2:
      if (!read(inspire::kCurrentAct, told)) return;
      for (std::size_t i = 0; i < told.size(); ++i)
        currents_[i] = 1e-3 * signed_of(i);
      return;
    default:
      if (!read(inspire::kTemperature, bytes)) return;
      for (std::size_t i = 0; i < temperatures_.size(); ++i)
        temperatures_[i] = byteOf(bytes, i);
      return;
  }
}

void InspireHand::doWrite(std::span<const double> targets) {
  takeWhatIsOwed();
  Registers goals{};
  for (std::size_t ours = 0; ours < goals.size(); ++ours) {
    const std::size_t i = config_.order[ours];
    goals[i] = static_cast<std::uint16_t>(
        config_.scales[i].wholeUnits(targets[ours], 0, inspire::kFullAngle));
  }
  modbus::encodeWrite(config_.address, inspire::kAngleSet, goals, out_);
  ask();
  is_owed_ = true;
}

bool InspireHand::doDisarm() {
  expects_power_ = false;
  takeWhatIsOwed();
  writeSurely(inspire::kSpeedSet, {}, "its speeds");
  Registers told{};
  readSurely(inspire::kSpeedSet, told, "its speeds");
  return told == Registers{};
}

void InspireHand::doStop() {
  expects_power_ = is_owed_ = false;
  modbus::encodeWrite(config_.address, inspire::kSpeedSet, Registers{}, out_);
  bytes_.send(out_.bytes());
}

void InspireHand::doHeal() {
  doStop();
  const std::array<std::uint16_t, 1> one = {1};
  modbus::encodeWrite(config_.address, inspire::kClearError, one, out_);
  ask();
  static_cast<void>(take(modbus::kWriteRegisters, {}));
}

// === The wire

void InspireHand::ask() {
  bytes_.discard();
  reader_.clear();
  bytes_.send(out_.bytes());
}

bool InspireHand::take(std::uint8_t function, std::span<std::uint16_t> into) {
  return awaitReply(bytes_, reader_, clock_() + config_.reply_timeout, counters_,
                    [&](protocols::Bytes content) {
                      const auto reply = modbus::replyOf(content);
                      const bool fits = reply && reply->device == config_.address &&
                                        reply->function == function &&
                                        (function != modbus::kReadRegisters ||
                                         reply->values.size() == 2 * into.size());
                      if (!fits) return false;
                      for (std::size_t i = 0; i < into.size(); ++i)
                        into[i] = modbus::registerAt(reply->values, i);
                      return true;
                    });
}

bool InspireHand::read(std::uint16_t address, std::span<std::uint16_t> into) {
  modbus::encodeRead(config_.address, address, static_cast<std::uint16_t>(into.size()), out_);
  ask();
  return take(modbus::kReadRegisters, into);
}

void InspireHand::readSurely(std::uint16_t address,
                             std::span<std::uint16_t> into,
                             const char* what) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (read(address, into)) return;
  }
  throw DeviceError(fmt::format("the Inspire hand does not tell {}", what));
}

void InspireHand::writeSurely(std::uint16_t address,
                              const Registers& values,
                              const char* what) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    modbus::encodeWrite(config_.address, address, values, out_);
    ask();
    if (take(modbus::kWriteRegisters, {})) return;
  }
  throw DeviceError(fmt::format("the Inspire hand does not take {}", what));
}

// The line carries one at a time: what was written last is answered before the next question.
void InspireHand::takeWhatIsOwed() {
  if (!std::exchange(is_owed_, false)) return;
  static_cast<void>(take(modbus::kWriteRegisters, {}));
}

}  // namespace handgraft::devices
