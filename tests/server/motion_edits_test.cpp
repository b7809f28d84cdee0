// A motion that is solved is edited: about a time, or all of it; and the clock of all who
// watch.
#include <optional>
#include <string>
#include <vector>

#include "tests/server/motion_service.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;

constexpr const char* kLongPath =
    "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n4,-0.05,0,0.3,0.98,0,0,0.199\n";

class MotionEditTest : public MotionTest {
 protected:
  MotionEditTest() {
    EXPECT_EQ(load("long", kPlan, kLongPath).error(), v1::ERROR_NONE);
    session = bus.ask(openMotion("clamp", "fruit", "long")).body().session().session_id();
  }

  v1::EditReply edit(const v1::EditBody& body,
                     std::optional<v1::EditTime> when = {},
                     std::uint64_t base_revision = 0) {
    v1::Edit edit;
    edit.base_revision(base_revision);
    edit.client({7});
    edit.edit_id(++edits);
    edit.session_id(session);
    if (when) edit.when().push_back(*when);
    edit.body(body);
    bus.send(edit);
    const auto reply =
        bus.await<v1::EditReply>(bus.edit_replies, [&](const v1::EditReply& one) {
          return one.edit_id() == edits;
        });
    return reply.value_or(v1::EditReply());
  }

  static v1::EditTime at(double time_s, double falloff_s) {
    v1::EditTime when;
    when.time_s(time_s);
    when.falloff_s(falloff_s);
    return when;
  }

  v1::EditBody lockOfJoint(const v1::SessionState& state) {
    v1::JointLimitEdit limit;
    limit.joint(state.joint_names().at(0));
    const double there = framesNow()[60].joint_positions()[0];
    limit.lower(there + 0.02);
    limit.upper(there + 0.02);
    v1::EditBody body;
    body.joint_limit(limit);
    return body;
  }

  static v1::EditBody steps(v1::EditKind kind) {
    v1::EditBody body;
    body.steps(v1::StepsEdit());
    body._d(kind);
    return body;
  }

  static v1::EditBody takeBack(std::uint32_t index) {
    v1::RemoveTimedEdit edit;
    edit.index(index);
    v1::EditBody body;
    body.take_back(edit);
    return body;
  }

  /// The edits at times that hold.
  std::vector<v1::TimedState> timed() {
    return bus.ask(test::ofSession(v1::OP_SESSION_SETTINGS, session)).body().settings().timed();
  }

  std::vector<v1::MotionFrame> framesNow() {
    return bus.ask(framesFrom(session, 0)).body().motion_frames().frames();
  }

  v1::SessionState state() {
    return bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).body().session();
  }

  /// What was told of a revision's frames, in order; all of it.
  std::vector<v1::MotionFrames> toldOf(std::uint64_t revision) {
    EXPECT_TRUE(bus.await<v1::MotionFrames>(bus.frames, [&](const v1::MotionFrames& one) {
      return one.revision() == revision && one.is_last();
    }));
    std::vector<v1::MotionFrames> told;
    for (const v1::MotionFrames& one : bus.copyOf(bus.frames))
      if (one.revision() == revision) told.push_back(one);
    return told;
  }

  std::uint64_t session = 0;
  std::uint64_t edits = 0;
};

// The grasp that stands for a motion, which nobody has solved, is all zeros: who follows the
// session on motors must not be sent there.
TEST_F(MotionEditTest, AreAnsweredByFramesAndByNoPose) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  v1::PatchWeightEdit weight;
  weight.patch("thumb");
  weight.weight(2.0);
  v1::EditBody body;
  body.patch_weight(weight);
  const v1::EditReply reply = edit(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  ASSERT_TRUE(bus.await<v1::MotionFrames>(bus.frames, [&](const v1::MotionFrames& some) {
    return some.is_last() && some.revision() == reply.revision();
  }));
  EXPECT_EQ(bus.count(bus.solutions), 0u);
  EXPECT_EQ(bus.count(bus.commands), 0u);
}

// Half way between the least and the most of what it does.
TEST_F(MotionEditTest, ALockHoldsAJointInTheMiddleOfItsMotion) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  double least = 1e9;
  double most = -1e9;
  for (const v1::MotionFrame& frame : framesNow()) {
    least = std::min(least, frame.joint_positions()[0]);
    most = std::max(most, frame.joint_positions()[0]);
  }
  v1::JointLockEdit lock;
  lock.joint("hinge");
  lock.locked(true);
  v1::EditBody body;
  body.joint_lock(lock);
  const v1::EditReply reply = edit(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  ASSERT_TRUE(bus.await<v1::MotionFrames>(bus.frames, [&](const v1::MotionFrames& some) {
    return some.is_last() && some.revision() == reply.revision();
  }));
  for (const v1::MotionFrame& frame : framesNow())
    EXPECT_NEAR(frame.joint_positions()[0], 0.5 * (least + most), 1e-9);
}

