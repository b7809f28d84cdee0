#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "idl/hardware.h"
#include "idl/models.h"
#include "idl/sessions.h"

namespace handgraft::bridge::test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

inline v1::SessionState sessionState(std::uint64_t id,
                                     const std::string& hand,
                                     const std::vector<std::string>& names,
                                     v1::SessionPhase phase = v1::PHASE_READY) {
  v1::SessionState state;
  state.session_id(id);
  state.hand(hand);
  state.joint_names(names);
  state.phase(phase);
  return state;
}

inline v1::PoseSolution solution(std::uint64_t session,
                                 std::uint64_t number,
                                 const std::vector<double>& joint_rad,
                                 bool is_final = true) {
  v1::PoseSolution pose;
  pose.session_id(session);
  pose.sequence_number(number);
  pose.stamp_ns(static_cast<std::int64_t>(1000 * session + number));
  pose.is_final(is_final);
  pose.joint_positions(joint_rad);
  return pose;
}

inline v1::JointInfo joint(const std::string& name,
                           double lower,
                           double upper,
                           double velocity = 0) {
  v1::JointInfo info;
  info.name(name);
  info.kind(v1::JOINT_REVOLUTE);
  info.lower(lower);
  info.upper(upper);
  info.velocity_limit(velocity);
  return info;
}

inline v1::HandDescription handOf(const std::string& name,
                                  const std::vector<v1::JointInfo>& joints) {
  v1::HandDescription hand;
  hand.name(name);
  hand.joints(joints);
  return hand;
}

inline v1::HandCommand command(std::uint64_t id,
                               v1::HandCommandKind kind,
                               std::uint32_t bridge = 1) {
  v1::HandCommand message;
  message.bridge_id(bridge);
  message.command_id(id);
  message.kind(kind);
  return message;
}

}  // namespace handgraft::bridge::test
