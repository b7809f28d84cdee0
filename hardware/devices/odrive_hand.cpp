#include "hardware/devices/odrive_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"

namespace handgraft::devices {

namespace odrive = protocols::odrive;
using odrive::AxisState;
using odrive::Command;
using protocols::CanFrame;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kAttempts = 3;
constexpr std::chrono::milliseconds kRepeat(20);  // of orders that wait to be obeyed
constexpr double kFarthestRevolutions = 1e5;      // a float there still tells 0.01 rev
constexpr int kLongestBacklog = 1024;             // frames; 2 s of three axes
constexpr std::uint32_t kWatchdogExpired05 = 0x800;
constexpr std::chrono::milliseconds kHeartbeatDelay(200);  // twice their period
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRecounted =
    0.01;  // rev: an axis that stands still tells its new count so well

}  // namespace

ODriveHand::ODriveHand(ODriveConfig config, CanChannel& can, Clock clock)
    : config_(std::move(config)), can_(can), clock_(std::move(clock)) {
  if (config_.axes.empty()) rejectInput("an ODrive hand without axes");
  std::array<bool, odrive::kHighestNode + 1> is_taken{};
  for (const ODriveAxis& axis : config_.axes) {
    const std::string name = fmt::format("of node {}", axis.node);
    if (axis.node < 0 || axis.node > odrive::kHighestNode)
      rejectInput("motor {} is outside 0 to {}", name, odrive::kHighestNode);
    if (std::exchange(is_taken[static_cast<std::size_t>(axis.node)], true))
      rejectInput("motor {} is there twice", name);
    validate(axis.scale, name, -kFarthestRevolutions, kFarthestRevolutions);
    for (const double limit : {axis.velocity_limit_rev_s, axis.current_limit_A}) {
      if (!(limit > 0.0) || !(limit < 1e4))
        rejectInput("motor {}: limit {} is outside 0 to 10000", name, limit);
    }
  }
  if (config_.reply_timeout <= Duration::zero() || config_.tolerated_misses < 0 ||
      config_.heartbeat_timeout <= Duration::zero() ||
      config_.state_timeout <= Duration::zero() || config_.watchdog <= Duration::zero()) {
    rejectInput("ODrive timings have to be positive");
  }
  known_.resize(config_.axes.size());
}

DeviceCounters ODriveHand::counters() const {
  DeviceCounters counters = counters_;
  counters.damaged = can_.damaged();
  return counters;
}

void ODriveHand::doOpen() {
  can_.open();
  expects_power_ = is_watchdog_proved_ = false;
  Known nothing{};
  nothing.current_A = nothing.temperature = kNaN;
  std::fill(known_.begin(), known_.end(), nothing);
  const TimePoint start = clock_();
  setStates(AxisState::kIdle);
  listen(config_.heartbeat_timeout, [&] {
    return haveHeartbeatsSince(start);
  });
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (known_[i].has_heartbeat) continue;
    throw DeviceError(fmt::format("ODrive node {}: no heartbeat", config_.axes[i].node));
  }
  if (!reach(AxisState::kIdle, [&] {
        setStates(AxisState::kIdle);
      }))
    throw DeviceError("an ODrive axis does not become idle");
  setLimits();  // whoever was here before may have left others
  for (int attempt = 0; attempt < kAttempts && !ask(); ++attempt) {
  }
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (known_[i].has_estimates) continue;
    throw DeviceError(fmt::format("ODrive node {}: no estimates", config_.axes[i].node));
  }
  for (int attempt = 0; attempt < kAttempts && !askForCurrents(); ++attempt) {
  }
  findFaults(clock_());
}

void ODriveHand::doArm() {
  bool has_answered = false;
  for (int attempt = 0; attempt < kAttempts && !has_answered; ++attempt)
    has_answered = ask();
  if (!has_answered) throw DeviceError("an ODrive axis does not tell its position");
  findFaults(clock_());
  if (fault()) throw DeviceError("cannot arm: " + describe(fault()));

  std::vector<float> here;
  for (const Known& known : known_)
    here.push_back(known.estimates.first);
  closeLoops(here);
  if (!is_watchdog_proved_) {
    proveWatchdogs();
    closeLoops(here);
  }
  expects_power_ = true;
}

