#include "hardware/config/hand_config.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/config/wire_load.h"
#include "hardware/safety/governor.h"
#include "hardware/tendon/tendon_map.h"

namespace handgraft::config {

namespace {

using std::chrono::milliseconds;
using Problems = std::vector<std::string>;

constexpr double kSlack = 1e-9;  // rad, rad/s: rounding of ranges mapped both ways
constexpr milliseconds kAbilityHandDeadman{300};  // its interface document, section 3

std::vector<tendon::Range> jointRanges(const HandConfig& config) {
  std::vector<tendon::Range> ranges;
  for (const safety::JointLimits& limits : config.governor.limits)
    ranges.push_back({limits.lower, limits.upper});
  return ranges;
}

std::vector<double> travelsOf(const HandConfig& config) {
  std::vector<double> travels;
  for (const safety::JointLimits& limits : config.governor.limits)
    travels.push_back(limits.travel);
  return travels;
}

/// What `make` throws as InvalidInput, under `key`.
template <class Make>
void collect(const char* key, Problems& problems, Make&& make) {
  try {
    make();
  } catch (const InvalidInput& error) {
    problems.push_back(fmt::format("{}: {}", key, error.what()));
  }
}

/// Whether nothing is known to be wrong with what has this key, nor with anything in it.
class Soundness {
 public:
  explicit Soundness(const Problems& known) : known_(known) {}

  [[nodiscard]] bool operator()(const std::string& key) const {
    return std::none_of(known_.begin(), known_.end(), [&key](const std::string& problem) {
      const bool begins = problem.compare(0, key.size(), key) == 0;
      return begins && (problem.size() == key.size() ||
                        std::string(".[: ").find(problem[key.size()]) != std::string::npos);
    });
  }

  [[nodiscard]] bool motor(std::size_t i) const {
    return (*this)(fmt::format("motors[{}]", i));
  }

