#pragma once

#include <cstddef>
#include <string>

/// The one list of topics. Types are in the IDL files; the README says who writes and reads
/// what.
namespace handgraft::idl {

/// Quality of service, spelled out for each vendor in `server/transport` and `idl/cyclone`.
enum class Qos {
  kService,    ///< reliable, volatile, keep-last 256: requests, replies, edits, commands
  kState,      ///< reliable, transient-local, keep-last 1 per instance: late joiners see it
  kEvents,     ///< as kState, but readers keep 64: who has joined misses none, in order
  kTelemetry,  ///< reliable, volatile, keep-last 10: measured states, progress
};

/// Samples kept of each instance.
struct Depth {
  int writer = 1;
  int reader = 1;
};

constexpr Depth depthOf(Qos profile) {
  switch (profile) {
    case Qos::kService:
      return {256, 256};
    case Qos::kState:
      return {1, 1};
    case Qos::kEvents:
      // Late joiners get the newest alone: older ones would tell them what is not so any more.
      return {1, 64};
    case Qos::kTelemetry:
      return {10, 10};
  }
  return {};
}

/// Late joiners see what is kept.
constexpr bool isKept(Qos profile) {
  return profile == Qos::kState || profile == Qos::kEvents;
}

/// Largest message that the server takes, bytes; saved sessions are the largest ones sent.
inline constexpr std::size_t kLargestRequest = 16UL * 1024 * 1024;

template <class Message>
struct Topic {
  const char* name = "";
  Qos qos{};
  /// Of a ROS 2 topic, RIHS01_...: announced as ROS since Iron expects it, without type
  /// information. Empty: a topic of ours.
  const char* ros_type_hash = "";
};

}  // namespace handgraft::idl

namespace handgraft::v1 {
class Request;
class Reply;
class Progress;
class Edit;
class EditReply;
class PoseSolution;
class SessionState;
class MotionFrames;
class MotionClock;
class DemonstratorFrame;
class ServerStatus;
class HandCommand;
class JointState;
class BridgeStatus;
}  // namespace handgraft::v1

// NOLINTBEGIN(readability-identifier-naming): ROS 2's
namespace sensor_msgs::msg::dds_ {
class JointState_;
}  // namespace sensor_msgs::msg::dds_

namespace trajectory_msgs::msg::dds_ {
class JointTrajectory_;
}  // namespace trajectory_msgs::msg::dds_

namespace diagnostic_msgs::msg::dds_ {
class DiagnosticArray_;
}  // namespace diagnostic_msgs::msg::dds_

namespace std_srvs::srv::dds_ {
class Trigger_Request_;
class Trigger_Response_;
}  // namespace std_srvs::srv::dds_

// NOLINTEND(readability-identifier-naming)

namespace handgraft::idl {

inline constexpr Topic<v1::Request> kRequestTopic{"handgraft/v1/request", Qos::kService};
/// In a secured domain what only looks, and what operators alone may ask for, has topics of its
/// own (idl/security): who may write them is then DDS' to enforce.
inline constexpr Topic<v1::Request> kLookTopic{"handgraft/v1/look", Qos::kService};
inline constexpr Topic<v1::Request> kOperateTopic{"handgraft/v1/operate", Qos::kService};
inline constexpr Topic<v1::Reply> kReplyTopic{"handgraft/v1/reply", Qos::kService};
inline constexpr Topic<v1::Progress> kProgressTopic{"handgraft/v1/progress", Qos::kTelemetry};
inline constexpr Topic<v1::Edit> kEditTopic{"handgraft/v1/edit", Qos::kService};
inline constexpr Topic<v1::EditReply> kEditReplyTopic{"handgraft/v1/edit_reply", Qos::kService};
inline constexpr Topic<v1::PoseSolution> kSolutionTopic{"handgraft/v1/pose_solution",
                                                        Qos::kState};
inline constexpr Topic<v1::SessionState> kSessionTopic{"handgraft/v1/session_state",
                                                       Qos::kEvents};
inline constexpr Topic<v1::ServerStatus> kStatusTopic{"handgraft/v1/server_status",
                                                      Qos::kState};
/// What an edit of a motion changed, as it is solved: the frames about it first.
inline constexpr Topic<v1::MotionFrames> kMotionFramesTopic{"handgraft/v1/motion_frames",
                                                            Qos::kService};
/// One clock a session, that all who watch its motion share.
inline constexpr Topic<v1::MotionClock> kMotionClockTopic{"handgraft/v1/motion_clock",
                                                          Qos::kState};
/// A demonstrator, live: each frame is answered by a pose of its session.
inline constexpr Topic<v1::DemonstratorFrame> kDemonstratorTopic{"handgraft/v1/demonstrator",
                                                                 Qos::kTelemetry};
inline constexpr Topic<v1::HandCommand> kHandCommandTopic{"handgraft/v1/hand_command",
                                                          Qos::kService};
inline constexpr Topic<v1::JointState> kJointStateTopic{"handgraft/v1/joint_state",
                                                        Qos::kTelemetry};
inline constexpr Topic<v1::BridgeStatus> kBridgeStatusTopic{"handgraft/v1/bridge_status",
                                                            Qos::kState};

/// Measured states only; solved poses go to rt/handgraft/<session>/joint_command, the same
/// type.
inline constexpr Topic<sensor_msgs::msg::dds_::JointState_> kRosJointStatesTopic{
    "rt/joint_states", Qos::kTelemetry,
    "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"};

/// What the governor lets a hand do, one point at a time: for drivers that move it themselves.
inline constexpr Topic<trajectory_msgs::msg::dds_::JointTrajectory_> kRosTrajectoryTopic{
    "rt/joint_trajectory", Qos::kTelemetry,
    "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"};
/// Timed samples for a session's hand: rt/handgraft/<session>/joint_trajectory, as
/// `sampleTopicName` makes it. A sample that comes too late is of no use any more.
inline constexpr Topic<trajectory_msgs::msg::dds_::JointTrajectory_> kRosSamplesTopic{
    "rt/handgraft/0/joint_trajectory", Qos::kTelemetry, kRosTrajectoryTopic.ros_type_hash};

inline std::string sampleTopicName(unsigned long long session) {
  return "rt/handgraft/" + std::to_string(session) + "/joint_trajectory";
}

inline constexpr Topic<diagnostic_msgs::msg::dds_::DiagnosticArray_> kRosDiagnosticsTopic{
    "rt/diagnostics", Qos::kTelemetry,
    "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"};

/// Topics that one server of several on a domain speaks on with those who mean it: in DDS'
/// partition of its name, so that others neither hear nor answer. The rest, a server's status
/// first of all, is everybody's.
template <class Message>
inline constexpr bool kIsOfOneServer = false;
template <>
inline constexpr bool kIsOfOneServer<v1::Request> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::Reply> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::Progress> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::Edit> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::EditReply> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::PoseSolution> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::SessionState> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::MotionFrames> = true;
template <>
inline constexpr bool kIsOfOneServer<v1::MotionClock> = true;

/// Of all services, whose names `hardware/bridge/ros_node` makes.
inline constexpr const char* kRosTriggerHash =
    "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";

}  // namespace handgraft::idl