void ODriveHand::closeLoops(const std::vector<float>& here) {
  const auto hold = [&] {
    yieldToStop();
    for (std::size_t i = 0; i < here.size(); ++i)
      can_.send(odrive::setInputPosition(config_.axes[i].node, here[i]));
  };
  for (const ODriveAxis& axis : config_.axes) {
    can_.send(odrive::setControllerMode(axis.node, odrive::ControlMode::kPosition,
                                        odrive::InputMode::kPassthrough));
  }
  setLimits();
  hold();  // before the power comes: an old target would be run to at once
  setStates(AxisState::kClosedLoop);
  if (reach(AxisState::kClosedLoop, hold)) return;
  findFaults(clock_());
  throw DeviceError(fault() ? "cannot arm: " + describe(fault())
                            : "an ODrive axis does not close its loop");
}

// Nothing is sent, since every message feeds a watchdog.
void ODriveHand::proveWatchdogs() {
  const TimePoint start = clock_();
  const auto have_fired = [&] {
    return haveHeartbeatsSince(start) &&
           std::all_of(known_.begin(), known_.end(), [&](const Known& known) {
             return isWatchdogsAlone(known.heartbeat) &&
                    known.heartbeat.state != AxisState::kClosedLoop;
           });
  };
  const Duration patience = config_.watchdog + config_.watchdog / 2 + kHeartbeatDelay;
  bool is_proved = false;
  while (!is_proved && clock_() - start < patience) {
    yieldToStop();
    is_proved = listen(kRepeat, have_fired);
  }
  for (std::size_t i = 0; !is_proved && i < known_.size(); ++i) {
    const odrive::Heartbeat& heartbeat = known_[i].heartbeat;
    if (isWatchdogsAlone(heartbeat)) continue;
    const auto kind = heartbeat.isFaulty() ? Fault::Kind::kHardware : Fault::Kind::kNoWatchdog;
    latch({kind, static_cast<int>(i), heartbeat.error});
    if (heartbeat.isFaulty()) throw DeviceError("cannot arm: " + describe(fault()));
    throw DeviceError(fmt::format(
        "ODrive node {}: its watchdog did not switch it off within {:.4g} ms of silence: save "
        "enable_watchdog and a watchdog_timeout of {:.4g} s on it",
        config_.axes[i].node, std::chrono::duration<double, std::milli>(patience).count(),
        std::chrono::duration<double>(config_.watchdog).count()));
  }
  // What was provoked is forgotten again.
  const auto is_clear = [&] {
    return std::none_of(known_.begin(), known_.end(), [](const Known& known) {
      return known.heartbeat.isFaulty();
    });
  };
  const TimePoint cleared = clock_();
  bool is_done = false;
  while (!is_done && clock_() - cleared < config_.state_timeout) {
    yieldToStop();
    setStates(AxisState::kIdle);
    for (const ODriveAxis& axis : config_.axes)
      can_.send(odrive::clearErrors(axis.node));
    is_done = listen(kRepeat, [&] {
      return haveHeartbeatsSince(cleared) && is_clear();
    });
  }
  if (!is_done) throw DeviceError("an ODrive axis does not forget its watchdog's error");
  is_watchdog_proved_ = true;
}

bool ODriveHand::isWatchdogsAlone(const odrive::Heartbeat& heartbeat) const {
  const std::uint32_t watchdog =
      config_.firmware == odrive::Firmware::k06 ? odrive::kWatchdogExpired : kWatchdogExpired05;
  return heartbeat.error == watchdog;
}

// The count itself is the sign: an axis that restarts counts from 0 again.
bool ODriveHand::doRecount(std::size_t motor, double encoder_rad) {
  if (config_.firmware != odrive::Firmware::k06) return false;  // 0.5 knows counts alone
  const auto wanted = static_cast<float>(encoder_rad / kTurn);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    can_.send(odrive::setAbsolutePosition(config_.axes[motor].node, wanted));
    if (ask() && std::abs(known_[motor].estimates.first - wanted) < kRecounted) return true;
  }
  return false;
}