 private:
  const Problems& known_;
};

void checkMotorsSuffice(const HandConfig& config,
                        const Soundness& is_sound,
                        Problems& problems) {
  const std::unique_ptr<tendon::MotorMap> map = makeMotorMap(config);
  if (map->motorCount() != config.motors.size()) {
    problems.push_back(fmt::format("motors: {} of them, where the transmission needs {}",
                                   config.motors.size(), map->motorCount()));
    return;
  }
  const std::vector<tendon::Range> joints = jointRanges(config);
  std::vector<double> joint_speeds;
  for (const safety::JointLimits& limits : config.governor.limits)
    joint_speeds.push_back(limits.velocity);
  const std::vector<tendon::Range> needed = map->motorRanges(joints);
  const std::vector<double> speeds = map->motorSpeeds(joints, joint_speeds);
  for (std::size_t i = 0; i < needed.size(); ++i) {
    const MotorConfig& motor = config.motors[i];
    if (!is_sound.motor(i)) continue;
    if (needed[i].lower < motor.range_rad.lower - kSlack ||
        needed[i].upper > motor.range_rad.upper + kSlack) {
      problems.push_back(fmt::format(
          "motors[{}].lower_rad, upper_rad: [{}, {}] does not hold the [{:.6g}, {:.6g}] that "
          "the joints' limits ask of {}",
          i, motor.range_rad.lower, motor.range_rad.upper, needed[i].lower, needed[i].upper,
          handgraft::quoted(motor.name)));
    }
    if (speeds[i] > motor.velocity_rad_s + kSlack) {
      problems.push_back(fmt::format(
          "motors[{}].velocity_rad_s: {} is less than the {:.6g} that the joints' limits ask "
          "of {}",
          i, motor.velocity_rad_s, speeds[i], handgraft::quoted(motor.name)));
    }
  }
}

void checkDeadmen(const HandConfig& config, Problems& problems) {
  const double period_ms = 1000 * config.governor.period_s;
  const auto watchdog_ms = static_cast<double>(config.device.watchdog.count());
  const DeviceTraits& traits = traitsOf(config.device.kind);
  const bool has_watchdog = traits.has_watchdog;
  if (!traits.has_own_loop && !(period_ms <= 1000.0 / kLeastTorqueRate)) {
    problems.push_back(
        fmt::format("loop.rate_hz: {:.4g}; the position loop of such a hand is ours: at least "
                    "{}",
                    1000 / period_ms, kLeastTorqueRate));
  }
  if (has_watchdog && !(watchdog_ms >= 3 * period_ms)) {
    problems.push_back(
        fmt::format("device.watchdog_ms: {} is less than three periods of {:.4g} ms",
                    watchdog_ms, period_ms));
  }
  if (has_watchdog && config.governor.longest_gap > config.device.watchdog) {
    problems.push_back(
        fmt::format("loop.longest_gap_ms: {} is more than the device's watchdog of {} ms",
                    config.governor.longest_gap.count(), watchdog_ms));
  }
  const auto reply_ms = static_cast<double>(config.device.reply_timeout.count());
  if (config.device.kind != DeviceKind::kSimulated && !(reply_ms <= period_ms)) {
    problems.push_back(
        fmt::format("device.reply_timeout_ms: {} is more than a period of "
                    "{:.4g} ms",
                    reply_ms, period_ms));
  }
}

void checkDevice(const HandConfig& config, const Soundness& is_sound, Problems& problems) {
  const DeviceConfig& device = config.device;
  const DeviceTraits& traits = traitsOf(device.kind);
  const auto own = static_cast<std::size_t>(traits.own_motors);
  if (own > 0 && is_sound("motors") && config.motors.size() != own) {
    problems.push_back(
        fmt::format("motors: {} of them; such a hand has {}", config.motors.size(), own));
  }
  if (device.kind == DeviceKind::kAbilityHand && is_sound("device.watchdog_ms") &&
      device.watchdog != kAbilityHandDeadman) {
    problems.push_back(fmt::format("device.watchdog_ms: {}; that of an ability_hand is {}",
                                   device.watchdog.count(), kAbilityHandDeadman.count()));
  }
  if (device.kind == DeviceKind::kSimulated) return;
  const int most = traits.highest_id;
  std::set<int> seen;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const int id = config.motors[i].id;
    if (!is_sound.motor(i)) continue;
    if (id < 0 || id > most)
      problems.push_back(fmt::format("motors[{}].id: {} is not in [0, {}]", i, id, most));
    if (!seen.insert(id).second)
      problems.push_back(fmt::format("motors[{}].id: {} is there twice", i, id));
  }
}

void checkHoming(const HandConfig& config, Problems& problems) {
  for (std::size_t i = 0; i < config.homing.size(); ++i) {
    const safety::HomingStep& step = config.homing[i];
    const MotorConfig& motor = config.motors[step.motor];
    if (!(step.speed_rad_s <= motor.velocity_rad_s))
      problems.push_back(fmt::format("homing[{}].speed_rad_s: {} is more than the {} of {}", i,
                                     step.speed_rad_s, motor.velocity_rad_s,
                                     handgraft::quoted(motor.name)));
    if (!(step.current_A < motor.current_A))
      problems.push_back(
          fmt::format("homing[{}].current_A: {} must be less than the {} that {} may use", i,
                      step.current_A, motor.current_A, handgraft::quoted(motor.name)));
    const double off = step.stop_rad - step.toward * step.back_off_rad;
    if (!(off >= motor.range_rad.lower - kSlack && off <= motor.range_rad.upper + kSlack))
      problems.push_back(fmt::format(
          "homing[{}]: backed off, {} stands at {:.6g} rad, outside of [{}, {}]", i,
          handgraft::quoted(motor.name), off, motor.range_rad.lower, motor.range_rad.upper));
  }
}

// A motor that is named as a joint moves that one, or the list is in the wrong order.
void checkMotorJoints(const HandConfig& config, const Soundness& is_sound, Problems& problems) {
  const std::vector<std::string> joints = motorJoints(config);
  for (std::size_t i = 0; i < std::min(joints.size(), config.motors.size()); ++i) {
    const MotorConfig& motor = config.motors[i];
    const bool is_joint = std::find(joints.begin(), joints.end(), motor.name) != joints.end();
    if (!is_sound.motor(i) || !motor.joint.empty() || !is_joint || motor.name == joints[i])
      continue;
    problems.push_back(
        fmt::format("motors[{}]: {} would move joint {}, by its place in the list: give each "
                    "motor its 'joint'",
                    i, handgraft::quoted(motor.name), handgraft::quoted(joints[i])));
  }
}

// What a cycle takes on the wire has to fit into a period, with room for what is late.
void checkWire(const HandConfig& config, Problems& problems) {
  const DeviceConfig& device = config.device;
  const double period_ms = 1000 * config.governor.period_s;
  const double cycle_ms = 1000 * cycleTime(config);
  if (cycle_ms <= kWireShare * period_ms) return;
  problems.push_back(
      fmt::format("device.baud: at {} a cycle of {} motors takes {:.3g} ms on the wire, more "
                  "than {:.0f} % of "
                  "a period of {:.4g} ms: at most {:.0f} Hz",
                  traitsOf(device.kind).wire == DeviceWire::kCan
                      ? fmt::format("{} (can_bitrate {})", device.baud, device.can_bitrate)
                      : std::to_string(device.baud),
                  config.motors.size(), cycle_ms, 100 * kWireShare, period_ms,
                  std::floor(1000 * kWireShare / cycle_ms)));
}

void checkMotorNames(const HandConfig& config, const Soundness& is_sound, Problems& problems) {
  std::set<std::string> seen;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    if (is_sound.motor(i) && !seen.insert(config.motors[i].name).second)
      problems.push_back(fmt::format("motors[{}].name: {} is there twice", i,
                                     handgraft::quoted(config.motors[i].name)));
  }
}

}  // namespace

