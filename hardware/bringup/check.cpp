#include "hardware/bringup/check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::bringup {

namespace {

constexpr double kStep = 0.1;       // rad
constexpr double kReached = 0.05;   // rad: a hand at its end is not held more exactly
constexpr double kTravelOff = 0.1;  // share: hands put a jaw to its ends by the eye
constexpr std::chrono::milliseconds kStopped(500);

/// Somebody left.
struct Left {};

class Walk {
 public:
  Walk(config::HandConfig& config,
       const bridge::MakeDevice& make_device,
       const devices::Clock& clock,
       const std::function<void(devices::TimePoint)>& sleep_until,
       const Operator& person)
      : config_(config),
        make_device_(make_device),
        clock_(clock),
        sleep_until_(sleep_until),
        person_(person) {}

  Findings run() {
    try {
      for (std::size_t i = 0; i < config_.motors.size(); ++i)
        walkMotor(i);
      tried([this] {
        walkWatchdog();
      });
      tried([this] {
        walkStop();
      });
    } catch (const Left&) {
      findings_.trouble = "it was ended early";
    } catch (const DeviceError& error) {
      findings_.trouble = error.what();
    } catch (const TransportError& error) {
      findings_.trouble = error.what();
    } catch (const InvalidInput& error) {
      findings_.trouble = error.what();
    }
    return findings_;
  }

 private:
  std::string ask(const std::string& question) {
    const std::optional<std::string> answer = person_.ask(question);
    if (!answer) throw Left{};
    return *answer;
  }

  bool agrees(const std::string& question) {
    while (true) {
      const std::string answer = ask(question + " [y/n]");
      if (answer == "y" || answer == "yes") return true;
      if (answer == "n" || answer == "no") return false;
      person_.say("y or n, please");
    }
  }

  /// A bus that is busy may lose an answer: that is no reason to begin the walk anew.
  template <class Act>
  std::invoke_result_t<Act> tried(Act&& act) {
    while (true) {
      try {
        return act();
      } catch (const DeviceError& error) {
        person_.say(error.what());
        if (!agrees("Once more?")) throw;
      }
    }
  }

  Jogger jogger(std::size_t i) {
    return {config_, config_.motors[i].name, make_device_, clock_, sleep_until_};
  }

  // The encoder's angle, the motor off, once the joint was put somewhere by hand. While a hand
  // is in there the device is open: its motors are off, and its port is nobody else's.
  double placed(std::size_t i, const std::string& where) {
    {
      const bridge::DeviceStack ours = tried([this] {
        bridge::DeviceStack stack = make_device_(config_);
        stack.device->open();
        return stack;
      });
      ask(fmt::format("Put {} by hand {}, then press Enter", nameOf(i), where));
    }
    return tried([&] {
      return jogger(i).look().encoder_rad;
    });
  }

  [[nodiscard]] std::string nameOf(std::size_t i) const {
    const config::MotorConfig& motor = config_.motors[i];
    return motor.joint.empty() || motor.joint == motor.name
               ? "'" + motor.name + "'"
               : fmt::format("joint '{}' (motor '{}')", motor.joint, motor.name);
  }

  /// By how much the joint that a motor draws moves for each radian, m; nothing if it turns.
  [[nodiscard]] std::optional<double> travelOf(std::size_t i) const {
    const std::vector<std::string> joints = config::motorJoints(config_);
    const auto& names = config_.governor.names;
    if (i >= joints.size()) return std::nullopt;
    const auto joint = std::find(names.begin(), names.end(), joints[i]) - names.begin();
    const safety::JointLimits& limits =
        config_.governor.limits[static_cast<std::size_t>(joint)];
    return limits.slides ? std::optional(limits.travel) : std::nullopt;
  }

  /// A motor's angle, and where its joint is then if that slides.
  [[nodiscard]] std::string placeText(std::size_t i, double motor_rad) const {
    const std::optional<double> travel = travelOf(i);
    return travel ? fmt::format("{:.4g} m ({:.3g} rad)", motor_rad * *travel, motor_rad)
                  : fmt::format("{:.3g} rad", motor_rad);
  }

