#include "idl/security/rights.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::idl::security {

namespace {

using Topics = std::vector<std::string>;

Topics operator+(Topics topics, const Topics& more) {
  topics.insert(topics.end(), more.begin(), more.end());
  return topics;
}

Topics ofServers() {
  return {kStatusTopic.name, kSessionTopic.name, kSolutionTopic.name, kMotionFramesTopic.name,
          kMotionClockTopic.name};
}

// What everybody may see: how servers, sessions and hands are.
Topics streams() {
  return ofServers() + Topics{kBridgeStatusTopic.name, kJointStateTopic.name, "rt/*"};
}

Topics answers() {
  return {kReplyTopic.name, kProgressTopic.name, kEditReplyTopic.name};
}

Topics edits() {
  return {kLookTopic.name, kRequestTopic.name, kEditTopic.name, kDemonstratorTopic.name};
}

// In ROS 2's namespace of that name, and in none.
Topics ofRos(const std::string& name, const char* topic) {
  return {fmt::format("rt/{}", topic), fmt::format("rt/{}/{}", name, topic)};
}

constexpr const char* kSamples = "rt/handgraft/*/joint_trajectory";

}  // namespace

const char* nameOf(Role role) {
  switch (role) {
    case Role::kServer:
      return "server";
    case Role::kOperator:
      return "operator";
    case Role::kEditor:
      return "editor";
    case Role::kViewer:
      return "viewer";
    case Role::kHand:
      return "hand";
  }
  return "";
}

std::string namesOfRoles() {
  std::string names;
  for (const Role role : kRoles)
    names += std::string(names.empty() ? "" : ", ") + nameOf(role);
  return names;
}

Role roleNamed(const std::string& name) {
  for (const Role role : kRoles) {
    if (name == nameOf(role)) return role;
  }
  rejectInput("{} is no role; there are {}", quoted(name), namesOfRoles());
}

Rights rightsOf(Role role, const std::string& name) {
  switch (role) {
    case Role::kServer:
      // Its supervisor looks whether it answers.
      return {answers() + ofServers() + Topics{kLookTopic.name, "rt/handgraft/*/joint_command"},
              edits() + Topics{kOperateTopic.name, kStatusTopic.name}};
    case Role::kOperator:
      return {edits() + Topics{kOperateTopic.name, kHandCommandTopic.name, kSamples,
                               "rq/handgraft_bridge*", "rq/*/handgraft_bridge*"},
              answers() + streams() + Topics{"rr/*"}};
    case Role::kEditor:
      return {edits(), answers() + streams()};
    case Role::kViewer:
      return {{kLookTopic.name}, answers() + streams()};
    case Role::kHand:
      // Samples, rt/handgraft/<session>/joint_trajectory, steer hands: no pattern of a hand's
      // own topics may match them. Deny rules would do so, but for Cyclone, which does not make
      // the topic then, not even to read it.
      return {Topics{kLookTopic.name, kBridgeStatusTopic.name, kJointStateTopic.name, "rr/*"} +
                  ofRos(name, "joint_states") + ofRos(name, "joint_trajectory") +
                  ofRos(name, "diagnostics"),
              answers() + streams() + Topics{kHandCommandTopic.name, "rq/*"}};
  }
  return {};
}

const Topic<v1::Request>& requestTopicOf(Privilege privilege) {
  switch (privilege) {
    case Privilege::kLook:
      return kLookTopic;
    case Privilege::kEdit:
      return kRequestTopic;
    case Privilege::kOperate:
      break;
  }
  return kOperateTopic;
}

const char* holdersOf(Privilege privilege) {
  switch (privilege) {
    case Privilege::kLook:
      return "operators, editors, viewers and hands";
    case Privilege::kEdit:
      return "operators and editors";
    case Privilege::kOperate:
      break;
  }
  return "operators";
}

}  // namespace handgraft::idl::security
