#include "tests/system/bridge_bench.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "hardware/config/hand_config_file.h"
#include "idl/topics.h"

#include "tests/support/shared_data.h"
#include "tests/system/service.h"

namespace handgraft::test {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(60);

std::int64_t nowNs() {
  return std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

idl::Topic<trajectory_msgs::msg::dds_::JointTrajectory_> samplesOn(const std::string& name) {
  auto topic = idl::kRosSamplesTopic;
  topic.name = name.c_str();
  return topic;
}

}  // namespace

StandInServer::StandInServer(const Network& network,
                             const std::string& hand,
                             const std::vector<std::string>& joint_names)
    : participant_(network),
      statuses_(participant_, idl::kStatusTopic),
      sessions_(participant_, idl::kSessionTopic),
      solutions_(participant_, idl::kSolutionTopic),
      sample_topic_(idl::sampleTopicName(kSession)),
      samples_(participant_, samplesOn(sample_topic_)) {
  state_.session_id(kSession);
  state_.hand(hand);
  state_.joint_names(joint_names);
  state_.phase(v1::PHASE_READY);
  sessions_.write(state_);
  life_ = std::thread([this] {
    for (int i = 0; !is_ending_; ++i) {
      if (i % 10 == 0 && !is_paused_) say(false);
      std::this_thread::sleep_for(milliseconds(50));
    }
  });
}

StandInServer::~StandInServer() {
  is_ending_ = true;
  life_.join();
  say(true);
}

void StandInServer::say(bool stops) {
  v1::ServerStatus status;
  status.server_id(77);
  status.stopping(stops);
  statuses_.write(status);
}

void StandInServer::take(const std::string& hand) {
  state_.hand(hand);
  state_.revision(state_.revision() + 1);
  sessions_.write(state_);
}

void StandInServer::stream(const std::vector<double>& joint_rad) {
  v1::PoseSolution pose;
  pose.session_id(kSession);
  pose.revision(state_.revision());
  pose.sequence_number(++number_);
  pose.stamp_ns(nowNs());
  pose.is_final(true);
  pose.joint_positions(joint_rad);
  solutions_.write(pose);
}

void StandInServer::sample(const std::vector<double>& joint_rad, std::int64_t stamp_ns) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  trajectory_msgs::msg::dds_::JointTrajectory_ message;
  message.header().stamp().sec(static_cast<std::int32_t>(stamp_ns / kSecondNs));
  message.header().stamp().nanosec(static_cast<std::uint32_t>(stamp_ns % kSecondNs));
  message.joint_names(state_.joint_names());
  trajectory_msgs::msg::dds_::JointTrajectoryPoint_ point;
  point.positions(joint_rad);
  message.points({point});
  samples_.write(message);
}

BridgeBench::BridgeBench(const Network& network, const std::string& config_text)
    : network_(network),
      config_(config::parseHandConfig(config_text)),
      participant_(network),
      commands_(participant_, idl::kHandCommandTopic),
      statuses_(participant_, idl::kBridgeStatusTopic),
      joint_states_(participant_, idl::kJointStateTopic) {
  rig_ = makeHandRig(config_, true);
  config_path_ = (scratchDirectory() / "bridge.yaml").string();
  std::ofstream(config_path_) << config_text;
}

void BridgeBench::startBridge(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = argumentsOf(1);
  arguments.insert(arguments.end(), more.begin(), more.end());
  bridge_ = std::make_unique<Process>(program("handgraft-bridge"), arguments);
}

std::vector<std::string> BridgeBench::argumentsOf(int bridge_id) const {
  return {"--config",    config_path_,
          "--port",      portOf(rig_->wire()),
          "--bridge-id", std::to_string(bridge_id),
          "--domain",    std::to_string(network_.domain)};
}

int BridgeBench::stopBridge() {
  bridge_->send(SIGTERM);
  return bridge_->wait();
}

std::vector<v1::JointState> BridgeBench::jointStates() {
  std::vector<v1::JointState> told;
  joint_states_.take([&](const v1::JointState& state) {
    told.push_back(state);
  });
  return told;
}

void BridgeBench::shout(v1::HandCommandKind kind) {
  v1::HandCommand message;
  message.bridge_id(1);
  message.command_id(++command_id_);
  message.kind(kind);
  commands_.write(message);
}

void BridgeBench::command(v1::HandCommandKind kind) {
  const auto give_up = steady_clock::now() + kPatience;
  while (commands_.readers() == 0 && steady_clock::now() < give_up)
    std::this_thread::sleep_for(milliseconds(20));
  shout(kind);
}

std::optional<v1::BridgeStatus> BridgeBench::status(
    const std::function<bool(const v1::BridgeStatus&)>& wanted) {
  std::optional<v1::BridgeStatus> found;
  const auto give_up = steady_clock::now() + kPatience;
  while (!found && steady_clock::now() < give_up) {
    statuses_.wait(milliseconds(100));
    statuses_.take([&](const v1::BridgeStatus& status) {
      if (!found && wanted(status)) found = status;
    });
  }
  return found;
}

std::optional<v1::BridgeStatus> BridgeBench::status(v1::BridgeState state) {
  return status([state](const v1::BridgeStatus& status) {
    return status.state() == state;
  });
}

