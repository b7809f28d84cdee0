#include "hardware/bridge/ros_node.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/bridge/inbox.h"
#include "idl/fields.h"
#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

using Clock = std::chrono::steady_clock;
using Request = std_srvs::srv::dds_::Trigger_Request_;
using Response = std_srvs::srv::dds_::Trigger_Response_;
using idl::cyclone::Participant;
using idl::cyclone::Writer;

constexpr std::chrono::seconds kPatience(10);
constexpr std::size_t kLongestName = 200;

struct Verb {
  v1::HandCommandKind kind;
  const char* name;
};

constexpr std::array<Verb, 5> kVerbs = {{{v1::COMMAND_ARM, "arm"},
                                         {v1::COMMAND_DISARM, "disarm"},
                                         {v1::COMMAND_ESTOP, "estop"},
                                         {v1::COMMAND_RESET, "reset"},
                                         {v1::COMMAND_HOME, "home"}}};

bool isOff(const v1::BridgeStatus& status) {
  return status.power() != v1::POWER_ON && status.state() != v1::BRIDGE_ARMED &&
         status.state() != v1::BRIDGE_HOLDING;
}

std_msgs::msg::dds_::Header_ headerAt(std::chrono::nanoseconds system_ns) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(system_ns);
  std_msgs::msg::dds_::Header_ header;
  header.stamp().sec(static_cast<std::int32_t>(seconds.count()));
  header.stamp().nanosec(static_cast<std::uint32_t>((system_ns - seconds).count()));
  return header;
}

// As diagnostic_msgs/DiagnosticStatus numbers them.
std::uint8_t levelOf(const v1::BridgeStatus& status) {
  constexpr std::uint8_t kOk = 0, kWarn = 1, kError = 2, kStale = 3;
  switch (status.state()) {
    case v1::BRIDGE_DISCONNECTED:
      return kStale;
    case v1::BRIDGE_FAULT:
    case v1::BRIDGE_ESTOP:
      return kError;
    case v1::BRIDGE_HOLDING:
      return kWarn;
    case v1::BRIDGE_IDLE:
    case v1::BRIDGE_ARMED:
      break;
  }
  const bool is_odd =
      !status.warnings().empty() || !status.clamping().empty() || !status.homed();
  return is_odd ? kWarn : kOk;
}

/// One Trigger service: its two topics, and who waits for an answer.
class Service {
 public:
  Service(const Participant& participant,
          const std::string& node,
          const Verb& verb,
          const std::shared_ptr<WakeEvent>& bell)
      : verb_(verb),
        request_name_(fmt::format("rq/{}/{}Request", node, verb.name)),
        reply_name_(fmt::format("rr/{}/{}Reply", node, verb.name)),
        requests_(participant,
                  {request_name_.c_str(), idl::Qos::kService, idl::kRosTriggerHash},
                  bell),
        replies_(participant, {reply_name_.c_str(), idl::Qos::kService, idl::kRosTriggerHash}) {
  }

  void serve(const v1::BridgeStatus& status, Clock::time_point now, const RosNode::Obey& obey) {
    requests_.take([&](const Request& request) {
      waiting_.push_back({request.client_guid(), request.sequence_number(), now,
                          status.refusal_count(), false});
      obey(verb_.kind);
    });
    for (Waiting& each : waiting_)
      settle(each, status, now);
    waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                  [](const Waiting& each) {
                                    return each.is_answered;
                                  }),
                   waiting_.end());
  }

 private:
  struct Waiting {
    std::uint64_t client_guid;
    std::int64_t sequence_number;
    Clock::time_point since;
    std::uint64_t refusals;  // that there had been
    bool is_answered;
    bool has_begun = false;  // of homing
  };

  void settle(Waiting& who, const v1::BridgeStatus& status, Clock::time_point now) {
    if (who.since == now) return;  // the status is older than the request
    const bool homes = verb_.kind == v1::COMMAND_HOME;
    const bool is_homing = status.homing();
    who.has_begun = who.has_begun || is_homing;
    const bool is_refused = status.refusal_count() != who.refusals &&
                            status.refusal() != v1::REFUSAL_NONE &&
                            status.refusal() != v1::REFUSAL_POSE;
    const bool is_done =
        homes ? who.has_begun && !is_homing && isOff(status) : isDone(verb_.kind, status);
    const bool is_late = !is_homing && now - who.since > kPatience;
    if (!is_refused && !is_done && !is_late) return;
    Response response;
    response.client_guid(who.client_guid);
    response.sequence_number(who.sequence_number);
    // Who asks for the motors to be off must not take what nobody knows for it.
    const bool is_known =
        (verb_.kind != v1::COMMAND_DISARM && verb_.kind != v1::COMMAND_ESTOP) ||
        status.power() != v1::POWER_UNKNOWN;
    response.success(!is_refused && is_done && is_known && (!homes || status.homed()));
    response.message(is_refused ? status.last_refusal() : status.reason());
    replies_.write(response);
    who.is_answered = true;
  }

  Verb verb_;
  std::string request_name_, reply_name_;
  Inbox<Request> requests_;
  Writer<Response> replies_;
  std::vector<Waiting> waiting_;
};

}  // namespace