  /// Ends that were shown in metres tell what a radian is worth; empty: as the config has it.
  [[nodiscard]] std::string travelObjection(std::size_t i, double turned_rad) const {
    const std::optional<double> travel = travelOf(i);
    const tendon::Range& range_rad = config_.motors[i].range_rad;
    const double told_rad = range_rad.upper - range_rad.lower;
    if (!travel || std::abs(turned_rad - told_rad) <= kTravelOff * told_rad) return "";
    return fmt::format(
        "between its ends it turned by {:.2f} rad, not {:.2f}: travel_m_rad is "
        "{:.3g} by that, and {:.3g} in the config",
        turned_rad, told_rad, *travel * told_rad / turned_rad, *travel);
  }

  [[nodiscard]] std::string nameOf(const devices::Fault& fault) const {
    if (fault.motor < 0) return describe(fault);
    return fmt::format("{}: {}", nameOf(static_cast<std::size_t>(fault.motor)),
                       devices::describe(fault.kind));
  }

  void turnHeldFor(std::size_t i, double step_rad) {
    person_.say(fmt::format("{}: hold the space bar (or type 'hold'): it turns by {} rad",
                            nameOf(i), step_rad));
    const auto is_let_go = [&] {
      return tried([&] {
        return jogger(i).turn(step_rad, person_.is_held).was_let_go;
      });
    };
    while (is_let_go()) {
      if (person_.has_left()) throw Left{};
      person_.say("it was let go; once more: hold the space bar");
    }
  }

  void walkMotor(std::size_t i) {
    config::MotorConfig& motor = config_.motors[i];
    person_.say(fmt::format("--- {} of {}: {}, id {}", i + 1, config_.motors.size(), nameOf(i),
                            motor.id));
    MotorFinding finding;
    finding.motor = motor.name;
    if (config::traitsOf(config_.device.kind).has_zeros) return walkKnownMotor(i, finding);
    motor.zero_rad = finding.zero_rad = placed(i, "to its zero, as the model has it");
    turnHeldFor(i, kStep);
    if (!agrees(fmt::format("Did {}, and no other, turn the way that its model calls positive?",
                            nameOf(i)))) {
      if (!agrees("Was it the right joint, the other way?")) {
        finding.objection = "its motor turned another joint";
        findings_.motors.push_back(finding);
        return;
      }
      motor.direction = -motor.direction;
    }
    finding.is_direction_right = true;
    const double one = placed(i, "to its lower end, " + placeText(i, motor.range_rad.lower));
    const double other = placed(i, "to its upper end, " + placeText(i, motor.range_rad.upper));
    const auto angle = [&](double encoder_rad) {
      return motor.direction * (encoder_rad - motor.zero_rad) / motor.gear;
    };
    finding.lowest_rad = std::min(angle(one), angle(other));
    finding.highest_rad = std::max(angle(one), angle(other));
    const double under = finding.lowest_rad - motor.range_rad.lower;
    const double over = motor.range_rad.upper - finding.highest_rad;
    if (angle(one) > angle(other)) {
      finding.objection = "its lower end lies above its upper one: see to its direction";
    } else if (std::string wrong = travelObjection(i, angle(other) - angle(one));
               !wrong.empty()) {
      finding.objection = std::move(wrong);
    } else if (under > kReached || over > kReached) {
      finding.objection = fmt::format(
          "it reaches {:.3f} to {:.3f} rad; the config sends it from {:.3f} to {:.3f}",
          finding.lowest_rad, finding.highest_rad, motor.range_rad.lower,
          motor.range_rad.upper);
    }
    person_.say(finding.objection.empty() ? nameOf(i) + ": fine" : finding.objection);
    findings_.motors.push_back(finding);
  }

  // Its zero and its range are the hand's own, and its fingers may not be moved by hand.
  void walkKnownMotor(std::size_t i, MotorFinding& finding) {
    const config::MotorConfig& motor = config_.motors[i];
    finding.zero_rad = motor.zero_rad;
    finding.lowest_rad = motor.range_rad.lower;
    finding.highest_rad = motor.range_rad.upper;
    const double start = tried([&] {
      return jogger(i).look().motor_rad;
    });
    const bool has_room = start + kStep < motor.range_rad.upper;
    const double step_rad = has_room ? kStep : -kStep;
    turnHeldFor(i, step_rad);
    finding.is_direction_right =
        agrees(fmt::format("Did {}, and no other, turn the way that its model calls {}?",
                           nameOf(i), has_room ? "positive" : "negative"));
    if (!finding.is_direction_right)
      finding.objection = "its motor turned another joint, or the other way";
    person_.say(finding.objection.empty() ? nameOf(i) + ": fine" : finding.objection);
    findings_.motors.push_back(finding);
  }

