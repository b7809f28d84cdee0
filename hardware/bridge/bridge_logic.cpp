#include "hardware/bridge/bridge_logic.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

constexpr std::size_t kRememberedCommands = 1024;
constexpr std::size_t kMostRemarks = 64;
constexpr double kArrived = 1e-3;  // rad: finer than the encoders of small hands, 4096 a turn

bool samePlan(const HandPlan& a, const HandPlan& b) {
  const auto same_limits = [](const safety::JointLimits& x, const safety::JointLimits& y) {
    return x.lower == y.lower && x.upper == y.upper && x.velocity == y.velocity &&
           x.acceleration == y.acceleration && x.jerk == y.jerk && x.margin == y.margin;
  };
  return a.hand == b.hand && a.names == b.names &&
         std::equal(a.limits.begin(), a.limits.end(), b.limits.begin(), b.limits.end(),
                    same_limits);
}

// The pose in the plan's order. Joints are told by name: the session's order need not be ours.
std::vector<double> inOrderOf(const HandPlan& plan, const FollowedPose& pose) {
  if (pose.joint_rad.size() != pose.names.size()) {
    rejectInput("{} values for {} joints", pose.joint_rad.size(), pose.names.size());
  }
  std::map<std::string, double> values;
  for (std::size_t i = 0; i < pose.names.size(); ++i) {
    const double value = pose.joint_rad[i];
    if (!std::isfinite(value)) {
      rejectInput("joint {}: {} is not finite", quoted(pose.names[i]), value);
    }
    if (!values.emplace(pose.names[i], value).second) {
      rejectInput("joint {} is named twice", quoted(pose.names[i]));
    }
  }
  std::vector<double> ordered;
  ordered.reserve(plan.jointCount());
  for (const std::string& name : plan.names) {
    const auto found = values.find(name);
    if (found == values.end()) rejectInput("joint {} is missing", quoted(name));
    ordered.push_back(found->second);
    values.erase(found);
  }
  if (!values.empty()) {
    rejectInput("hand {} has no joint {}", quoted(plan.hand), quoted(values.begin()->first));
  }
  return ordered;
}

}  // namespace

BridgeLogic::BridgeLogic(const BridgeOptions& options)
    : options_(options),
      follower_(options.session, options.with_intermediate),
      armed_(options.arms_itself) {}

// === What came in

void BridgeLogic::see(const v1::SessionState& state) {
  follower_.see(state);
  considerPose();
}

void BridgeLogic::see(const v1::PoseSolution& solution) {
  follower_.see(solution);
  considerPose();
}

void BridgeLogic::obey(const v1::HandCommand& command) {
  if (command.bridge_id() != options_.bridge_id || isRepeat(command)) return;
  switch (command.kind()) {
    case v1::COMMAND_ARM:
      arm();
      return;
    case v1::COMMAND_DISARM:
      armed_ = false;
      slowDown();
      say("disarmed");
      return;
    case v1::COMMAND_ESTOP:
      estop_ = true;
      armed_ = false;
      slowDown();
      say("emergency stop; RESET, then ARM, to move again");
      return;
    case v1::COMMAND_RESET:
      if (!estop_ && !fault_) {
        say("nothing to reset");
        return;
      }
      estop_ = false;
      fault_ = false;
      armed_ = false;
      say("reset; ARM to move again");
      return;
    case v1::COMMAND_HOME:
      say("this hand needs no homing");
      return;
  }
  say(fmt::format("command {} is not one of ARM, DISARM, ESTOP, RESET",
                  static_cast<int>(command.kind())));
}

void BridgeLogic::serverIsThere(bool is_there) {
  if (is_there == server_is_there_) return;
  server_is_there_ = is_there;
  if (is_there) {
    say("server found");
    if (lost_ && fresh_ && options_.arms_itself) resume();
    return;
  }
  // What comes later is news, and the question goes with the server that could answer it.
  follower_.forget();
  waiting_.reset();
  question_.reset();
  answered_.reset();
  lost_ = true;
  fresh_ = false;
  slowDown();
  say("the server is gone; holding");
}

void BridgeLogic::fail(const std::string& why) {
  fault_ = true;
  armed_ = false;
  powered_ = false;
  say(why);
}

void BridgeLogic::release() {
  armed_ = false;
  slowDown();
}

// === Which hand

void BridgeLogic::considerPose() {
  if (std::optional<FollowedPose> pose = follower_.take()) waiting_ = std::move(pose);
  if (!waiting_) return;
  const HandQuestion question{waiting_->session_id, waiting_->hand};
  if (plan_ && answered_ == question) {
    question_.reset();
    accept(*std::exchange(waiting_, std::nullopt));
  } else {
    question_ = question;
  }
}