void ODriveHand::doRead(DeviceState& state) {
  const auto ask_current = [this](std::size_t i) {
    ++known_[i].current_misses;
    can_.send(odrive::askFor(config_.axes[i].node, Command::kGetIq));
  };
  // Answers of what was asked in the last cycle are at hand now, without waiting.
  drain();
  ask_current(turn_);
  if (attended_ && *attended_ != turn_) ask_current(*attended_);
  if (config_.firmware == odrive::Firmware::k06)
    can_.send(odrive::askFor(config_.axes[turn_].node, Command::kGetTemperature));
  turn_ = (turn_ + 1) % config_.axes.size();
  ask();
  state.time = TimePoint::max();
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const Known& known = known_[i];
    const MotorScale& scale = config_.axes[i].scale;
    if (!known.has_estimates) continue;
    state.time = std::min(state.time, known.estimates_time);
    state.position[i] = scale.angle(known.estimates.first);
    state.velocity[i] = scale.direction * scale.rad_per_unit * known.estimates.second;
    const bool is_old = known.current_misses > config_.tolerated_misses;
    state.current[i] = is_old ? kNaN : scale.direction * known.current_A;
    state.temperature[i] = known.temperature;
  }
  findFaults(clock_());
}

std::string ODriveHand::meaningOf(std::uint32_t code) const {
  // Firmware 0.6; that of 0.5 has other bits for the same.
  static constexpr std::array<ErrorBit, 22> k06 = {{{0x1, "initializing"},
                                                    {0x2, "system level"},
                                                    {0x4, "timing"},
                                                    {0x8, "missing estimate"},
                                                    {0x10, "bad config"},
                                                    {0x20, "driver fault"},
                                                    {0x40, "missing input"},
                                                    {0x100, "DC bus over voltage"},
                                                    {0x200, "DC bus under voltage"},
                                                    {0x400, "DC bus over current"},
                                                    {0x800, "DC bus over regeneration current"},
                                                    {0x1000, "current limit violation"},
                                                    {0x2000, "motor over temperature"},
                                                    {0x4000, "inverter over temperature"},
                                                    {0x8000, "velocity limit violation"},
                                                    {0x10000, "position limit violation"},
                                                    {0x1000000, "watchdog timer expired"},
                                                    {0x2000000, "emergency stop requested"},
                                                    {0x4000000, "spinout detected"},
                                                    {0x8000000, "brake resistor disarmed"},
                                                    {0x10000000, "thermistor disconnected"},
                                                    {0x40000000, "calibration"}}};
  static constexpr std::array<ErrorBit, 2> k05 = {
      {{0x800, "watchdog timer expired"}, {0x4000, "emergency stop requested"}}};
  return config_.firmware == odrive::Firmware::k06 ? wordsOf(code, k06) : wordsOf(code, k05);
}

void ODriveHand::doWrite(std::span<const double> targets) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const ODriveAxis& axis = config_.axes[i];
    can_.send(odrive::setInputPosition(axis.node, axis.scale.floatUnits(targets[i])));
  }
}

bool ODriveHand::doDisarm() {
  expects_power_ = false;
  setStates(AxisState::kIdle);
  return reach(AxisState::kIdle, [&] {
    setStates(AxisState::kIdle);
  });
}

void ODriveHand::doStop() {
  expects_power_ = false;
  for (const ODriveAxis& axis : config_.axes)
    can_.send(odrive::estop(axis.node));
}

void ODriveHand::doHeal() {
  expects_power_ = false;
  setStates(AxisState::kIdle);
  for (const ODriveAxis& axis : config_.axes)
    can_.send(odrive::clearErrors(axis.node));
}

// === The bus

void ODriveHand::take(const CanFrame& frame) {
  ++counters_.frames;
  const auto address = odrive::addressOf(frame);
  const auto axis =
      std::find_if(config_.axes.begin(), config_.axes.end(), [&](const ODriveAxis& candidate) {
        return address && candidate.node == address->node;
      });
  if (axis == config_.axes.end()) {
    ++counters_.stray;
    return;
  }
  Known& known = known_[static_cast<std::size_t>(axis - config_.axes.begin())];
  if (const auto heartbeat = odrive::heartbeatOf(frame, config_.firmware)) {
    // It may have restarted, and forgotten a watchdog that was not saved on it.
    if (known.has_heartbeat && clock_() - known.heartbeat_time > kHeartbeatDelay)
      is_watchdog_proved_ = false;
    known.heartbeat = *heartbeat;
    known.heartbeat_time = clock_();
    known.has_heartbeat = true;
  } else if (const auto estimates = odrive::encoderEstimatesOf(frame)) {
    if (!std::isfinite(estimates->first) || !std::isfinite(estimates->second)) return;
    known.estimates = *estimates;
    known.estimates_time = clock_();
    known.is_answered = known.has_estimates = true;
    known.misses = 0;
  } else if (const auto iq = odrive::iqOf(frame)) {
    known.current_A = iq->second;
    known.current_misses = 0;
  } else if (const auto hot = odrive::temperatureOf(frame);
             hot && config_.firmware == odrive::Firmware::k06) {
    // A motor without a thermistor tells 0 or NaN.
    known.temperature = std::fmax(hot->first, hot->second);
  } else {
    ++counters_.stray;
  }
}

