#include "hardware/bridge/publisher.h"

#include <utility>
#include <vector>

#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

constexpr std::chrono::milliseconds kStatusPeriod(100);
constexpr std::chrono::seconds kDiagnosisPeriod(1);  // as ROS's aggregators expect

bool isNews(const v1::BridgeStatus& status, const v1::BridgeStatus& last) {
  return status.state() != last.state() || status.fault() != last.fault() ||
         status.power() != last.power() || status.homed() != last.homed() ||
         status.homing() != last.homing() || status.reason() != last.reason() ||
         status.session_id() != last.session_id() ||
         status.last_refusal() != last.last_refusal();
}

}  // namespace

std::chrono::nanoseconds systemTimeOf(Publisher::Clock::time_point moment) {
  const auto age = Publisher::Clock::now() - moment;
  return std::chrono::system_clock::now().time_since_epoch() - age;
}

Publisher::Publisher(const idl::cyclone::Participant& participant,
                     const std::string& ros_namespace,
                     std::uint32_t bridge_id,
                     RosNode::Obey obey,
                     const std::shared_ptr<WakeEvent>& bell)
    : joint_states_(participant, idl::kJointStateTopic),
      statuses_(participant, idl::kBridgeStatusTopic),
      ros_(participant, ros_namespace, bridge_id, std::move(obey), bell) {}

bool Publisher::isDue(const v1::BridgeStatus& status, Clock::time_point now) const {
  return isNews(status, last_status_) || now >= status_due_;
}

void Publisher::publish(const BridgeIdentity& identity,
                        const MotionState& state,
                        const MotionState* news,
                        const v1::BridgeStatus& status,
                        Clock::time_point now) {
  const bool is_due = isDue(status, now);
  const bool is_diagnosed = status.state() != last_status_.state() ||
                            status.reason() != last_status_.reason() || now >= diagnosis_due_;
  // A writer that fails is not tried again at once.
  if (is_due) {
    status_due_ = now + kStatusPeriod;
    last_status_ = status;
  }
  const std::vector<std::string>& names = identity.joints;
  if (news != nullptr || (names.empty() && is_due)) {
    const bool is_measured = news != nullptr && news->is_connected;
    const auto stamp = systemTimeOf(is_measured ? news->measured_at : now);
    joint_states_.write(jointState(identity, names, state, ++sequence_number_, stamp));
    if (is_measured) ros_.publish(identity, names, *news, stamp);
  }
  if (is_due) statuses_.write(status);
  if (is_diagnosed) {
    diagnosis_due_ = now + kDiagnosisPeriod;
    ros_.publish(status, systemTimeOf(now));
  }
  ros_.serve(status, now);
}

}  // namespace handgraft::bridge
