// Motions, through the service: loaded, described, solved in a session, told frame by frame,
// exported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kPlan =
    R"({"format": "handgraft-motion-plan/1", "first": "first.json", "path": "path.csv",
        "rate_hz": 30})";
constexpr const char* kPath =
    "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n0.5,-0.05,0,0.3,0.98,0,0,0.199\n";

v1::RequestBody openMotion(const std::string& hand,
                           const std::string& object,
                           const std::string& motion) {
  v1::OpenSessionRequest open;
  open.hand(hand);
  open.object(object);
  open.motion(motion);
  v1::RequestBody body;
  body.open_session(open);
  return body;
}

v1::RequestBody solveMotion(std::uint64_t session, bool causal = false) {
  v1::SolveMotionRequest request;
  request.session_id(session);
  v1::MotionOptions options;
  options.causal(causal);
  request.options().push_back(options);
  v1::RequestBody body;
  body.solve_motion(request);
  return body;
}

v1::RequestBody framesFrom(std::uint64_t session,
                           std::uint32_t first,
                           std::uint32_t count = 0,
                           std::uint32_t every = 0,
                           bool with_shapes = false) {
  v1::MotionFramesRequest request;
  request.session_id(session);
  request.first(first);
  request.count(count);
  request.every(every);
  request.with_shapes(with_shapes);
  v1::RequestBody body;
  body.motion_frames(request);
  return body;
}

v1::RequestBody exportAs(std::uint64_t session, v1::ExportFormat format) {
  v1::ExportRequest request;
  request.session_id(session);
  request.format(format);
  v1::RequestBody body;
  body.export_file(request);
  return body;
}

class MotionTest : public testing::Test {
 protected:
  MotionTest() {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  v1::Reply load(const std::string& name,
                 const std::string& plan = kPlan,
                 const std::string& path = kPath) {
    const std::uint64_t upload = ++uploads_;
    bus.ask(test::putFile(upload, "plan.json", plan));
    bus.ask(test::putFile(upload, "first.json", test::builtIn("contacts/lemon_6.json")));
    bus.ask(test::putFile(upload, "path.csv", path));
    return bus.ask(test::loadModel(upload, v1::MODEL_MOTION, name, "plan.json", "fruit"));
  }

  std::uint64_t open() {
    EXPECT_EQ(load("pull").error(), v1::ERROR_NONE);
    const v1::Reply opened = bus.ask(openMotion("clamp", "fruit", "pull"));
    EXPECT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
    EXPECT_EQ(opened.body().session().motion(), "pull");
    EXPECT_EQ(opened.body().session().contacts(), "");
    return opened.body().session().session_id();
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};

 private:
  std::uint64_t uploads_ = 10;
};

TEST_F(MotionTest, AMotionIsAModelAsAnyOther) {
  const v1::Reply loaded = load("pull");
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_EQ(loaded.body().models().models()[0].kind(), v1::MODEL_MOTION);
  EXPECT_THAT(loaded.body().models().models()[0].text(), HasSubstr("16 frames in 0.50 s"));

  const v1::Reply told = bus.ask(test::describeModel(v1::MODEL_MOTION, "pull", true));
  ASSERT_EQ(told.error(), v1::ERROR_NONE) << told.message();
  const v1::MotionDescription& motion = told.body().model().motion();
  EXPECT_EQ(motion.frame_count(), 16u);
  EXPECT_EQ(motion.object(), "fruit");
  EXPECT_EQ(motion.patches().size(), motion.presence().size());
  EXPECT_THAT(motion.file(), HasSubstr("handgraft-motion/1"));

  // The file that it tells is the same motion.
  bus.ask(test::putFile(50, "again.json", motion.file()));
  const v1::Reply again = bus.ask(test::loadModel(50, v1::MODEL_MOTION, "again", "again.json"));
  EXPECT_EQ(again.error(), v1::ERROR_NONE) << again.message();
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_MOTION, "again")).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_MOTION, "again")).error(), v1::ERROR_NOT_FOUND);
}

/// A server that has no models but its own.
struct BareServer {
  BareServer() { service.start(); }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
};

v1::RequestBody loadSaved(const std::string& text) {
  v1::LoadSessionRequest load;
  load.text(text);
  v1::RequestBody body;
  body.load_session(load);
  return body;
}

TEST_F(MotionTest, IsSavedWithItsModelsAndOpenedWhereNobodyHasThem) {
  const std::uint64_t session = open();
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const auto before =
      bus.ask(exportAs(session, v1::EXPORT_CSV)).body().exported_file().content();
  ASSERT_FALSE(before.empty());
  const v1::Reply saved = bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session));
  ASSERT_EQ(saved.error(), v1::ERROR_NONE) << saved.message();
  const std::string text = saved.body().saved_session().text();

  BareServer other;
  const v1::Reply loaded = other.bus.ask(loadSaved(text));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_EQ(loaded.body().session().motion(), "pull");
  EXPECT_EQ(loaded.body().session().contacts(), "");
  const std::uint64_t opened = loaded.body().session().session_id();
  // It is to be solved as it was; whoever asks gets the same answer.
  ASSERT_EQ(other.bus.ask(solveMotion(opened)).error(), v1::ERROR_NONE);
  EXPECT_EQ(other.bus.ask(exportAs(opened, v1::EXPORT_CSV)).body().exported_file().content(),
            before);
  const v1::Reply again = other.bus.ask(test::ofSession(v1::OP_SAVE_SESSION, opened));
  EXPECT_EQ(again.error(), v1::ERROR_NONE) << again.message();

  v1::ReplayRequest replay;
  replay.text(text);
  v1::RequestBody body;
  body.replay(replay);
  const v1::Reply replayed = other.bus.ask(body);
  ASSERT_EQ(replayed.error(), v1::ERROR_NONE) << replayed.message();
  EXPECT_TRUE(replayed.body().replay().same()) << replayed.body().replay().message();
}