std::string rosNamespace(const std::string& told) {
  std::string name = told;
  while (!name.empty() && name.front() == '/')
    name.erase(0, 1);
  while (!name.empty() && name.back() == '/')
    name.pop_back();
  bool is_fine = name.size() <= kLongestName;
  char before = '/';
  for (const char c : name) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool is_digit = c >= '0' && c <= '9';
    is_fine = is_fine && (is_letter || (is_digit && before != '/') ||
                          ((c == '_' || c == '/') && before != c));
    before = c;
  }
  if (!is_fine) {
    rejectInput(
        "ROS namespace {}: parts of letters, digits and single underscores, joined by single "
        "slashes, none beginning with a digit, {} characters at most",
        quoted(told), kLongestName);
  }
  return name;
}

trajectory_msgs::msg::dds_::JointTrajectory_ rosTrajectory(
    const std::vector<std::string>& names,
    const std::vector<double>& command,
    const std::vector<double>& before,
    double period_s) {
  trajectory_msgs::msg::dds_::JointTrajectory_ message;
  message.joint_names(names);  // a stamp of 0: from now on
  trajectory_msgs::msg::dds_::JointTrajectoryPoint_ point;
  point.positions(command);
  if (before.size() == command.size()) {
    std::vector<double> velocities(command.size());
    for (std::size_t i = 0; i < velocities.size(); ++i)
      velocities[i] = (command[i] - before[i]) / period_s;
    point.velocities(std::move(velocities));
  }
  const auto period = std::chrono::nanoseconds(std::llround(1e9 * period_s));
  const auto seconds = std::chrono::floor<std::chrono::seconds>(period);
  point.time_from_start().sec(static_cast<std::int32_t>(seconds.count()));
  point.time_from_start().nanosec(static_cast<std::uint32_t>((period - seconds).count()));
  message.points({point});
  return message;
}

diagnostic_msgs::msg::dds_::DiagnosticArray_ rosDiagnostics(
    const std::string& node,
    const v1::BridgeStatus& status,
    std::chrono::nanoseconds system_ns) {
  std::vector<diagnostic_msgs::msg::dds_::KeyValue_> values;
  const auto add = [&values](const char* key, const std::string& value) {
    diagnostic_msgs::msg::dds_::KeyValue_ pair;
    pair.key(key);
    pair.value(value);
    values.push_back(std::move(pair));
  };
  add("state", v1::nameOf(status.state()));
  add("fault", v1::nameOf(status.fault()));
  add("refusal", v1::nameOf(status.refusal()));
  add("last_refusal", status.last_refusal());
  add("hand", status.hand());
  add("power", v1::nameOf(status.power()));
  add("homed", status.homed() ? "true" : "false");
  add("clamping", status.clamping());
  add("warnings", status.warnings());
  add("temperature_c", fmt::format("{:.1f}", status.temperature_c()));
  add("tracking_rad", fmt::format("{:.5f}", status.tracking_rad()));
  add("residual_rad", fmt::format("{:.5f}", status.residual_rad()));
  add("overruns", std::to_string(status.overruns()));
  add("answers_lost", std::to_string(status.answers_lost()));
  diagnostic_msgs::msg::dds_::DiagnosticStatus_ told;
  told.level(levelOf(status));
  told.name(node + ": hand");
  told.message(status.reason());
  told.hardware_id(status.device());
  told.values(std::move(values));
  diagnostic_msgs::msg::dds_::DiagnosticArray_ message;
  message.header(headerAt(system_ns));
  message.status({told});
  return message;
}

