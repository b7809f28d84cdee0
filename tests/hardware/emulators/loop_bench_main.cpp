// handgraft-loop-bench CONFIG [SECONDS]: the bridge's loop on a thread of its own, driving the
// device that CONFIG tells of, emulated on a tty, at 100, 200 and 500 Hz. A line each: how late
// its periods begin, and the CPU that it takes; and what rate the wire would permit. Figures
// are those of the machine it runs on.
//
// handgraft-loop-bench CONFIG wire MOTORS BAUD: what rate BAUD permits for so many motors of
// the kind, as a config is refused beyond it; and how many cycles a second its driver makes,
// one behind the other, on an emulated tty of that rate.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <sys/resource.h>

#include "core/base/error.h"
#include "hardware/bridge/motion_thread.h"
#include "hardware/config/hand_config_file.h"
#include "hardware/config/wire_load.h"

#include "tests/hardware/emulators/hand_rig.h"

namespace {

using namespace handgraft;
using Clock = std::chrono::steady_clock;

double cpuOfThread() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Another device, and when it is read.
class Probe final : public devices::Device {
 public:
  struct Log {
    std::vector<Clock::time_point> reads;
    double first_cpu_s = 0, last_cpu_s = 0;
  };

  Probe(bridge::DeviceStack inner, Log& log) : inner_(std::move(inner)), log_(log) {}

  [[nodiscard]] std::size_t motorCount() const override { return inner_.device->motorCount(); }

  [[nodiscard]] devices::DeviceCounters counters() const override {
    return inner_.device->counters();
  }

 private:
  void doOpen() override { inner_.device->open(); }

  void doArm() override {
    inner_.device->arm();
    log_.reads.clear();
    log_.first_cpu_s = cpuOfThread();
  }

  void doRead(devices::DeviceState& state) override {
    if (log_.reads.size() < log_.reads.capacity()) log_.reads.push_back(Clock::now());
    log_.last_cpu_s = cpuOfThread();
    static_cast<void>(inner_.device->read(state));
    if (inner_.device->fault()) latch(inner_.device->fault());
  }

  void doWrite(std::span<const double> targets) override {
    static_cast<void>(inner_.device->write(targets));
  }

  bool doDisarm() override { return inner_.device->disarm(); }

  void doStop() override { inner_.device->stop(); }

  void doHeal() override { inner_.device->reset(); }