TEST_F(MotionTest, SavedIsNotOpenedOnAnotherMotionOfItsName) {
  const std::uint64_t session = open();
  const std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  ASSERT_EQ(bus.ask(test::unloadModel(v1::MODEL_MOTION, "pull")).error(), v1::ERROR_NONE);
  std::string path = kPath;
  path.replace(path.find("-0.05"), 5, "-0.06");
  ASSERT_EQ(load("pull", kPlan, path).error(), v1::ERROR_NONE);
  const v1::Reply loaded = bus.ask(loadSaved(text));
  EXPECT_EQ(loaded.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(loaded.message(), HasSubstr("motion 'pull' is another one"));
}

TEST_F(MotionTest, IsSolvedEitherWayAndToldFrameByFrame) {
  const std::uint64_t session = open();
  for (const bool causal : {false, true}) {
    const v1::Reply solved = bus.ask(solveMotion(session, causal));
    ASSERT_EQ(solved.error(), v1::ERROR_NONE) << solved.message();
    const v1::MotionSummary& summary = solved.body().motion();
    EXPECT_EQ(summary.frame_count(), 16u);
    EXPECT_EQ(summary.options().causal(), causal);
    EXPECT_GT(summary.mean_mm(), 0.0);
    // The contacts stand still on the object, so the hand does, too.
    EXPECT_LT(summary.max_step(), 0.02);
    EXPECT_LT(summary.max_depth_m(), 0.002);
  }
  const v1::Reply all = bus.ask(framesFrom(session, 0));
  ASSERT_EQ(all.error(), v1::ERROR_NONE) << all.message();
  const v1::MotionFrames& frames = all.body().motion_frames();
  ASSERT_EQ(frames.frames().size(), 16u);
  EXPECT_TRUE(frames.is_last());
  EXPECT_NEAR(frames.frames()[15].time_s(), 0.5, 1e-12);
  EXPECT_NEAR(frames.frames()[15].X_WO().p_m()[0], -0.05, 1e-12);
  EXPECT_EQ(frames.frames()[0].joint_positions().size(), 1u);
  EXPECT_TRUE(frames.frames()[0].X_WL().empty());
  ASSERT_FALSE(frames.frames()[0].patches().empty());

  const v1::Reply some = bus.ask(framesFrom(session, 1, 2, 5, true));
  const auto& shown = some.body().motion_frames().frames();
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[1].index(), 6u);
  EXPECT_EQ(shown[1].X_WL().size(), 2u);
  EXPECT_FALSE(shown[1].patches()[0].outline_O_m().empty());
  EXPECT_FALSE(some.body().motion_frames().is_last());
}

TEST_F(MotionTest, IsExportedAsEachFormat) {
  const std::uint64_t session = open();
  EXPECT_EQ(bus.ask(exportAs(session, v1::EXPORT_CSV)).error(), v1::ERROR_INVALID_INPUT);
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  for (const v1::ExportFormat format :
       {v1::EXPORT_JSON, v1::EXPORT_CSV, v1::EXPORT_GLB, v1::EXPORT_NPZ, v1::EXPORT_MJCF,
        v1::EXPORT_ROS_TRAJECTORY}) {
    const v1::Reply reply = bus.ask(exportAs(session, format));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    EXPECT_GT(reply.body().exported_file().content().size(), 100u);
  }
  EXPECT_THAT(bus.ask(exportAs(session, v1::EXPORT_OBJ)).message(), HasSubstr("no format obj"));
}

TEST_F(MotionTest, NamesWhatIsWrong) {
  EXPECT_THAT(load("bad", kPlan, "time_s,x,y,z,qw,qx,qy,qz\n0,nan,0,0,1,0,0,0\n").message(),
              AllOf(HasSubstr("line 2"), HasSubstr("nan")));
  EXPECT_THAT(load("bad", "{}").message(), HasSubstr("format"));
  EXPECT_EQ(bus.ask(openMotion("clamp", "fruit", "nowhere")).error(), v1::ERROR_NOT_FOUND);
  const std::uint64_t session = open();
  EXPECT_THAT(bus.ask(framesFrom(session, 0)).message(), HasSubstr("no answer yet"));
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  EXPECT_THAT(bus.ask(framesFrom(session, 16)).message(), HasSubstr("frames 0 to 15"));
  const v1::Reply of_contacts = bus.ask(test::openSession("clamp", "fruit", "marks"));
  EXPECT_THAT(bus.ask(solveMotion(of_contacts.body().session().session_id())).message(),
              HasSubstr("holds contacts, no motion"));
  EXPECT_THAT(
      bus.ask(exportAs(of_contacts.body().session().session_id(), v1::EXPORT_NPZ)).message(),
      HasSubstr("format of motions"));
}