bool BridgeBench::arm() {
  const auto give_up = steady_clock::now() + kPatience;
  while (steady_clock::now() < give_up) {
    const auto now = status([](const v1::BridgeStatus& status) {
      return status.state() != v1::BRIDGE_DISCONNECTED && status.poses_accepted() > 0;
    });
    if (!now) return false;
    if (now->state() == v1::BRIDGE_ARMED && now->power() == v1::POWER_ON) return true;
    if (now->state() == v1::BRIDGE_FAULT) command(v1::COMMAND_RESET);
    if (now->state() == v1::BRIDGE_IDLE || now->state() == v1::BRIDGE_HOLDING)
      command(v1::COMMAND_ARM);
    std::this_thread::sleep_for(milliseconds(300));
  }
  return false;
}

bool BridgeBench::arrive(const std::function<std::vector<double>()>& goals,
                         double tolerance_rad) {
  const auto give_up = steady_clock::now() + kPatience;
  while (steady_clock::now() < give_up) {
    const std::vector<double> wanted = goals();
    bool is_there = true;
    for (std::size_t i = 0; i < wanted.size(); ++i)
      is_there = is_there && std::abs(rig_->angle(i) - wanted[i]) <= tolerance_rad;
    if (is_there) return true;
    if (!arm()) return false;
  }
  return false;
}

void replace(std::string& text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("the example has no " + what);
  text.replace(at, what.size(), by);
}

std::string patientExample(const std::string& name) {
  std::ifstream file(sourceDirectory() / "hardware" / "config" / "examples" / (name + ".yaml"));
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (name == "ability_hand") {  // its own watchdog cannot be changed
    replace(text, "longest_gap_ms: 100", "longest_gap_ms: 280, overruns_in_a_row: 1000");
    replace(text, "watch: {limited_ms: 500}", "watch: {silent_ms: 1000}");
    replace(text, "baud: 460800",
            "baud: 460800\n  reply_timeout_ms: 5\n  tolerated_misses: 50");
  } else if (name == "inspire_rh56") {
    replace(text, "longest_gap_ms: 150", "longest_gap_ms: 1000, overruns_in_a_row: 1000");
    replace(text, "reply_timeout_ms: 10", "reply_timeout_ms: 20\n  tolerated_misses: 50");
    replace(text, "watch: {limited_ms: 1000}", "watch: {silent_ms: 1000}");
  } else if (name == "allegro") {
    replace(text, "carrier: socketcan", "carrier: slcan");  // as emulated adapters speak
    replace(text, "longest_gap_ms: 30, realtime_priority: 50",
            "longest_gap_ms: 1000, overruns_in_a_row: 1000");
    replace(text, "reply_timeout_ms: 2", "reply_timeout_ms: 3\n  tolerated_misses: 50");
    text += "watch: {silent_ms: 1000}\n";
  } else {
    replace(text, "longest_gap_ms: 80", "longest_gap_ms: 1000, overruns_in_a_row: 1000");
    replace(text, "watchdog_ms: 100",
            "watchdog_ms: 2500\n  reply_timeout_ms: 10\n  tolerated_misses: 50");
    text += "watch: {silent_ms: 1000}\n";
  }
  replace(text, "stream: {stale_ms: 500, hold_ms: 1000}",
          "stream: {stale_ms: 3000, hold_ms: 300}");
  return text;
}

std::string directConfig(const std::string& device,
                         const std::string& hand,
                         const std::vector<std::string>& joints,
                         double limit_rad) {
  const bool is_ability_hand = device == "ability_hand";
  const bool is_odrive = device == "odrive";
  constexpr std::size_t kAbilityHandMotors = 6;
  std::string text = fmt::format(
      "format: handgraft-hardware/1\nhand: {}\n"
      "device: {{kind: {}, port: PORT, baud: {}, watchdog_ms: {}, reply_timeout_ms: {}, "
      "tolerated_misses: 20{}}}\n"
      "loop: {{rate_hz: {}, longest_gap_ms: {}, overruns_in_a_row: 1000}}\n"
      "stream: {{stale_ms: 3000, hold_ms: 300}}\n"
      "arming: {{near_rad: 0.1, ramp_share: 1}}\n"
      "emergency_stop: {{mode: brake, brake_ms: 1000}}\n"
      "watch: {{silent_ms: 1000}}\n"
      "motion: {{velocity_rad_s: 2, acceleration_rad_s2: 10, jerk_rad_s3: 200}}\njoints:\n",
      hand, device, is_ability_hand ? 460800 : 4000000, is_ability_hand ? 300 : 2500,
      is_ability_hand ? 20 : 50, is_odrive ? ", carrier: slcan" : "", is_ability_hand ? 50 : 20,
      is_ability_hand ? 280 : 1000);
  const std::string range = fmt::format("lower_rad: {}, upper_rad: {}", -limit_rad, limit_rad);
  for (const std::string& joint : joints)
    text += fmt::format("  - {{name: \"{}\", {}}}\n", joint, range);
  std::size_t motors = joints.size();
  if (is_ability_hand && joints.size() > kAbilityHandMotors) {
    motors = kAbilityHandMotors;
    text += "transmission:\n  kind: direct\n  followers:\n";
    for (std::size_t i = motors; i < joints.size(); ++i) {
      text += fmt::format("    - {{joint: \"{}\", leader: \"{}\", ratio: 1, offset_rad: 0}}\n",
                          joints[i], joints[i - motors]);
    }
  }
  text += "motors:\n";
  for (std::size_t i = 0; i < motors; ++i) {
    text += fmt::format("  - {{name: m{}, {}, velocity_rad_s: 4", i, range);
    if (!is_ability_hand) text += fmt::format(", id: {}, current_A: 0.3", i);
    if (device == "dynamixel") text += ", zero_rad: 3.141592653589793";
    text += "}\n";
  }
  return text;
}

}  // namespace handgraft::test
