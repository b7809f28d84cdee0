#pragma once

#include <cstddef>

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
inline constexpr std::size_t kLargestRequest = 16 * 1024 * 1024;

template <class Message>
struct Topic {
  const char* name;
  Qos qos;
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
class ServerStatus;
class HandCommand;
class JointState;
class BridgeStatus;
}  // namespace handgraft::v1

namespace sensor_msgs::msg::dds_ {
class JointState_;
}  // namespace sensor_msgs::msg::dds_

namespace handgraft::idl {

inline constexpr Topic<v1::Request> kRequestTopic{"handgraft/v1/request", Qos::kService};
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
inline constexpr Topic<v1::HandCommand> kHandCommandTopic{"handgraft/v1/hand_command",
                                                          Qos::kService};
inline constexpr Topic<v1::JointState> kJointStateTopic{"handgraft/v1/joint_state",
                                                        Qos::kTelemetry};
inline constexpr Topic<v1::BridgeStatus> kBridgeStatusTopic{"handgraft/v1/bridge_status",
                                                            Qos::kState};

/// Measured states only; solved poses go to rt/handgraft/<session>/joint_command, the same
/// type.
inline constexpr Topic<sensor_msgs::msg::dds_::JointState_> kRosJointStatesTopic{
    "rt/joint_states", Qos::kTelemetry};

}  // namespace handgraft::idl