std::vector<std::string> motorJoints(const HandConfig& config) {
  std::vector<std::string> joints;
  if (config.transmission.kind != TransmissionKind::kDirect) return joints;
  const auto& followers = config.transmission.followers;
  for (std::size_t i = 0; i < config.governor.names.size(); ++i) {
    const bool follows =
        std::any_of(followers.begin(), followers.end(), [i](const tendon::MimicJoint& each) {
          return each.joint == i;
        });
    if (!follows) joints.push_back(config.governor.names[i]);
  }
  return joints;
}

std::unique_ptr<tendon::MotorMap> makeMotorMap(const HandConfig& config) {
  const TransmissionConfig& transmission = config.transmission;
  switch (transmission.kind) {
    case TransmissionKind::kTendons:
      return std::make_unique<tendon::TendonMap>(transmission.tendons);
    case TransmissionKind::kDirect:
      return std::unique_ptr<tendon::MotorMap>(new tendon::SynergyMap(
          tendon::mimicMap(jointRanges(config), transmission.followers, travelsOf(config))));
    case TransmissionKind::kSynergies:
      break;
  }
  const auto n = static_cast<Eigen::Index>(config.jointCount());
  const auto m = static_cast<Eigen::Index>(transmission.synergies.size());
  Eigen::MatrixXd S(n, m);
  Eigen::VectorXd rest(n);
  if (transmission.rest_rad.size() != config.jointCount())
    rejectInput("transmission.rest_rad: {} numbers for {} joints", transmission.rest_rad.size(),
                n);
  std::vector<tendon::Range> motors;
  for (Eigen::Index i = 0; i < m; ++i) {
    const std::vector<double>& column =
        transmission.synergies[static_cast<std::size_t>(i)].column;
    if (column.size() != config.jointCount())
      rejectInput("transmission.synergies[{}]: {} numbers for {} joints", i, column.size(), n);
    S.col(i) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
  }
  rest = Eigen::Map<const Eigen::VectorXd>(transmission.rest_rad.data(), n);
  for (const MotorConfig& motor : config.motors)
    motors.push_back(motor.range_rad);
  return std::make_unique<tendon::SynergyMap>(S, rest, Eigen::VectorXd::Ones(n), motors);
}

