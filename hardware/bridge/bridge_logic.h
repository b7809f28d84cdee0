#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hardware/bridge/hand_driver.h"
#include "hardware/bridge/hand_plan.h"
#include "hardware/bridge/solution_follower.h"
#include "hardware/safety/joint_limiter.h"
#include "idl/hardware.h"
#include "idl/models.h"
#include "idl/sessions.h"

namespace handgraft::bridge {

/// What a bridge is told when it starts.
struct BridgeOptions {
  std::uint32_t bridge_id = 1;
  std::optional<std::uint64_t> session;  ///< absent: the one that began to stream last
  bool with_intermediate = false;        ///< also follow poses of solves that still run
  /// Armed from the start, and a fresh pose ends a hold after the stream was lost. Without it,
  /// as a hand with real motors needs, both take an explicit ARM.
  bool arms_itself = true;
  double period_s = 0.01;
  MotionBounds bounds;
};

/// What the motors are to do now.
struct MotorOrder {
  bool powered = false;
  std::span<const double> positions;  ///< rad or m, one per joint, when powered
};

/// A hand that a session asked for and that the server must describe first.
struct HandQuestion {
  std::uint64_t session_id = 0;
  std::string hand;

  bool operator==(const HandQuestion&) const = default;
};

/// The bridge without wires, clocks and threads: messages go in, states and positions come out,
/// one `tick` a period. README has the table of states.
///
/// A pose is obeyed when it is complete and finite; each joint is clamped into its limits.
/// ESTOP, DISARM and a lost stream brake within the limits; ESTOP and DISARM then switch the
/// motors off. A fault switches them off at once. Nothing but ARM, or a fresh pose when
/// `arms_itself`, makes the hand move again.
///
/// Wrong messages never throw: they leave a remark. Not thread-safe.
class BridgeLogic {
 public:
  explicit BridgeLogic(const BridgeOptions& options);

  // === What came in

  void see(const v1::SessionState& state);
  void see(const v1::PoseSolution& solution);
  /// Obeys a command to this bridge. The same id and kind again is a repeat: passed over.
  void obey(const v1::HandCommand& command);
  /// Whether a server is there; the first `false` after a `true` is the loss of the stream.
  void serverIsThere(bool is_there);
  /// The device or its wire failed: latched until RESET.
  void fail(const std::string& why);
  /// The bridge goes away: as DISARM, without a remark.
  void release();
  /// Leaves a remark, unless it is the last one again.
  void say(std::string text);

  // === Which hand

  /// The question that stands, until it is answered or refused.
  [[nodiscard]] const std::optional<HandQuestion>& question() const { return question_; }

  void answer(const HandQuestion& question, const v1::HandDescription& description);
  void refuse(const HandQuestion& question, const std::string& why);

  /// The hand to be driven; null before the first answer.
  [[nodiscard]] const HandPlan* plan() const { return plan_ ? &*plan_ : nullptr; }

  /// Grows each time the plan becomes another one: the driver must be made anew.
  [[nodiscard]] unsigned planVersion() const { return plan_version_; }

  // === What goes out

  /// Advances by one period from what the hand measured. Before there is a plan: no power.
  MotorOrder tick(const JointReading& measured);

  [[nodiscard]] v1::BridgeState state() const;

  /// The last remark, for people.
  [[nodiscard]] const std::string& message() const { return message_; }

  /// Remarks not yet taken, oldest first, at most 64.
  std::deque<std::string> takeRemarks() { return std::exchange(remarks_, {}); }

  /// The session whose pose was accepted last; 0: none.
  [[nodiscard]] std::uint64_t session() const { return session_; }

  /// The last accepted pose, inside the limits, in the plan's order; empty before the first.
  [[nodiscard]] const std::vector<double>& target() const { return target_; }

 private:
  void considerPose();
  void accept(const FollowedPose& pose);
  void arm();
  void resume();
  void slowDown();
  void noteArrival(const JointReading& measured);
  bool isRepeat(const v1::HandCommand& command);

  BridgeOptions options_;
  SolutionFollower follower_;
  std::optional<FollowedPose> waiting_;  // for its hand's description
  std::optional<HandQuestion> question_;
  std::optional<HandQuestion> answered_;  // the plan's
  std::optional<HandPlan> plan_;
  unsigned plan_version_ = 0;
  std::optional<safety::JointLimiter> limiter_;

  bool armed_;
  bool estop_ = false;
  bool fault_ = false;
  bool server_is_there_ = false;
  bool lost_ = false;   // the stream; ends by a fresh pose or ARM
  bool fresh_ = false;  // a pose was accepted since the loss
  bool powered_ = false;
  std::uint64_t session_ = 0;
  std::vector<double> target_;
  bool arrived_ = false;  // and said so
  std::deque<std::pair<std::uint64_t, v1::HandCommandKind>> obeyed_;
  std::string message_;
  std::deque<std::string> remarks_;
};

}  // namespace handgraft::bridge
