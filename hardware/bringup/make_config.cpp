#include "hardware/bringup/make_config.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <tinyxml2.h>

#include "core/base/error.h"
#include "core/base/model_name.h"
#include "hardware/config/wire_load.h"

namespace handgraft::bringup {

namespace {

using config::DeviceKind;

struct Joint {
  std::string name;
  double lower = -3.14159, upper = 3.14159;
  bool slides = false;
  std::string leader;  // of a mimic joint
  double ratio = 1, offset = 0;
};

constexpr double kVelocity = 1.0;     // rad/s: slow enough to watch
constexpr double kTravel = 0.01;      // m/rad: a small pinion; only the hand itself knows
constexpr int kUsualRate = 50;        // Hz
constexpr int kLeastRate = 10;        // Hz; of any loop
constexpr int kTorqueRate = 333;      // Hz; of a position loop that is ours
constexpr int kFactoryBaud = 57'600;  // of Dynamixels

std::string attribute(const tinyxml2::XMLElement& element, const char* name) {
  const char* text = element.Attribute(name);
  return text == nullptr ? "" : text;
}

std::optional<Joint> jointOf(const tinyxml2::XMLElement& element) {
  const std::string type = attribute(element, "type");
  Joint joint;
  joint.name = attribute(element, "name");
  joint.slides = type == "prismatic";
  if (type != "revolute" && type != "continuous" && !joint.slides) return std::nullopt;
  const auto* limit = element.FirstChildElement("limit");
  if (joint.slides || (limit != nullptr && type == "revolute")) {
    joint.lower = limit == nullptr ? 0.0 : limit->DoubleAttribute("lower", 0);
    joint.upper = limit == nullptr ? 0.0 : limit->DoubleAttribute("upper", 0);
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

Joint* jointCalled(const std::string& name, std::vector<Joint>& joints) {
  const auto found = std::find_if(joints.begin(), joints.end(), [&](const Joint& one) {
    return one.name == name;
  });
  return found == joints.end() ? nullptr : &*found;
}

/// Lets who follows a follower follow what leads that one: a transmission has no chains.
void followTheFirst(std::vector<Joint>& joints) {
  for (Joint& joint : joints) {
    // More steps than joints are a loop, which the server refuses.
    for (std::size_t step = 0; step < joints.size(); ++step) {
      const Joint* leader = jointCalled(joint.leader, joints);
      if (leader == nullptr || leader->leader.empty()) break;
      joint.offset += joint.ratio * leader->offset;
      joint.ratio *= leader->ratio;
      joint.leader = leader->leader;
    }
  }
}

/// As hand::HandModel has it: a leader goes no farther than its followers can, if any way is
/// left; else the bridge would find its own config and the model to differ.
void narrowToFollowers(std::vector<Joint>& joints) {
  for (const Joint& follower : joints) {
    Joint* leader = jointCalled(follower.leader, joints);
    if (leader == nullptr || follower.ratio == 0.0) continue;
    const double a = (follower.lower - follower.offset) / follower.ratio;
    const double b = (follower.upper - follower.offset) / follower.ratio;
    const double lower = std::max(leader->lower, std::min(a, b));
    const double upper = std::min(leader->upper, std::max(a, b));
    if (!(lower < upper)) continue;
    leader->lower = lower;
    leader->upper = upper;
  }
}

/// In YAML's double quotes.
std::string inQuotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

const config::DeviceTraits& traitsNamed(const std::string& kind) {
  std::string names;
  for (const config::DeviceTraits& traits : config::deviceKinds()) {
    if (traits.name == kind) return traits;
    names += (names.empty() ? "" : ", ") + std::string(traits.name);
  }
  rejectInput("--kind {} is not one of {}", handgraft::quoted(kind), names);
}

bool isInterface(const std::string& port) {
  return !port.empty() && port.front() != '/';
}

/// The device, as far as what its wire can carry depends on it.
config::DeviceConfig deviceOf(const ConfigPlan& plan) {
  const config::DeviceTraits& traits = traitsNamed(plan.kind);
  config::DeviceConfig device;
  device.kind = traits.kind;
  const int usual = traits.kind == DeviceKind::kDynamixel ? kFactoryBaud : traits.baud;
  device.baud = plan.baud > 0 ? plan.baud : usual;
  device.is_baud_told = plan.baud > 0;
  device.can_bitrate = plan.can_bitrate > 0 ? plan.can_bitrate : traits.can_bitrate;
  if (isInterface(plan.port)) device.carrier = config::CanCarrier::kSocketCan;
  return device;
}

/// Hz: the usual rate, or a whole number that so many motors leave room for on the wire.
int rateOf(const ConfigPlan& plan, std::size_t motor_count) {
  config::HandConfig config;
  config.device = deviceOf(plan);
  config.motors.resize(motor_count);
  const config::DeviceTraits& traits = config::traitsOf(config.device.kind);
  const bool is_can = traits.wire == config::DeviceWire::kCan;
  const int usual_rate = traits.has_own_loop ? kUsualRate : kTorqueRate;
  config.governor.period_s = 1.0 / usual_rate;
  const double cycle_s = config::cycleTime(config);
  if (cycle_s * usual_rate <= config::kWireShare) return usual_rate;
  const int rate = static_cast<int>(config::kWireShare / cycle_s);
  const int least_rate = traits.has_own_loop ? kLeastRate : config::kLeastTorqueRate;
  if (rate < least_rate) {
    rejectInput(
        "{}: {} motors take {:.0f} ms a cycle, which leaves {} Hz; at least {} Hz are "
        "permitted: give {} a higher rate, and tell it by {}",
        is_can ? fmt::format("can_bitrate {}", config.device.can_bitrate)
               : fmt::format("baud {}", config.device.baud),
        motor_count, 1000 * cycle_s, rate, least_rate,
        is_can ? "the bus, or its adapter," : "the motors",
        is_can ? "--can-bitrate, or --baud" : "--baud");
  }
  return rate;
}

/// Errors: InvalidInput for ids that motors of this kind cannot have, or that are there twice.
std::vector<int> idsOf(const ConfigPlan& plan,
                       const config::DeviceTraits& traits,
                       std::size_t motor_count) {
  std::vector<int> ids = plan.ids;
  if (ids.size() > motor_count)
    rejectInput("--ids: {} of them, for {} joints that move by themselves", ids.size(),
                motor_count);
  while (ids.size() < motor_count)
    ids.push_back(ids.empty() ? 0 : ids.back() + 1);
  std::set<int> seen;
  for (const int id : ids) {
    if (id < 0 || id > traits.highest_id)
      rejectInput("--ids: {} is outside 0 to {}", id, traits.highest_id);
    if (!seen.insert(id).second) rejectInput("--ids: {} is there twice", id);
  }
  return ids;
}

std::string deviceText(const ConfigPlan& plan, int rate) {
  const config::DeviceConfig device = deviceOf(plan);
  const config::DeviceTraits& traits = config::traitsOf(device.kind);
  std::string text = fmt::format("device:\n  kind: {}\n", plan.kind);
  if (traits.wire == config::DeviceWire::kNone) return text + "  watchdog_ms: 200\n";
  text += fmt::format("  port: {}\n", inQuotes(plan.port));
  const bool is_slow = rate < kUsualRate;
  if (traits.wire == config::DeviceWire::kCan) {
    text += fmt::format("  carrier: {}\n  can_bitrate: {}\n",
                        device.carrier == config::CanCarrier::kSlcan ? "slcan" : "socketcan",
                        device.can_bitrate);
    if (device.carrier == config::CanCarrier::kSlcan && device.is_baud_told)
      text += fmt::format("  baud: {}\n", device.baud);
  } else {
    text += fmt::format("  baud: {}{}\n", device.baud,
                        is_slow ? "  # a higher rate of the motors permits a faster loop" : "");
    text += "  reply_timeout_ms: 20  # USB adapters keep bytes for up to 16 ms\n";
  }
  switch (device.kind) {
    case DeviceKind::kSimulated:
      break;
    case DeviceKind::kDynamixel:
      // Three periods at least.
      text += fmt::format("  watchdog_ms: {}\n", is_slow ? 400 : 200);
      break;
    case DeviceKind::kAbilityHand:
      text += "  watchdog_ms: 300         # the hand's own and fixed\n";
      break;
    case DeviceKind::kODrive:
      text +=
          "  firmware: \"0.6\"\n"
          "  watchdog_ms: 200         # FILL IN: as saved on the axes; each ARM proves it\n";
      break;
    case DeviceKind::kInspire:
      text += "  force_N: 1               # at a fingertip, where it stops\n";
      break;
    case DeviceKind::kAllegro:
      text +=
          "  reply_timeout_ms: 2\n"
          "  stiffness_Nm_rad: 0.4    # the position loop is ours: FILL IN what holds it\n"
          "  damping_Nm_s_rad: 0.02\n"
          "  torque_Nm: 0.15          # the most of each motor\n";
      break;
  }
  if (!traits.has_watchdog) {
    text +=
        "  no_watchdog: FILL IN     # `accepted`, if you accept that it has none: should the "
        "bridge die, its motors go on turning\n";
  }
  return text;
}

/// How long the loop may be late: as long as the device's watchdog, and the task, bear.
int longestGapMs(int rate) {
  if (rate > kUsualRate) return 30;
  return rate < kUsualRate ? 350 : 150;
}

const char* unitOf(bool slides) {
  return slides ? "m" : "rad";
}

/// How fast joints of either kind may move, as far as there are any, up to the head of the
/// list.
std::string motionText(const std::vector<Joint>& joints) {
  std::string keys, note;
  const auto add = [&](bool slides) {
    const auto is_such = [slides](const Joint& joint) {
      return joint.slides == slides;
    };
    if (std::none_of(joints.begin(), joints.end(), is_such)) return;
    const double velocity = slides ? kTravel * kVelocity : kVelocity;
    const char* unit = unitOf(slides);
    keys += fmt::format("{}velocity_{}_s: {}, acceleration_{}_s2: {}, jerk_{}_s3: {}",
                        keys.empty() ? "" : ", ", unit, velocity, unit, 10 * velocity, unit,
                        200 * velocity);
    if (slides) {
      note =
          "# FILL IN travel_m_rad: by so many metres a joint moves for a radian of its motor,\n"
          "# a pinion's radius or a screw's lead / 6.283; the motor's angles are its metres / "
          "travel_m_rad.\n";
    }
  };
  add(false);
  add(true);
  return fmt::format("motion: {{{}}}  # slow, to begin with\n\n{}joints:\n", keys, note);
}

/// What the config says of a motor beyond its joint's limits.
std::string motorText(const config::DeviceTraits& traits, const Joint& joint, int id) {
  if (traits.wire == config::DeviceWire::kNone) return "";
  std::string text = fmt::format(", id: {}", id);
  if (traits.own_motors == 0) text += ", current_A: 0.2";
  if (traits.kind != DeviceKind::kInspire) return text;
  // A finger's way counts from 1 open to 0 closed, rounded inwards.
  const double gear = std::floor(1e6 * 0.9998 / (joint.upper - joint.lower)) * 1e-6;
  return text + fmt::format(", direction: -1, zero_rad: {:.6f}, gear: {:.6f}",
                            0.9999 + gear * joint.lower, gear);
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
  if (joints.empty()) rejectInput("{}: no joint of it moves", handgraft::quoted(urdf.string()));
  followTheFirst(joints);
  narrowToFollowers(joints);

  const auto motor_count = static_cast<std::size_t>(
      std::count_if(joints.begin(), joints.end(), [](const Joint& joint) {
        return joint.leader.empty();
      }));
  const config::DeviceTraits& traits = traitsNamed(plan.kind);
  const auto own = static_cast<std::size_t>(traits.own_motors);
  if (own > 0 && motor_count != own) {
    rejectInput("{}: {} of its joints move by themselves; a hand of kind {} has {} motors",
                handgraft::quoted(urdf.string()), motor_count, plan.kind, own);
  }
  const auto sliding = std::find_if(joints.begin(), joints.end(), [](const Joint& joint) {
    return joint.slides;
  });
  const bool any_slides = sliding != joints.end();
  if (own > 0 && any_slides) {
    rejectInput("joint {} slides; those of a hand of kind {} turn",
                handgraft::quoted(sliding->name), plan.kind);
  }
  const int rate = rateOf(plan, motor_count);
  const std::vector<int> ids = idsOf(plan, traits, motor_count);
  const bool is_simulated = traits.wire == config::DeviceWire::kNone;
  const char* next_steps = is_simulated
                               ? "# It moves a simulated hand, which knows its zeros.\n"
                               : "# `jog` turns one motor at a time; `check` asks for "
                                 "directions and zeros and keeps "
                                 "them in\n# the calibration file.\n";
  std::string text = fmt::format(
      "# Of {}, to be filled in: FILL IN marks what only the hand itself knows.\n{}"
      "format: handgraft-hardware/1\nhand: {}          # as the server calls it: the file's "
      "name, unless "
      "it was loaded with --name\n\n{}\n",
      urdf.filename().string(), next_steps, inQuotes(nameFromPath(urdf)),
      deviceText(plan, rate));
  if (!is_simulated) {
    text += fmt::format("calibration: {}  # `check` writes it\n",
                        inQuotes(urdf.stem().string() + "_calibration.yaml"));
  }
  text += fmt::format("loop: {{rate_hz: {}, longest_gap_ms: {}}}\n", rate, longestGapMs(rate));
  // Slow answers are bearable for some periods, too.
  if (rate < kUsualRate) text += "watch: {silent_ms: 400}\n";
  text +=
      "stream: {stale_ms: 500, hold_ms: 1000}\nemergency_stop: {mode: brake, brake_ms: 500}\n";
  text += motionText(joints);
  std::string followers, motors;
  std::size_t count = 0;
  for (const Joint& joint : joints) {
    const std::string name = inQuotes(joint.name);
    const bool is_drawn = joint.slides && joint.leader.empty();
    const double travel = is_drawn ? kTravel : 1.0;
    text += fmt::format("  - {{name: {}, lower_{}: {}, upper_{}: {}{}}}\n", name,
                        unitOf(joint.slides), joint.lower, unitOf(joint.slides), joint.upper,
                        is_drawn ? fmt::format(", travel_m_rad: {}", travel) : "");
    if (!joint.leader.empty()) {
      followers +=
          fmt::format("    - {{joint: {}, leader: {}, ratio: {}, offset_{}: {}}}\n", name,
                      inQuotes(joint.leader), joint.ratio, unitOf(joint.slides), joint.offset);
      continue;
    }
    // A follower may ask for more of its leader than the leader's own limits.
    const double speed = 3 * kVelocity;
    motors += fmt::format(
        "  - {{name: {}, joint: {}, lower_rad: {:.12g}, upper_rad: {:.12g}, velocity_rad_s: "
        "{}{}}}\n",
        name, name, joint.lower / travel, joint.upper / travel, speed,
        motorText(traits, joint, ids[count]));
    ++count;
  }
  if (!followers.empty()) text += "\ntransmission:\n  kind: direct\n  followers:\n" + followers;
  const char* how = traits.wire == config::DeviceWire::kNone ? ""
                    : own > 0 ? ", by its place among the hand's own"
                              : ", by its id, and the current that it may use";
  text +=
      fmt::format("\n# FILL IN: which motor moves which joint{}.\nmotors:\n{}", how, motors);
  return text;
}

}  // namespace handgraft::bringup