void BridgeLogic::answer(const HandQuestion& question, const v1::HandDescription& description) {
  if (question_ != question) return;  // another hand is wanted by now
  HandPlan plan;
  try {
    plan = planHand(description, options_.bounds);
    plan.hand = question.hand;
    if (!plan_ || !samePlan(*plan_, plan)) {
      limiter_.emplace(plan.limits, options_.period_s);
      plan_ = std::move(plan);
      ++plan_version_;
      powered_ = false;
      target_.clear();
      session_ = 0;
      if (!options_.arms_itself) armed_ = false;
      say(fmt::format("hand {}: {} joints", quoted(question.hand), plan_->jointCount()));
    }
  } catch (const InvalidInput& error) {
    refuse(question, error.what());
    return;
  }
  answered_ = question;
  considerPose();
}

void BridgeLogic::refuse(const HandQuestion& question, const std::string& why) {
  if (question_ != question) return;
  // The next pose asks again; until then there is nothing new to say.
  question_.reset();
  waiting_.reset();
  say(fmt::format("session {}: {}", question.session_id, why));
}

void BridgeLogic::accept(const FollowedPose& pose) {
  std::vector<double> ordered;
  try {
    ordered = inOrderOf(*plan_, pose);
  } catch (const InvalidInput& error) {
    say(fmt::format("session {}: pose refused: {}", pose.session_id, error.what()));
    return;
  }
  for (std::size_t i = 0; i < ordered.size(); ++i)
    ordered[i] = limiter_->allowed(i, ordered[i]);
  if (ordered != target_) arrived_ = false;
  target_ = std::move(ordered);
  session_ = pose.session_id;
  fresh_ = true;
  if (lost_ && options_.arms_itself && server_is_there_) lost_ = false;
  if (!lost_) resume();
  say(fmt::format("following session {}", pose.session_id));
}

// === Motion

void BridgeLogic::arm() {
  if (estop_ || fault_) {
    say("ARM refused: RESET first");
  } else if (!plan_) {
    say("ARM refused: no hand yet");
  } else if (!server_is_there_) {
    say("ARM refused: no server");
  } else {
    armed_ = true;
    say("armed");
    resume();
  }
}

// Moves on towards the last accepted pose.
void BridgeLogic::resume() {
  lost_ = false;
  if (armed_ && powered_ && !target_.empty()) limiter_->aim(target_);
}

void BridgeLogic::slowDown() {
  if (powered_) limiter_->brake();
}

MotorOrder BridgeLogic::tick(const JointReading& measured) {
  if (!plan_) return {};
  if (measured.position.size() != plan_->jointCount()) {
    fail(fmt::format("the hand measured {} joints of {}", measured.position.size(),
                     plan_->jointCount()));
    return {};
  }
  for (std::size_t i = 0; i < measured.position.size(); ++i) {
    if (std::isfinite(measured.position[i])) continue;
    fail(fmt::format("joint {}: measured position is not finite", quoted(plan_->names[i])));
    return {};
  }
  noteArrival(measured);
  const bool wants_power = armed_ && !estop_ && !fault_;
  if (wants_power && !powered_) {
    // Motors go on where the hand is; the limiter makes the way from there.
    limiter_->reset(measured.position);
    powered_ = true;
    if (!lost_ && !target_.empty()) limiter_->aim(target_);
  } else if (!wants_power && (fault_ || limiter_->atRest())) {
    powered_ = false;
  }
  if (!powered_) return {};
  return {true, limiter_->step()};
}

void BridgeLogic::noteArrival(const JointReading& measured) {
  if (arrived_ || target_.empty() || state() != v1::BRIDGE_ARMED) return;
  for (std::size_t i = 0; i < target_.size(); ++i) {
    if (std::abs(measured.position[i] - target_[i]) > kArrived) return;
  }
  arrived_ = true;
  say(fmt::format("session {}: pose reached", session_));
}

v1::BridgeState BridgeLogic::state() const {
  if (estop_) return v1::BRIDGE_ESTOP;
  if (fault_) return v1::BRIDGE_FAULT;
  if (!plan_) return v1::BRIDGE_DISCONNECTED;
  if (!armed_) return v1::BRIDGE_IDLE;
  return lost_ ? v1::BRIDGE_HOLDING : v1::BRIDGE_ARMED;
}

bool BridgeLogic::isRepeat(const v1::HandCommand& command) {
  const std::pair key{command.command_id(), command.kind()};
  if (std::find(obeyed_.begin(), obeyed_.end(), key) != obeyed_.end()) return true;
  if (obeyed_.size() >= kRememberedCommands) obeyed_.pop_front();
  obeyed_.push_back(key);
  return false;
}

void BridgeLogic::say(std::string text) {
  if (text == message_) return;
  message_ = text;
  if (remarks_.size() >= kMostRemarks) remarks_.pop_front();
  remarks_.push_back(std::move(text));
}

}  // namespace handgraft::bridge