TEST_F(MotionTest, OfOneFrameIsAGrasp) {
  ASSERT_EQ(load("one", kPlan, "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n").error(),
            v1::ERROR_NONE);
  const v1::Reply opened = bus.ask(openMotion("clamp", "fruit", "one"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const v1::Reply solved = bus.ask(solveMotion(opened.body().session().session_id()));
  ASSERT_EQ(solved.error(), v1::ERROR_NONE) << solved.message();
  EXPECT_EQ(solved.body().motion().frame_count(), 1u);
  EXPECT_EQ(solved.body().motion().rms_jerk(), 0.0);
}

// === Edits at a time

constexpr const char* kLongPath =
    "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n4,-0.05,0,0.3,0.98,0,0,0.199\n";

class MotionEditTest : public MotionTest {
 protected:
  MotionEditTest() {
    EXPECT_EQ(load("long", kPlan, kLongPath).error(), v1::ERROR_NONE);
    session_ = bus.ask(openMotion("clamp", "fruit", "long")).body().session().session_id();
  }

  v1::EditReply edit(const v1::EditBody& body, std::optional<v1::EditTime> when = {}) {
    v1::Edit edit;
    edit.client({7});
    edit.edit_id(++edits_);
    edit.session_id(session_);
    if (when) edit.when().push_back(*when);
    edit.body(body);
    bus.send(edit);
    const auto reply =
        bus.await<v1::EditReply>(bus.edit_replies, [&](const v1::EditReply& one) {
          return one.edit_id() == edits_;
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

  std::vector<v1::MotionFrame> framesNow() {
    return bus.ask(framesFrom(session_, 0)).body().motion_frames().frames();
  }

  v1::SessionState state() {
    return bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session_)).body().session();
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

  std::uint64_t session_ = 0;
  std::uint64_t edits_ = 0;
};

TEST_F(MotionEditTest, ChangesTheFramesAboutItAndUndoesThemToTheByte) {
  ASSERT_EQ(bus.ask(solveMotion(session_)).error(), v1::ERROR_NONE);
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
  ASSERT_EQ(bus.ask(solveMotion(session_)).error(), v1::ERROR_NONE);
  const std::vector<v1::MotionFrame> before = framesNow();
  const v1::EditReply reply = edit(lockOfJoint(state()));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  toldOf(reply.revision());
  for (const v1::MotionFrame& frame : framesNow())
    EXPECT_NEAR(frame.joint_positions()[0], before[60].joint_positions()[0] + 0.02, 1e-9);
}

TEST_F(MotionEditTest, OnTheHandOfAllOfTheMotionTurnsEveryFrame) {
  ASSERT_EQ(bus.ask(solveMotion(session_)).error(), v1::ERROR_NONE);
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

TEST_F(MotionEditTest, SaysWhatIsWrong) {
  v1::DragEdit drag;
  drag.link("clamp_palm");
  v1::EditBody body;
  body.drag(drag);
  EXPECT_EQ(edit(body, at(1.0, 0.1)).error(), v1::ERROR_INVALID_INPUT);
  ASSERT_EQ(bus.ask(solveMotion(session_)).error(), v1::ERROR_NONE);
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
  v1::MotionClock set = bus.ask(clock(session_, v1::CLOCK_SEEK, 1.5)).body().clock();
  EXPECT_EQ(set.time_s(), 1.5);
  EXPECT_EQ(set.speed(), 1.0);
  EXPECT_FALSE(set.playing());
  set = bus.ask(clock(session_, v1::CLOCK_SPEED, 0.01)).body().clock();
  set = bus.ask(clock(session_, v1::CLOCK_PLAY)).body().clock();
  EXPECT_TRUE(set.playing());
  EXPECT_EQ(set.duration_s(), 4.0);
  const v1::MotionClock later = bus.ask(clock(session_, v1::CLOCK_PAUSE), 2).body().clock();
  EXPECT_NEAR(later.time_s(),
              1.5 + 0.01e-9 * static_cast<double>(later.stamp_ns() - set.stamp_ns()), 1e-9);
  EXPECT_EQ(later.last_client()[0], 2);
  EXPECT_EQ(bus.count(bus.clocks), 4u);
  EXPECT_THAT(bus.ask(clock(session_, v1::CLOCK_SEEK, 5.0)).message(), HasSubstr("0 to 4 s"));
  EXPECT_THAT(bus.ask(clock(session_, v1::CLOCK_SPEED, 0.0)).message(), HasSubstr("above 0"));
  bus.ask(clock(session_, v1::CLOCK_SEEK, 4.0));
  EXPECT_EQ(bus.ask(clock(session_, v1::CLOCK_PLAY)).body().clock().time_s(), 0.0);
}

}  // namespace
}  // namespace handgraft::server
