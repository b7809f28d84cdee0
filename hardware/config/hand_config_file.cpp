#include "hardware/config/hand_config_file.h"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

#include "core/base/error.h"
#include "hardware/config/calibration_file.h"
#include "hardware/config/device_section.h"
#include "hardware/config/joint_section.h"
#include "hardware/config/text_file.h"
#include "hardware/config/transmission_section.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

namespace {

constexpr std::size_t kMostProblems = 20;

void readLoop(Section section, HandConfig& config) {
  safety::GovernorOptions& governor = config.governor;
  governor.period_s = 1 / section.number("rate_hz", 10, 1000, 100);
  governor.overruns_in_a_row =
      static_cast<unsigned>(section.integer("overruns_in_a_row", 1, 1000, 10));
  governor.longest_gap = section.duration("longest_gap_ms", 5, 1000, governor.longest_gap);
  config.realtime_priority = section.integer("realtime_priority", 0, 99, 0);
  section.finish();
}

void readStream(Section section, safety::GovernorOptions& governor) {
  governor.stale_after = section.duration("stale_ms", 10, 10'000, governor.stale_after);
  governor.step.rad = section.number("step_rad", 0.01, 100, governor.step.rad);
  governor.step.m = section.number("step_m", 1e-4, 1, governor.step.m);
  governor.hold_for = section.duration("hold_ms", 1, 600'000, governor.hold_for);
  section.finish();
}

void readArming(Section section, HandConfig& config) {
  safety::GovernorOptions& governor = config.governor;
  governor.near.rad = section.number("near_rad", 0, 1, governor.near.rad);
  governor.near.m = section.number("near_m", 0, 0.01, governor.near.m);
  governor.ramp_share = section.number("ramp_share", 0.001, 1, governor.ramp_share);
  governor.outside.rad = section.number("outside_rad", 0.001, 10, governor.outside.rad);
  governor.outside.m = section.number("outside_m", 1e-5, 0.1, governor.outside.m);
  config.motor_outside_rad =
      section.number("motor_outside_rad", 0.001, 10, config.motor_outside_rad);
  governor.power_within =
      section.duration("power_within_ms", 10, 60'000, governor.power_within);
  governor.reset_within =
      section.duration("reset_within_ms", 10, 60'000, governor.reset_within);
  section.finish();
}

void readStopping(Section section, safety::GovernorOptions& governor) {
  governor.stop_mode = section.choice<safety::StopMode>(
      "mode", {{"brake", safety::StopMode::kBrake}, {"cut", safety::StopMode::kCut}},
      safety::StopMode::kBrake);
  governor.brake_within = section.duration("brake_ms", 10, 10'000, governor.brake_within);
  section.finish();
}

void readWatching(Section section, HandConfig& config) {
  safety::GovernorOptions& governor = config.governor;
  governor.device_silent_after =
      section.duration("silent_ms", 5, 1000, governor.device_silent_after);
  governor.limited_for = section.duration("limited_ms", 1, 60'000, governor.limited_for);
  config.hot_c = section.number("hot_c", 20, 150, config.hot_c);
  config.stalled_for = section.duration("stalled_ms", 10, 3'600'000, config.stalled_for);
  section.finish();
}

/// Of a device whose kind is not known, only what every motor has is read.
void readMotors(Section& file, HandConfig& config, bool is_known_kind) {
  const bool has_ids =
      config.device.kind == DeviceKind::kDynamixel || config.device.kind == DeviceKind::kODrive;
  const int own = traitsOf(config.device.kind).own_motors;
  const bool is_ability_hand = config.device.kind == DeviceKind::kAbilityHand;
  for (Section& section : file.list("motors", 1, kMostJoints)) {
    MotorConfig motor;
    motor.name = section.text("name");
    if (section.has("joint")) motor.joint = section.text("joint");
    motor.id = static_cast<int>(config.motors.size());
    motor.range_rad.lower = section.number("lower_rad", -kFarthestTurn, kFarthestTurn);
    motor.range_rad.upper = section.number("upper_rad", -kFarthestTurn, kFarthestTurn);
    if (!(motor.range_rad.lower < motor.range_rad.upper)) {
      section.object("upper_rad", fmt::format("{} is not above lower_rad {}",
                                              motor.range_rad.upper, motor.range_rad.lower));
    }
    motor.velocity_rad_s = section.number("velocity_rad_s", 1e-3, 1000);
    if (!is_known_kind) {
      section.allow({"id", "current_A", "gear", "zero_rad", "direction", "encoder",
                     "torque_Nm_A", "gains"});
      section.finish();
      config.motors.push_back(motor);
      continue;
    }
    if (own > 0) motor.id = section.integer("id", 0, own - 1, motor.id);
    if (has_ids) {
      motor.id = section.integer("id", 0, 252);
      motor.current_A = section.number("current_A", 1e-3, 100);
    }
    if (!is_ability_hand) {
      if (section.has("torque_Nm_A"))
        motor.torque_Nm_A = section.number("torque_Nm_A", 1e-4, 100);
      motor.gear = section.number("gear", 1e-3, 1000, 1);
      motor.zero_rad = section.number("zero_rad", -kFarthestTurn, kFarthestTurn, 0);
      motor.direction = section.choice<int>("direction", {{"1", 1}, {"-1", -1}}, 1);
    }
    if (config.device.kind == DeviceKind::kDynamixel && section.has("gains")) {
      Section gains = section.section("gains", true);
      motor.gains = MotorGains{gains.integer("p", 0, 16'383), gains.integer("i", 0, 16'383, 0),
                               gains.integer("d", 0, 16'383, 0)};
      gains.finish();
    }
    if (has_ids && section.has("encoder")) {
      motor.encoder = section.choice<Encoder>(
          "encoder",
          {{"absolute", Encoder::kAbsolute}, {"incremental", Encoder::kIncremental}});
    }
    section.finish();
    config.motors.push_back(motor);
  }
}

// Motors that say which joint they move come in that order, whatever theirs in the file is.
void orderByJoint(Section& file, HandConfig& config) {
  const bool is_told =
      std::any_of(config.motors.begin(), config.motors.end(), [](const MotorConfig& motor) {
        return !motor.joint.empty();
      });
  if (!is_told) return;
  if (config.transmission.kind != TransmissionKind::kDirect) {
    file.object("motors", "'joint' is of direct drive; here the transmission says it");
    return;
  }
  const std::vector<std::string> joints = motorJoints(config);
  std::vector<MotorConfig> ordered;
  for (const std::string& joint : joints) {
    const auto moves = [&joint](const MotorConfig& motor) {
      return motor.joint == joint;
    };
    const auto found = std::find_if(config.motors.begin(), config.motors.end(), moves);
    const auto count = std::count_if(config.motors.begin(), config.motors.end(), moves);
    if (count == 1) {
      ordered.push_back(*found);
    } else {
      file.object("motors", fmt::format("{} of them move joint {}; one has to", count,
                                        handgraft::quoted(joint)));
    }
  }
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const std::string& joint = config.motors[i].joint;
    if (std::find(joints.begin(), joints.end(), joint) != joints.end()) continue;
    file.object(fmt::format("motors[{}].joint", i),
                joint.empty() ? "is missing: other motors have one"
                              : fmt::format("{} is no joint with a motor of its own: {}",
                                            handgraft::quoted(joint), fmt::join(joints, ", ")));
  }
  if (ordered.size() == config.motors.size()) config.motors = std::move(ordered);
}

void readHoming(Section& file, HandConfig& config) {
  for (Section& section : file.list("homing", 0, kMostJoints)) {
    safety::HomingStep step;
    const std::string name = section.text("motor");
    const auto found =
        std::find_if(config.motors.begin(), config.motors.end(), [&](const MotorConfig& m) {
          return m.name == name;
        });
    if (found == config.motors.end())
      section.object("motor", "no motor is named " + handgraft::quoted(name));
    step.toward = section.choice<int>("toward", {{"1", 1}, {"-1", -1}});
    step.speed_rad_s = section.number("speed_rad_s", 1e-3, 100);
    step.current_A = section.number("current_A", 1e-3, 100);
    step.hold = section.duration("hold_ms", 10, 10'000, step.hold);
    step.travel_rad = section.number("travel_rad", 1e-3, kFarthestTurn);
    step.stop_rad = section.number("stop_rad", -kFarthestTurn, kFarthestTurn);
    step.back_off_rad = section.number("back_off_rad", 0, kFarthestTurn, 0);
    section.finish();
    if (found == config.motors.end()) continue;
    step.motor = static_cast<std::size_t>(found - config.motors.begin());
    config.homing.push_back(step);
    if (found->encoder == Encoder::kUnsaid) found->encoder = Encoder::kIncremental;
  }
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    MotorConfig& motor = config.motors[i];
    const bool is_homed =
        std::any_of(config.homing.begin(), config.homing.end(), [i](const auto& step) {
          return step.motor == i;
        });
    if (motor.encoder == Encoder::kIncremental && !is_homed) {
      file.object(fmt::format("motors[{}].encoder", i),
                  "an incremental one needs a step in 'homing': it forgets its zero");
    }
    if (motor.encoder == Encoder::kUnsaid) motor.encoder = Encoder::kAbsolute;
  }
}

[[noreturn]] void rejectAll(Problems problems) {
  // What is wrong at the top explains what is missing below; a misspelt key is known last.
  std::stable_partition(problems.begin(), problems.end(), [](const std::string& problem) {
    return problem.find('.') > problem.find(": ");
  });
  std::string all;
  for (std::size_t i = 0; i < problems.size() && i < kMostProblems; ++i)
    all += (i == 0 ? "" : "; ") + problems[i];
  if (problems.size() > kMostProblems)
    all += fmt::format("; and {} more", problems.size() - kMostProblems);
  throw InvalidInput(all);
}

}  // namespace

HandConfig parseHandConfig(const std::string& text) {
  Problems problems;
  HandConfig config;
  try {
    Section file = Section::parse(text, problems);
    if (!problems.empty()) rejectAll(problems);
    file.choice<int>("format", {{"handgraft-hardware/1", 1}});
    config.hand = file.text("hand");
    const Section device = file.section("device", true);
    config.device = readDevice(device);
    readLoop(file.section("loop", false), config);
    readStream(file.section("stream", false), config.governor);
    readArming(file.section("arming", false), config);
    readStopping(file.section("emergency_stop", false), config.governor);
    readWatching(file.section("watch", false), config);
    readJoints(file, config);
    readMotors(file, config, !device.isWrong("kind"));
    config.transmission = readTransmission(file.section("transmission", false), config);
    takeTravels(file, config);
    orderByJoint(file, config);
    readHoming(file, config);
    config.calibration = file.text("calibration", "");
    file.finish();
  } catch (const YAML::Exception& error) {
    problems.push_back(
        fmt::format("line {}: {}", error.mark.line + 1, handgraft::quoted(error.msg)));
    rejectAll(problems);  // what comes after it was not read
  }
  for (std::string& problem : problemsOf(config, problems))
    problems.push_back(std::move(problem));
  if (!problems.empty()) rejectAll(problems);
  return config;
}

HandConfig readHandConfig(const std::filesystem::path& path) {
  const std::string text = readText(path);
  HandConfig config;
  try {
    config = parseHandConfig(text);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
  if (!config.calibration.empty()) {
    config.calibration = path.parent_path() / config.calibration;
    // Before the first homing, or the first `check`, there is none yet.
    if (std::filesystem::exists(config.calibration)) {
      readCalibration(config.calibration, config);
      config.is_calibrated = true;
    }
  }
  return config;
}

}  // namespace handgraft::config