bool isDone(v1::HandCommandKind kind, const v1::BridgeStatus& status) {
  switch (kind) {
    case v1::COMMAND_ARM:
      return status.state() == v1::BRIDGE_ARMED && status.power() == v1::POWER_ON;
    case v1::COMMAND_DISARM:
      return isOff(status);
    case v1::COMMAND_ESTOP:
      return status.state() == v1::BRIDGE_ESTOP && status.power() != v1::POWER_ON;
    case v1::COMMAND_RESET:
      return status.state() == v1::BRIDGE_IDLE || status.state() == v1::BRIDGE_DISCONNECTED;
    case v1::COMMAND_HOME:
      return status.homed() && !status.homing();
  }
  return false;
}

struct RosNode::Impl {
  Impl(const Participant& participant,
       const std::string& ros_namespace,
       std::uint32_t bridge_id,
       Obey told,
       const std::shared_ptr<WakeEvent>& bell)
      : obey(std::move(told)),
        prefix(ros_namespace.empty() ? "" : rosNamespace(ros_namespace) + "/"),
        name(prefix + (bridge_id == 1 ? "handgraft_bridge"
                                      : fmt::format("handgraft_bridge_{}", bridge_id))),
        joints_name("rt/" + prefix + "joint_states"),
        trajectory_name("rt/" + prefix + "joint_trajectory"),
        joints(participant, named(idl::kRosJointStatesTopic, joints_name)),
        trajectories(participant, named(idl::kRosTrajectoryTopic, trajectory_name)),
        diagnostics(participant, idl::kRosDiagnosticsTopic) {
    for (const Verb& verb : kVerbs)
      services.push_back(std::make_unique<Service>(participant, name, verb, bell));
  }

  template <class Message>
  static idl::Topic<Message> named(idl::Topic<Message> topic, const std::string& name) {
    topic.name = name.c_str();
    return topic;
  }

  Obey obey;
  std::string prefix, name, joints_name, trajectory_name;
  Writer<sensor_msgs::msg::dds_::JointState_> joints;
  Writer<trajectory_msgs::msg::dds_::JointTrajectory_> trajectories;
  Writer<diagnostic_msgs::msg::dds_::DiagnosticArray_> diagnostics;
  std::vector<std::unique_ptr<Service>> services;
  std::vector<double> before;  // the command of the last period under power
};

RosNode::RosNode(const Participant& participant,
                 const std::string& ros_namespace,
                 std::uint32_t bridge_id,
                 Obey obey,
                 const std::shared_ptr<WakeEvent>& bell)
    : impl_(std::make_unique<Impl>(
          participant, ros_namespace, bridge_id, std::move(obey), bell)) {}

RosNode::~RosNode() = default;

void RosNode::serve(const v1::BridgeStatus& status, Clock::time_point now) {
  for (const auto& service : impl_->services)
    service->serve(status, now, impl_->obey);
}

void RosNode::publish(const BridgeIdentity& identity,
                      const std::vector<std::string>& names,
                      const MotionState& state,
                      std::chrono::nanoseconds system_ns) {
  impl_->joints.write(rosJointState(identity.hand, names, state, system_ns));
  const bool moves = state.state == safety::GovernorState::kArmed && state.is_powered;
  if (moves) {
    impl_->trajectories.write(
        rosTrajectory(names, state.command, impl_->before, identity.period_s));
    impl_->before = state.command;
  } else {
    impl_->before.clear();
  }
}

void RosNode::publish(const v1::BridgeStatus& status, std::chrono::nanoseconds system_ns) {
  impl_->diagnostics.write(rosDiagnostics(impl_->name, status, system_ns));
}

const std::string& RosNode::name() const {
  return impl_->name;
}

}  // namespace handgraft::bridge