std::vector<std::string> remarksOn(const HandConfig& config) {
  constexpr double kTurn = 2.0 * std::numbers::pi;  // rad
  constexpr double kWide = 0.5;                     // m: no hand opens farther
  // A drum that winds a tendon in goes round several times; what is geared to a joint does not.
  const double most_of_motor =
      config.transmission.kind == TransmissionKind::kDirect ? kTurn : 10.0 * kTurn;
  std::vector<std::string> remarks;
  const auto note = [&](const char* kind, const std::string& name, double lower, double upper,
                        double most) {
    if (std::max(std::abs(lower), std::abs(upper)) <= most) return;
    remarks.push_back(
        fmt::format("{} {}: {:.4g} to {:.4g} rad are more than {:.0f} turn{}; angles are "
                    "radians, not degrees",
                    kind, quoted(name), lower, upper, most / kTurn, most > kTurn ? "s" : ""));
  };
  for (std::size_t i = 0; i < config.jointCount(); ++i) {
    const safety::JointLimits& limits = config.governor.limits[i];
    if (!limits.slides) {
      note("joint", config.governor.names[i], limits.lower, limits.upper, kTurn);
    } else if (std::max(std::abs(limits.lower), std::abs(limits.upper)) > kWide) {
      remarks.push_back(fmt::format(
          "joint {}: {:.4g} to {:.4g} m are more than {} m; lengths are metres, not "
          "millimetres",
          quoted(config.governor.names[i]), limits.lower, limits.upper, kWide));
    }
  }
  const std::vector<std::string> joints = motorJoints(config);
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const MotorConfig& motor = config.motors[i];
    const auto& names = config.governor.names;
    const auto joint =
        i < joints.size() ? std::find(names.begin(), names.end(), joints[i]) : names.end();
    // One that draws a rack, or turns a screw, goes round as often as it must.
    if (joint != names.end() &&
        config.governor.limits[static_cast<std::size_t>(joint - names.begin())].slides)
      continue;
    note("motor", motor.name, motor.range_rad.lower, motor.range_rad.upper, most_of_motor);
  }
  return remarks;
}

std::vector<std::string> problemsOf(const HandConfig& config, const Problems& known) {
  const Soundness is_sound(known);
  Problems problems;
  checkMotorNames(config, is_sound, problems);
  if (is_sound("device.kind")) checkDevice(config, is_sound, problems);
  if (is_sound("device") && is_sound("loop")) checkDeadmen(config, problems);
  if (is_sound("device") && is_sound("loop") && is_sound("motors")) checkWire(config, problems);
  if (is_sound("joints") && is_sound("transmission"))
    checkMotorJoints(config, is_sound, problems);
  if (is_sound("device.kind") && is_sound("motors") && is_sound("homing"))
    checkHoming(config, problems);
  if (!is_sound("joints") || !is_sound("motion")) return problems;

  const std::size_t before = problems.size();
  if (is_sound("loop") && is_sound("emergency_stop")) {
    collect("joints", problems, [&] {
      const safety::Governor governor(config.governor);
    });
  }
  const bool is_tendons = config.transmission.kind == TransmissionKind::kTendons;
  const bool needs_motors = config.transmission.kind == TransmissionKind::kSynergies;
  if (!is_sound("transmission") || (needs_motors && !is_sound("motors"))) return problems;
  if (is_tendons) {
    for (const std::string& problem : tendon::problemsOf(config.transmission.tendons))
      problems.push_back("transmission: " + problem);
  } else {
    collect("transmission", problems, [&] {
      makeMotorMap(config);
    });
  }
  const bool has_motors = is_sound("motors") || !config.motors.empty();
  if (problems.size() == before && has_motors) checkMotorsSuffice(config, is_sound, problems);
  return problems;
}

}  // namespace handgraft::config