TEST_F(MotionEditTest, OfItsObjectsPlaceAreRefused) {
  v1::EditBody body;
  v1::Pose X;
  X.q_wxyz({1.0, 0.0, 0.0, 0.0});
  body.X_WO(X);
  EXPECT_THAT(edit(body).message(), HasSubstr("goes the way that motion 'long' tells"));
}

TEST_F(MotionEditTest, ChangesTheFramesAboutItAndUndoesThemToTheByte) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const std::vector<v1::MotionFrame> before = framesNow();
  const v1::EditReply reply = edit(lockOfJoint(state()), at(2.0, 0.2));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const std::vector<v1::MotionFrames> told = toldOf(reply.revision());
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.back().frame_count(), 121u);
  EXPECT_TRUE(told.back().frames().empty());
  for (const v1::MotionFrame& frame : told.front().frames()) {
    EXPECT_GT(frame.time_s(), 1.2);
    EXPECT_LT(frame.time_s(), 2.8);
  }
  const std::vector<v1::MotionFrame> after = framesNow();
  EXPECT_NEAR(after[60].joint_positions()[0], before[60].joint_positions()[0] + 0.02, 1e-12);
  EXPECT_EQ(after[10], before[10]);
  EXPECT_EQ(after[110], before[110]);

  const v1::EditReply undone = edit(steps(v1::EDIT_UNDO));
  toldOf(undone.revision());
  EXPECT_EQ(framesNow(), before);
  const v1::EditReply redone = edit(steps(v1::EDIT_REDO));
  toldOf(redone.revision());
  EXPECT_EQ(framesNow(), after);
}

TEST_F(MotionEditTest, OfAllOfTheMotionIsAnsweredToo) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const std::vector<v1::MotionFrame> before = framesNow();
  const v1::EditReply reply = edit(lockOfJoint(state()));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  toldOf(reply.revision());
  for (const v1::MotionFrame& frame : framesNow())
    EXPECT_NEAR(frame.joint_positions()[0], before[60].joint_positions()[0] + 0.02, 1e-9);
}

TEST_F(MotionEditTest, OnTheHandOfAllOfTheMotionTurnsEveryFrame) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const std::vector<v1::MotionFrame> before = framesNow();
  v1::PatchDirectionEdit turn;
  turn.patch("index");
  turn.side(v1::SIDE_HAND);
  turn.angle_rad(0.4);
  v1::EditBody body;
  body.patch_direction(turn);
  const v1::EditReply reply = edit(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  toldOf(reply.revision());
  const std::vector<v1::MotionFrame> after = framesNow();
  ASSERT_EQ(after.size(), before.size());
  for (const std::size_t frame : {0u, 60u, 120u})
    EXPECT_NE(after[frame], before[frame]) << frame;
  const v1::EditReply undone = edit(steps(v1::EDIT_UNDO));
  toldOf(undone.revision());
  EXPECT_EQ(framesNow(), before);
}

TEST_F(MotionEditTest, IsTakenBackWhateverWasEditedSince) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const std::vector<v1::MotionFrame> before = framesNow();
  const v1::EditBody limit = lockOfJoint(state());
  ASSERT_EQ(edit(limit, at(1.0, 0.2)).error(), v1::ERROR_NONE);
  const v1::EditReply later = edit(limit, at(3.0, 0.2));
  ASSERT_EQ(later.error(), v1::ERROR_NONE) << later.message();
  toldOf(later.revision());
  const std::vector<v1::MotionFrame> both = framesNow();
  ASSERT_NE(both[30], before[30]);
  ASSERT_NE(both[90], before[90]);

  // The earlier one goes: its frames are as they were, the later one's stay.
  const v1::EditReply taken = edit(takeBack(0));
  ASSERT_EQ(taken.error(), v1::ERROR_NONE) << taken.message();
  toldOf(taken.revision());
  const std::vector<v1::MotionFrame> after = framesNow();
  EXPECT_EQ(after[30], before[30]);
  EXPECT_EQ(after[90], both[90]);
  ASSERT_EQ(timed().size(), 1u);
  EXPECT_EQ(timed()[0].time_s(), 3.0);

  // Taking back is an edit as any other: undone and redone.
  toldOf(edit(steps(v1::EDIT_UNDO)).revision());
  EXPECT_EQ(framesNow(), both);
  EXPECT_EQ(timed().size(), 2u);
  toldOf(edit(steps(v1::EDIT_REDO)).revision());
  EXPECT_EQ(framesNow(), after);

  toldOf(edit(takeBack(0)).revision());
  EXPECT_EQ(framesNow(), before);
  EXPECT_TRUE(timed().empty());
}