template <class Done>
bool ODriveHand::listen(Duration time, Done&& is_done) {
  const TimePoint deadline = clock_() + time;
  CanFrame frame;
  while (!is_done()) {
    if (!can_.receive(frame, deadline)) return is_done();
    take(frame);
    // On a bus that is never silent, `receive` alone would never say that time is up.
    if (clock_() > deadline) return is_done();
  }
  return true;
}

void ODriveHand::drain() {
  CanFrame frame;
  const TimePoint now = clock_();
  for (int i = 0; i < kLongestBacklog && can_.receive(frame, now); ++i)
    take(frame);
}

bool ODriveHand::ask() {
  drain();
  for (std::size_t i = 0; i < known_.size(); ++i) {
    known_[i].is_answered = false;
    ++known_[i].misses;
    can_.send(odrive::askFor(config_.axes[i].node, Command::kGetEncoderEstimates));
  }
  const bool has_all = listen(config_.reply_timeout, [&] {
    return std::all_of(known_.begin(), known_.end(), [](const Known& known) {
      return known.is_answered;
    });
  });
  for (const Known& known : known_)
    counters_.missed += known.is_answered ? 0 : 1;
  return has_all;
}

bool ODriveHand::askForCurrents() {
  for (const ODriveAxis& axis : config_.axes)
    can_.send(odrive::askFor(axis.node, Command::kGetIq));
  return listen(config_.reply_timeout, [&] {
    return std::none_of(known_.begin(), known_.end(), [](const Known& known) {
      return std::isnan(known.current_A);
    });
  });
}

template <class Again>
bool ODriveHand::reach(AxisState state, Again&& again) {
  const TimePoint start = clock_();
  const auto is_reached = [&] {
    return haveHeartbeatsSince(start) &&
           std::all_of(known_.begin(), known_.end(), [&](const Known& known) {
             return known.heartbeat.state == state;
           });
  };
  while (clock_() - start < config_.state_timeout) {
    if (listen(kRepeat, is_reached)) return true;
    again();
  }
  return false;
}

void ODriveHand::setLimits() {
  for (const ODriveAxis& axis : config_.axes) {
    can_.send(odrive::setLimits(axis.node, static_cast<float>(axis.velocity_limit_rev_s),
                                static_cast<float>(axis.current_limit_A)));
  }
}

void ODriveHand::setStates(AxisState state) {
  for (const ODriveAxis& axis : config_.axes)
    can_.send(odrive::setAxisState(axis.node, state));
}

bool ODriveHand::haveHeartbeatsSince(TimePoint time) const {
  return std::all_of(known_.begin(), known_.end(), [&](const Known& known) {
    return known.has_heartbeat && known.heartbeat_time > time;
  });
}

void ODriveHand::findFaults(TimePoint now) {
  const std::uint32_t watchdog =
      config_.firmware == odrive::Firmware::k06 ? odrive::kWatchdogExpired : kWatchdogExpired05;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const Known& known = known_[i];
    const odrive::Heartbeat& heartbeat = known.heartbeat;
    const int motor = static_cast<int>(i);
    if ((heartbeat.error & watchdog) != 0)
      latch({Fault::Kind::kWatchdog, motor, heartbeat.error});
    if (heartbeat.isFaulty()) latch({Fault::Kind::kHardware, motor, heartbeat.error});
    const bool is_owed = known.misses > config_.tolerated_misses &&
                         (expects_power_ || now - known.estimates_time > kIdlePatience);
    if (is_owed || now - known.heartbeat_time > config_.heartbeat_timeout) {
      latch({Fault::Kind::kSilent, motor, 0});
    }
    if (expects_power_ && heartbeat.state != AxisState::kClosedLoop)
      latch({Fault::Kind::kPowerLost, motor, heartbeat.error});
  }
}

}  // namespace handgraft::devices
