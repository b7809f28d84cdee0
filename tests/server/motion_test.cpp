// Motions, through the service: loaded, described, solved in a session, told frame by frame,
// exported.
#include "tests/server/motion_service.h"

namespace handgraft::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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
  EXPECT_EQ(motion.demonstrator(), v1::CHIRALITY_RIGHT);
  EXPECT_EQ(motion.patches().size(), motion.presence().size());
  EXPECT_THAT(motion.file(), HasSubstr("handgraft-motion/1"));

  // The file that it tells is the same motion.
  bus.ask(test::putFile(50, "again.json", motion.file()));
  const v1::Reply again = bus.ask(test::loadModel(50, v1::MODEL_MOTION, "again", "again.json"));
  EXPECT_EQ(again.error(), v1::ERROR_NONE) << again.message();
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_MOTION, "again")).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_MOTION, "again")).error(), v1::ERROR_NOT_FOUND);
}

TEST_F(MotionTest, WhatAHandDidIsWhatItTouched) {
  const std::uint64_t session = open();
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  const std::vector<std::uint8_t> exported =
      bus.ask(exportAs(session, v1::EXPORT_JSON)).body().exported_file().content();
  const std::string done(exported.begin(), exported.end());
  std::uint64_t upload = 60;
  const auto load_done = [&](const std::string& name, const std::string& plan) {
    ++upload;
    bus.ask(test::putFile(upload, "plan.json", plan));
    bus.ask(test::putFile(upload, "done.json", done));
    return bus.ask(test::loadModel(upload, v1::MODEL_MOTION, name, "plan.json", "fruit"));
  };
  const auto plan_of = [](const std::string& more) {
    return R"({"format": "handgraft-motion-plan/1", "hand_trajectory": "done.json")" + more +
           "}";
  };
  const v1::Reply loaded = load_done("done", plan_of(R"(, "hand": "clamp")"));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  const v1::MotionDescription motion =
      bus.ask(test::describeModel(v1::MODEL_MOTION, "done", true)).body().model().motion();
  EXPECT_EQ(motion.frame_count(), 16u);
  EXPECT_EQ(motion.object(), "fruit");
  EXPECT_FALSE(motion.patches().empty());
  ASSERT_FALSE(motion.notes().empty());
  EXPECT_THAT(motion.notes()[0], HasSubstr("what hand 'clamp' touches on its way"));

  EXPECT_EQ(motion.notes().size(), 1u) << "all joints are named";

  // The same once more changes nothing; of another reach it is another motion.
  EXPECT_EQ(load_done("done", plan_of(R"(, "hand": "clamp")")).error(), v1::ERROR_NONE);
  EXPECT_EQ(load_done("done", plan_of(R"(, "hand": "clamp", "reach_m": 0.012)")).error(),
            v1::ERROR_CONFLICT);
  EXPECT_EQ(load_done("done", plan_of(R"(, "hand": "clamp", "every_s": 100)")).error(),
            v1::ERROR_CONFLICT)
      << "before anything is cut";

  bus.ask(test::putFile(59, "plan.json", plan_of(R"(, "hand": "clamp")")));
  const std::string nothing =
      R"({"format": "handgraft-trajectory/1", "object": "pear", "joint_names": ["nail"],
          "frames": [{"time_s": 0, "joints": [0]}]})";
  bus.ask(test::putFile(59, "done.json", nothing));
  const v1::Reply unknown =
      bus.ask(test::loadModel(59, v1::MODEL_MOTION, "other", "plan.json", "fruit"));
  EXPECT_THAT(unknown.message(), HasSubstr("'nail'"));

  bus.ask(test::putFile(58, "plan.json", plan_of(R"(, "hand": "clamp")")));
  bus.ask(test::putFile(58, "done.json",
                        R"({"format": "handgraft-trajectory/1", "joint_names": ["hinge"],
          "frames": [{"time_s": 0, "joints": [40], "X_WH": {"p_m": [9, 0, 0], "q_wxyz": [1, 0, 0, 0]}},
                     {"time_s": 1, "joints": [41], "X_WH": {"p_m": [9, 0, 0], "q_wxyz": [1, 0, 0, 0]}}]})"));
  const v1::Reply degrees =
      bus.ask(test::loadModel(58, v1::MODEL_MOTION, "other", "plan.json", "fruit"));
  EXPECT_THAT(degrees.message(), HasSubstr("touches nothing"));
  EXPECT_THAT(degrees.message(), HasSubstr("radians, not degrees"));

  const v1::Reply of_nobody = load_done("other", plan_of(R"(, "hand": "glove")"));
  EXPECT_EQ(of_nobody.error(), v1::ERROR_NOT_FOUND);
  EXPECT_THAT(of_nobody.message(), HasSubstr("glove"));
  const v1::Reply far = load_done("other", plan_of(R"(, "hand": "clamp", "reach_m": 3)"));
  EXPECT_EQ(far.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(far.message(), HasSubstr("reach is 3 m; permitted are 0.0001 to 0.1"));
  const v1::Reply seldom = load_done("other", plan_of(R"(, "hand": "clamp", "every_s": -1)"));
  EXPECT_THAT(seldom.message(), HasSubstr("every -1 s; permitted are 0.001 to 10"));
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
  const v1::MotionSummary summary = bus.ask(solveMotion(session, false)).body().motion();
  const v1::Reply all = bus.ask(framesFrom(session, 0));
  ASSERT_EQ(all.error(), v1::ERROR_NONE) << all.message();
  const v1::MotionFrames& frames = all.body().motion_frames();
  ASSERT_EQ(frames.frames().size(), 16u);
  double depth_m = 0.0;
  double self_depth_m = 0.0;
  for (const v1::MotionFrame& frame : frames.frames()) {
    depth_m = std::max(depth_m, frame.max_depth_m());
    self_depth_m = std::max(self_depth_m, frame.self_depth_m());
  }
  EXPECT_EQ(depth_m, summary.max_depth_m());
  EXPECT_EQ(self_depth_m, summary.self_depth_m());
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

// A file of a session that somebody was followed in is not what the hand did then.
TEST_F(MotionTest, WhatADemonstratorWasRefusedIsNoFile) {
  const std::uint64_t session = open();
  ASSERT_EQ(bus.ask(solveMotion(session)).error(), v1::ERROR_NONE);
  EXPECT_TRUE(
      bus.ask(exportAs(session, v1::EXPORT_CSV)).body().exported_file().notes().empty());
  v1::Pose X;
  X.q_wxyz({1.0, 0.0, 0.0, 0.0});
  v1::DemonstratorFrame frame;
  frame.session_id(session);
  frame.client({1});
  frame.sequence_number(1);
  frame.kind(v1::DEMONSTRATOR_JOINTS);
  frame.hand("clamp");
  frame.values({0.1, 0.2});
  frame.X_WH().push_back(X);
  frame.X_WO(X);
  bus.send(frame);
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& state) {
    return state.session_id() == session && state.following().verdict() == v1::FOLLOW_REFUSED;
  }));
  EXPECT_TRUE(
      bus.ask(exportAs(session, v1::EXPORT_CSV)).body().exported_file().notes().empty());
  v1::RequestBody live = exportAs(session, v1::EXPORT_CSV);
  live.export_file().live(true);
  EXPECT_THAT(bus.ask(live).message(), HasSubstr("has followed no demonstrator yet"));
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

}  // namespace
}  // namespace handgraft::server