TEST_F(MotionEditTest, IsTakenBackByANumberThatThereIs) {
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  EXPECT_THAT(edit(takeBack(0)).message(), HasSubstr("edit 1 at a time: there are 0"));
  const v1::EditBody limit = lockOfJoint(state());
  const v1::EditReply first = edit(limit, at(1.0, 0.2));
  const v1::EditReply second = edit(limit, at(2.0, 0.2));
  ASSERT_EQ(second.error(), v1::ERROR_NONE) << second.message();
  const v1::EditReply refused = edit(takeBack(2));
  EXPECT_EQ(refused.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(refused.message(), HasSubstr("edit 3 at a time: there are 2"));
  EXPECT_EQ(edit(takeBack(256)).error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(edit(takeBack(0), at(2.0, 0.2)).message(), HasSubstr("has no time"));
  EXPECT_EQ(edit(takeBack(0), {}, first.revision()).error(), v1::ERROR_CONFLICT);
  EXPECT_EQ(state().revision(), second.revision());
  EXPECT_EQ(timed().size(), 2u);
}

TEST_F(MotionEditTest, SaysWhatIsWrong) {
  v1::DragEdit drag;
  drag.link("clamp_palm");
  v1::EditBody body;
  body.drag(drag);
  EXPECT_EQ(edit(body, at(1.0, 0.1)).error(), v1::ERROR_INVALID_INPUT);
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const v1::EditBody limit = lockOfJoint(state());
  EXPECT_THAT(edit(limit, at(9.0, 0.1)).message(), HasSubstr("has 0 to 4 s"));
  EXPECT_THAT(edit(limit, at(1.0, -0.1)).message(), HasSubstr("falloff"));
  v1::EditBody weights;
  weights.weights(v1::Weights());
  EXPECT_THAT(edit(weights, at(1.0, 0.1)).message(), HasSubstr("has no time"));
  EXPECT_EQ(state().undo_count(), 0u);
}

// === The clock

v1::RequestBody clock(std::uint64_t session, v1::ClockAction action, double value = 0.0) {
  v1::ClockRequest request;
  request.session_id(session);
  request.action(action);
  request.value(value);
  v1::RequestBody body;
  body.clock(request);
  return body;
}

TEST_F(MotionEditTest, OneClockIsSharedByAllWatchers) {
  v1::MotionClock set = bus.ask(clock(session, v1::CLOCK_SEEK, 1.5)).body().clock();
  EXPECT_EQ(set.time_s(), 1.5);
  EXPECT_EQ(set.speed(), 1.0);
  EXPECT_FALSE(set.playing());
  set = bus.ask(clock(session, v1::CLOCK_SPEED, 0.01)).body().clock();
  set = bus.ask(clock(session, v1::CLOCK_PLAY)).body().clock();
  EXPECT_TRUE(set.playing());
  EXPECT_EQ(set.duration_s(), 4.0);
  const v1::MotionClock later = bus.ask(clock(session, v1::CLOCK_PAUSE), 2).body().clock();
  EXPECT_NEAR(later.time_s(),
              1.5 + 0.01e-9 * static_cast<double>(later.stamp_ns() - set.stamp_ns()), 1e-9);
  EXPECT_EQ(later.last_client()[0], 2);
  EXPECT_EQ(bus.count(bus.clocks), 4u);
  EXPECT_THAT(bus.ask(clock(session, v1::CLOCK_SEEK, 5.0)).message(), HasSubstr("0 to 4 s"));
  EXPECT_THAT(bus.ask(clock(session, v1::CLOCK_SPEED, 0.0)).message(), HasSubstr("above 0"));
  bus.ask(clock(session, v1::CLOCK_SEEK, 4.0));
  EXPECT_EQ(bus.ask(clock(session, v1::CLOCK_PLAY)).body().clock().time_s(), 0.0);
}

}  // namespace
}  // namespace handgraft::server