  bridge::DeviceStack armed() {
    // Ranges of motors that stand somewhere near their ends: they are only held there.
    bridge::DeviceStack stack = make_device_(config_);
    stack.device->open();
    stack.device->arm();
    return stack;
  }

  void walkWatchdog() {
    if (!config::traitsOf(config_.device.kind).has_watchdog) {
      findings_.lacks_watchdog = true;
      person_.say("this device has no watchdog, which the config accepts");
      return;
    }
    ask("Next the motors hold, and then this program falls silent: the device itself has to "
        "switch them off. Press Enter");
    bridge::DeviceStack stack = armed();
    sleep_until_(clock_() + config_.device.watchdog * 2 + kStopped);
    devices::DeviceState measured(stack.device->motorCount());
    for (int k = 0; k < 10 && !stack.device->fault(); ++k)
      stack.device->read(measured);
    const devices::Fault fault = stack.device->fault();
    if (fault.kind == devices::Fault::Kind::kStarved) {
      // Our own silence is no word of the device's.
      stack.device->stop();
      findings_.has_watchdog =
          agrees("It does not tell whether its watchdog stopped it. Did it let go by itself?");
    } else {
      findings_.has_watchdog = static_cast<bool>(fault);
      person_.say(fault ? "the watchdog stopped them: " + nameOf(fault)
                        : "the motors hold on: the watchdog did not stop them");
    }
    stack.device->stop();
    clear(stack);
  }

  void walkStop() {
    ask("Next the motors hold, and the emergency stop lets go of them. Press Enter");
    bridge::DeviceStack stack = armed();
    stack.device->stop();
    sleep_until_(clock_() + kStopped);
    devices::DeviceState measured(stack.device->motorCount());
    stack.device->read(measured);
    // Fingers that screws hold are not limp.
    const bool is_limp = !config::traitsOf(config_.device.kind).has_zeros;
    findings_.has_stop =
        agrees(is_limp ? "Are the motors limp now?"
                       : "Such a hand is held without power, too. Did nothing move?");
    clear(stack);
  }

  // What was provoked is forgotten.
  static void clear(bridge::DeviceStack& stack) { stack.device->reset(); }

  config::HandConfig& config_;
  const bridge::MakeDevice& make_device_;
  const devices::Clock& clock_;
  const std::function<void(devices::TimePoint)>& sleep_until_;
  const Operator& person_;
  Findings findings_;
};

}  // namespace

bool Findings::isFine() const {
  return trouble.empty() && (has_watchdog || lacks_watchdog) && has_stop &&
         std::all_of(motors.begin(), motors.end(), [](const MotorFinding& motor) {
           return motor.is_direction_right && motor.objection.empty();
         });
}

Findings check(config::HandConfig& config,
               const bridge::MakeDevice& make_device,
               const devices::Clock& clock,
               const std::function<void(devices::TimePoint)>& sleep_until,
               const Operator& person) {
  return Walk(config, make_device, clock, sleep_until, person).run();
}

std::string reportText(const config::HandConfig& config, const Findings& findings) {
  std::string text = fmt::format("hand {}: {}\n", quoted(config.hand),
                                 findings.isFine() ? "fine" : "NOT fine");
  for (const MotorFinding& motor : findings.motors) {
    const auto found =
        std::find_if(config.motors.begin(), config.motors.end(), [&](const auto& candidate) {
          return candidate.name == motor.motor;
        });
    text +=
        fmt::format("motor {}: direction {}, zero_rad {:.4f}, reaches {:.3f} to {:.3f} rad{}\n",
                    quoted(motor.motor), found == config.motors.end() ? 0 : found->direction,
                    motor.zero_rad, motor.lowest_rad, motor.highest_rad,
                    motor.objection.empty() ? "" : ": " + motor.objection);
  }
  text += fmt::format("the device's own watchdog: {}\n",
                      findings.has_watchdog     ? "stops the motors"
                      : findings.lacks_watchdog ? "there is none, and the config accepts that"
                                                : "NOT shown");
  text += fmt::format("emergency stop: {}\n", findings.has_stop ? "lets go" : "NOT shown");
  if (!findings.trouble.empty()) text += findings.trouble + "\n";
  return text;
}

}  // namespace handgraft::bringup