  bridge::DeviceStack inner_;
  Log& log_;
};

void measure(config::HandConfig config, double rate_hz, double seconds) {
  config.governor.period_s = 1 / rate_hz;
  config.governor.stale_after = std::chrono::seconds(5);
  const bool is_ability_hand = config.device.kind == config::DeviceKind::kAbilityHand;
  // An Ability Hand's own watchdog cannot be made longer.
  config.governor.longest_gap = std::chrono::milliseconds(is_ability_hand ? 290 : 3000);
  config.governor.overruns_in_a_row = 1'000'000;
  config.governor.device_silent_after = std::chrono::seconds(2);
  if (!is_ability_hand) config.device.watchdog = std::chrono::milliseconds(2000);
  config.device.reply_timeout = std::chrono::milliseconds(50);
  config.device.tolerated_misses = 50;
  config.homing.clear();
  const double allowed_hz = config::kWireShare / config::cycleTime(config);
  const auto rig = test::makeHandRig(config, true);
  Probe::Log log;
  log.reads.reserve(static_cast<std::size_t>(2 * rate_hz * seconds) + 1000);
  std::atomic<bool> estop{false};
  const auto make = [&](const config::HandConfig& asked) {
    bridge::DeviceStack stack;
    stack.device = std::make_unique<Probe>(
        bridge::makeDeviceOn(rig->wire().channel(), asked, Clock::now), log);
    return stack;
  };
  double position = 0;
  double late_ms = 0;
  {
    bridge::MotionThread motion(std::make_unique<bridge::Motion>(config, make, Clock::now),
                                estop, std::make_shared<bridge::WakeEvent>());
    const auto end = Clock::now() + std::chrono::duration<double>(seconds + 4);
    std::uint64_t number = 0;
    while (Clock::now() < end) {
      bridge::StreamPose pose;
      pose.stream = 1;
      pose.sequence = ++number;
      pose.arrived = Clock::now();
      pose.names = config.governor.names;
      position = 0.5 + 0.3 * std::sin(0.1 * static_cast<double>(number));
      for (const safety::JointLimits& limits : config.governor.limits)
        pose.joint_rad.push_back(limits.lower + position * (limits.upper - limits.lower));
      motion.offer(std::move(pose));
      if (motion.take() != nullptr && !motion.last().is_powered)
        motion.request(bridge::Request::kArm);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    late_ms = 1e3 * std::chrono::duration<double>(motion.last().worst_lateness).count();
  }
  std::vector<double> off_ms;
  for (std::size_t i = 1; i < log.reads.size(); ++i) {
    const double gap = std::chrono::duration<double>(log.reads[i] - log.reads[i - 1]).count();
    off_ms.push_back(1e3 * std::abs(gap - config.governor.period_s));
  }
  if (off_ms.size() < 10) {
    fmt::print("{:6.0f} Hz: it was not armed\n", rate_hz);
    return;
  }
  std::sort(off_ms.begin(), off_ms.end());
  const double span =
      std::chrono::duration<double>(log.reads.back() - log.reads.front()).count();
  const auto share = [&](double p) {
    return off_ms[static_cast<std::size_t>(p * static_cast<double>(off_ms.size() - 1))];
  };
  fmt::print(
      "{:6.0f} Hz: {:.1f} reached, period off by {:.3f} ms in the median, {:.3f} p99, {:.1f} "
      "at most "
      "(late by {:.1f}), CPU of the loop {:.1f} %; its wire permits {:.0f} Hz\n",
      rate_hz, static_cast<double>(off_ms.size()) / span, share(0.5), share(0.99),
      off_ms.back(), late_ms, 100 * (log.last_cpu_s - log.first_cpu_s) / span, allowed_hz);
  std::fflush(stdout);
}

/// So many motors like the first ones, one behind the other.
void setMotors(config::HandConfig& config, std::size_t count) {
  const std::size_t before = config.motors.size();
  config.motors.resize(count, config.motors.back());
  for (std::size_t i = before; i < count; ++i) {
    config.motors[i].id = config.motors[i - 1].id + 1;
    config.motors[i].name = fmt::format("more {}", i);
  }
}

void measureWire(config::HandConfig config, std::size_t motors, int baud) {
  setMotors(config, motors);
  const bool is_can = config.device.kind == config::DeviceKind::kODrive ||
                      config.device.kind == config::DeviceKind::kAllegro;
  if (is_can) {
    config.device.carrier = config::CanCarrier::kSlcan;
    config.device.can_bitrate = baud;
    config.governor.period_s = 0.01;  // what comes by itself depends on it
  } else {
    config.device.baud = baud;
  }
  const double permitted_hz = config::kWireShare / config::cycleTime(config);
  if (is_can) {  // an emulated bus takes no time
    fmt::print("{:3} motors at {:7}: {:5.0f} Hz permitted\n", motors, baud, permitted_hz);
    return;
  }
  config.device.watchdog = std::chrono::milliseconds(2000);
  config.device.reply_timeout = std::chrono::milliseconds(50);
  config.device.tolerated_misses = 50;
  config.governor.longest_gap = std::chrono::milliseconds(250);
  const auto rig = test::makeHandRig(config, true);
  const bridge::DeviceStack stack =
      bridge::makeDeviceOn(rig->wire().channel(), config, Clock::now);
  stack.device->open();
  stack.device->arm();
  devices::DeviceState state(stack.device->motorCount());
  const auto begin = Clock::now();
  int cycles = 0;
  const auto seconds = [&] {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  while (seconds() < 3 && stack.device->read(state) && stack.device->write(state.position))
    ++cycles;
  const double reached_hz = cycles / seconds();
  const std::uint64_t missed = stack.device->counters().missed;
  stack.device->disarm();
  fmt::print("{:3} motors at {:7}: {:5.0f} Hz permitted, {:5.0f} cycles a second, {} missed\n",
             motors, baud, permitted_hz, reached_hz, missed);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: handgraft-loop-bench CONFIG [SECONDS | wire MOTORS BAUD]\n");
    return 2;
  }
  try {
    const config::HandConfig config = config::readHandConfig(argv[1]);
    if (argc == 5 && std::string(argv[2]) == "wire") {
      const int motors = std::atoi(argv[3]);
      const int baud = std::atoi(argv[4]);
      if (motors < 1 || motors > 64 || baud < 9600)
        rejectInput("MOTORS {} BAUD {}: 1 to 64, at least 9600", argv[3], argv[4]);
      measureWire(config, static_cast<std::size_t>(motors), baud);
      return 0;
    }
    const double seconds = argc > 2 ? std::atof(argv[2]) : 10;
    for (const double rate_hz : std::array{100.0, 200.0, 500.0})
      measure(config, rate_hz, seconds);
  } catch (const InvalidInput& error) {
    fmt::print(stderr, "handgraft-loop-bench: {}\n", error.what());
    return 2;
  }
  return 0;
}
