#include "hardware/bringup/make_config.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <tinyxml2.h>

#include "core/base/error.h"
#include "hardware/config/wire_load.h"

namespace handgraft::bringup {

namespace {

struct Joint {
  std::string name;
  double lower = -3.14159, upper = 3.14159;
  double velocity = 0;
  std::string leader;  // of a mimic joint
  double ratio = 1, offset = 0;
};

constexpr double kVelocity = 1.0;  // rad/s: slow enough to watch
constexpr int kUsualRate_Hz = 50;
constexpr int kLeastRate_Hz = 10;  // of any loop

std::string attribute(const tinyxml2::XMLElement& element, const char* name) {
  const char* text = element.Attribute(name);
  return text == nullptr ? "" : text;
}

std::optional<Joint> jointOf(const tinyxml2::XMLElement& element) {
  const std::string type = attribute(element, "type");
  if (type != "revolute" && type != "continuous") {
    if (type == "prismatic")
      rejectInput("joint {} slides: motors of a config turn",
                  handgraft::quoted(attribute(element, "name")));
    return std::nullopt;
  }
  Joint joint;
  joint.name = attribute(element, "name");
  if (const auto* limit = element.FirstChildElement("limit")) {
    if (type == "revolute") {
      joint.lower = limit->DoubleAttribute("lower", 0);
      joint.upper = limit->DoubleAttribute("upper", 0);
    }
    joint.velocity = limit->DoubleAttribute("velocity", 0);
  }
  if (!(joint.lower < joint.upper))
    rejectInput("joint {}: its limits [{}, {}] leave no room", handgraft::quoted(joint.name),
                joint.lower, joint.upper);
  if (const auto* mimic = element.FirstChildElement("mimic")) {
    joint.leader = attribute(*mimic, "joint");
    joint.ratio = mimic->DoubleAttribute("multiplier", 1);
    joint.offset = mimic->DoubleAttribute("offset", 0);
  }
  return joint;
}

/// In YAML's double quotes.
std::string inQuotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

/// The device, as far as what its wire can carry depends on it.
config::DeviceConfig deviceOf(const ConfigPlan& plan) {
  config::DeviceConfig device;
  if (plan.kind == "odrive") device.kind = config::DeviceKind::kODrive;
  if (plan.kind == "dynamixel") device.kind = config::DeviceKind::kDynamixel;
  if (plan.kind == "ability_hand") device.kind = config::DeviceKind::kAbilityHand;
  const bool is_hand = device.kind == config::DeviceKind::kAbilityHand;
  device.baud = plan.baud > 0 ? plan.baud : is_hand ? 460'800 : 57'600;
  return device;
}

/// Hz: the usual rate, or a whole number that so many motors leave room for on the wire.
int rateOf(const ConfigPlan& plan, std::size_t motor_count) {
  config::HandConfig config;
  config.device = deviceOf(plan);
  config.motors.resize(motor_count);
  config.governor.period_s = 1.0 / kUsualRate_Hz;
  const double cycle_s = config::cycleTime_s(config);
  if (cycle_s * kUsualRate_Hz <= config::kWireShare) return kUsualRate_Hz;
  const int rate_Hz = static_cast<int>(config::kWireShare / cycle_s);
  if (rate_Hz < kLeastRate_Hz) {
    rejectInput(
        "baud {}: {} motors take {:.0f} ms a cycle, which leaves {} Hz; at least {} Hz are "
        "permitted: give the motors a higher rate, and tell it by --baud",
        config.device.baud, motor_count, 1000 * cycle_s, rate_Hz, kLeastRate_Hz);
  }
  return rate_Hz;
}

std::string deviceText(const ConfigPlan& plan, int rate_Hz) {
  const bool is_hand = plan.kind == "ability_hand";
  std::string text = fmt::format("device:\n  kind: {}\n", plan.kind);
  if (plan.kind == "simulated") return text + "  watchdog_ms: 200\n";
  text += fmt::format("  port: {}\n", inQuotes(plan.port));
  if (plan.kind == "odrive") {
    text +=
        "  carrier: slcan\n  can_bitrate: 500000\n  firmware: \"0.6\"\n"
        "  watchdog_ms: 200         # FILL IN: as saved on the axes; each ARM proves it\n";
    return text;
  }
  const bool is_slow = rate_Hz < kUsualRate_Hz;
  text += fmt::format("  baud: {}{}\n", deviceOf(plan).baud,
                      is_slow ? "  # a higher rate of the motors permits a faster loop" : "");
  text += "  reply_timeout_ms: 20  # USB adapters keep bytes for up to 16 ms\n";
  // Three periods at least.
  text += fmt::format("  watchdog_ms: {}\n", is_hand ? 300 : is_slow ? 400 : 200);
  return text;
}

}  // namespace

std::string makeConfig(const std::filesystem::path& urdf, const ConfigPlan& plan) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(urdf.c_str()) != tinyxml2::XML_SUCCESS)
    rejectInput("{}: {}", handgraft::quoted(urdf.string()), document.ErrorStr());
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr)
    rejectInput("{}: it is no URDF: there is no <robot>", handgraft::quoted(urdf.string()));
  std::vector<Joint> joints;
  for (const auto* element = robot->FirstChildElement("joint"); element != nullptr;
       element = element->NextSiblingElement("joint")) {
    if (const std::optional<Joint> joint = jointOf(*element)) joints.push_back(*joint);
  }
  if (joints.empty()) rejectInput("{}: no joint of it turns", handgraft::quoted(urdf.string()));

  const auto motor_count = static_cast<std::size_t>(
      std::count_if(joints.begin(), joints.end(), [](const Joint& joint) {
        return joint.leader.empty();
      }));
  const int rate_Hz = rateOf(plan, motor_count);
  const bool has_ids = plan.kind == "dynamixel" || plan.kind == "odrive";
  std::string text = fmt::format(
      "# Of {}, to be filled in: FILL IN marks what only the hand itself knows.\n"
      "# `jog` turns one motor at a time; `check` asks for directions and zeros and keeps them "
      "in\n"
      "# the calibration file.\n"
      "format: handgraft-hardware/1\nhand: {}          # as the server calls it\n\n{}\n",
      urdf.filename().string(), inQuotes(attribute(*robot, "name")), deviceText(plan, rate_Hz));
  text += fmt::format("calibration: {}  # `check` writes it\n",
                      inQuotes(urdf.stem().string() + "_calibration.yaml"));
  text += fmt::format("loop: {{rate_hz: {}, longest_gap_ms: {}}}\n", rate_Hz,
                      rate_Hz < kUsualRate_Hz ? 350 : 150);
  // Slow answers are bearable for some periods, too.
  if (rate_Hz < kUsualRate_Hz) text += "watch: {silent_ms: 400}\n";
  text +=
      "stream: {stale_ms: 500, hold_ms: 1000}\nemergency_stop: {mode: brake, brake_ms: 500}\n";
  text += fmt::format(
      "motion: {{velocity_rad_s: {}, acceleration_rad_s2: {}, jerk_rad_s3: {}}}  # slow, to "
      "begin with\n\njoints:\n",
      kVelocity, 10 * kVelocity, 200 * kVelocity);
  std::string followers, motors;
  std::size_t count = 0;
  for (const Joint& joint : joints) {
    const std::string name = inQuotes(joint.name);
    text += fmt::format("  - {{name: {}, lower_rad: {}, upper_rad: {}}}\n", name, joint.lower,
                        joint.upper);
    if (!joint.leader.empty()) {
      followers += fmt::format("    - {{joint: {}, leader: {}, ratio: {}, offset_rad: {}}}\n",
                               name, inQuotes(joint.leader), joint.ratio, joint.offset);
      continue;
    }
    // A follower may ask for more of its leader than the leader's own limits.
    const double speed = 3 * kVelocity;
    motors += fmt::format(
        "  - {{name: {}, joint: {}, lower_rad: {}, upper_rad: {}, velocity_rad_s: {}", name,
        name, joint.lower, joint.upper, speed);
    if (has_ids) {
      const int next = plan.ids.empty()
                           ? static_cast<int>(count)
                           : plan.ids.back() + 1 + static_cast<int>(count - plan.ids.size());
      motors += fmt::format(", id: {}, current_A: 0.2",
                            count < plan.ids.size() ? plan.ids[count] : next);
    }
    motors += "}\n";
    ++count;
  }
  if (!followers.empty()) text += "\ntransmission:\n  kind: direct\n  followers:\n" + followers;
  text += fmt::format("\n# FILL IN: which motor moves which joint{}.\nmotors:\n{}",
                      has_ids ? ", by its id, and the current that it may use" : "", motors);
  return text;
}

}  // namespace handgraft::bringup
