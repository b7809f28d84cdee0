// Edits as the service runs them: in order, answered, followed by solutions.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"
#include "server/store/state_store.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr v1::ClientId kMe{1};
constexpr v1::ClientId kOther{2};

class LiveEdits : public testing::Test {
 protected:
  explicit LiveEdits(const ServiceOptions& options = {}) : service(bus, models, options) {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp()) {
      const v1::Reply reply = bus.ask(body);
      EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    }
  }

  std::uint64_t open() {
    const v1::Reply reply = bus.ask(test::openSession("clamp", "fruit", "marks"));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().session().session_id() : 0;
  }

  /// Opened and solved.
  std::uint64_t openSolved() {
    const std::uint64_t session = open();
    EXPECT_EQ(bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);
    return session;
  }

  v1::Edit editOf(std::uint64_t session, const v1::EditBody& body, v1::ClientId client = kMe) {
    v1::Edit edit;
    edit.client(client);
    edit.edit_id(++last_edit);
    edit.session_id(session);
    edit.body(body);
    return edit;
  }

  v1::EditReply replyTo(const v1::Edit& edit) {
    const auto reply =
        bus.await<v1::EditReply>(bus.edit_replies, [&](const v1::EditReply& one) {
          return one.edit_id() == edit.edit_id();
        });
    EXPECT_TRUE(reply.has_value()) << "no answer to edit " << edit.edit_id();
    return reply.value_or(v1::EditReply());
  }

  v1::EditReply apply(const v1::Edit& edit) {
    bus.send(edit);
    return replyTo(edit);
  }

  v1::EditReply apply(std::uint64_t session, const v1::EditBody& body) {
    return apply(editOf(session, body));
  }

  v1::PoseSolution finalOf(std::uint64_t session, std::uint64_t revision) {
    const auto solution =
        bus.await<v1::PoseSolution>(bus.solutions, [&](const v1::PoseSolution& one) {
          return one.session_id() == session && one.revision() == revision && one.is_final();
        });
    EXPECT_TRUE(solution.has_value()) << "no final solution of revision " << revision;
    return solution.value_or(v1::PoseSolution());
  }

  v1::SessionState stateAt(std::uint64_t session, std::uint64_t revision) {
    const auto state =
        bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& one) {
          return one.session_id() == session && one.revision() == revision;
        });
    EXPECT_TRUE(state.has_value()) << "no state of revision " << revision;
    return state.value_or(v1::SessionState());
  }

  void readyAt(std::uint64_t revision) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.revision() == revision &&
                                                     one.phase() == v1::PHASE_READY;
                                            }))
        << "never ready at revision " << revision;
  }

  v1::SessionSettings settings(std::uint64_t session) {
    const v1::Reply reply = bus.ask(test::ofSession(v1::OP_SESSION_SETTINGS, session));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().settings() : v1::SessionSettings();
  }

  std::uint64_t last_edit = 0;
  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

v1::EditBody weight(double value) {
  v1::PatchWeightEdit edit;
  edit.patch("palm");
  edit.weight(value);
  v1::EditBody body;
  body.patch_weight(edit);
  return body;
}

v1::EditBody limit(double upper_rad) {
  v1::JointLimitEdit edit;
  edit.joint("hinge");
  edit.lower(-0.5);
  edit.upper(upper_rad);
  v1::EditBody body;
  body.joint_limit(edit);
  return body;
}

v1::EditBody steps(v1::EditKind kind, unsigned count = 0) {
  v1::StepsEdit edit;
  edit.count(count);
  v1::EditBody body;
  body.steps(edit);
  body._d(kind);
  return body;
}

v1::EditBody snapshot(v1::EditKind kind, const std::string& name) {
  v1::SnapshotEdit edit;
  edit.name(name);
  v1::EditBody body;
  body.snapshot(edit);
  body._d(kind);
  return body;
}

v1::EditBody drag(const std::string& link, double x_m) {
  v1::DragEdit edit;
  edit.link(link);
  edit.target_W_m({x_m, 0.0, 0.0});
  v1::EditBody body;
  body.drag(edit);
  return body;
}

v1::EditBody swap(v1::EditKind kind, const std::string& name) {
  v1::ModelEdit edit;
  edit.name(name);
  v1::EditBody body;
  body.swapped_model(edit);
  body._d(kind);
  return body;
}

TEST_F(LiveEdits, TellEveryoneWhatWasEditedAndByWhom) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(apply(editOf(session, limit(0.6), kOther)).error(), v1::ERROR_NONE);
  const v1::SessionState state = stateAt(session, 1);
  EXPECT_THAT(state.last_edit(), HasSubstr("hinge"));
  EXPECT_EQ(state.last_client(), kOther);
  EXPECT_EQ(state.redo_count(), 0u);
  EXPECT_GE(state.undo_count(), 1u);
}

TEST_F(LiveEdits, AreReadyOnceTheirSolutionIsOut) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(apply(session, limit(0.6)).error(), v1::ERROR_NONE);
  const auto ready = bus.await<v1::SessionState>(bus.states, [](const v1::SessionState& one) {
    return one.revision() == 1 && one.phase() == v1::PHASE_READY;
  });
  ASSERT_TRUE(ready.has_value());
  const std::vector<v1::PoseSolution> solutions = bus.copyOf(bus.solutions);
  EXPECT_TRUE(solutions.back().is_final());
  EXPECT_TRUE(solutions.back().is_diagnosed()) << "ready: nothing more comes";
  EXPECT_EQ(solutions.back().revision(), 1u);
}

/// The finals of a revision so far, in order.
std::vector<v1::PoseSolution> finalsOf(test::RecordingBus& bus, std::uint64_t revision) {
  std::vector<v1::PoseSolution> finals;
  for (const v1::PoseSolution& one : bus.copyOf(bus.solutions)) {
    if (one.is_final() && one.revision() == revision) finals.push_back(one);
  }
  return finals;
}

TEST_F(LiveEdits, SendThePoseFirstAndItsDiagnosisAfterIt) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(apply(session, limit(-0.4)).error(), v1::ERROR_NONE);
  readyAt(1);
  const std::vector<v1::PoseSolution> finals = finalsOf(bus, 1);
  ASSERT_EQ(finals.size(), 2u);
  v1::PoseSolution pose = finals[0];
  v1::PoseSolution diagnosed = finals[1];
  EXPECT_FALSE(pose.is_diagnosed());
  EXPECT_TRUE(pose.penetration().empty());
  EXPECT_EQ(pose.verdict(), "");
  EXPECT_FALSE(pose.X_WL().empty());
  EXPECT_FALSE(pose.minima().empty());
  EXPECT_TRUE(diagnosed.is_diagnosed());
  EXPECT_EQ(diagnosed.penetration().size(), 1u);
  EXPECT_THAT(diagnosed.verdict(), HasSubstr("patches reached"));
  EXPECT_EQ(diagnosed.sequence_number(), pose.sequence_number() + 1);
  EXPECT_EQ(diagnosed.joint_positions(), pose.joint_positions());
  EXPECT_EQ(diagnosed.X_WH(), pose.X_WH());
  EXPECT_EQ(diagnosed.X_WL(), pose.X_WL());
  EXPECT_EQ(diagnosed.minima(), pose.minima());
  ASSERT_EQ(diagnosed.patches().size(), pose.patches().size());
  for (std::size_t k = 0; k < pose.patches().size(); ++k) {
    EXPECT_EQ(diagnosed.patches()[k].mean_mm(), pose.patches()[k].mean_mm());
    EXPECT_EQ(pose.patches()[k].diagnosis().text(), "");
    EXPECT_NE(diagnosed.patches()[k].diagnosis().text(), "");
  }
}

TEST_F(LiveEdits, CommandEachPoseOnce) {
  const std::uint64_t session = openSolved();
  const std::size_t before = bus.count(bus.commands);
  ASSERT_EQ(before, 1u);
  ASSERT_EQ(apply(session, limit(-0.4)).error(), v1::ERROR_NONE);
  readyAt(1);
  EXPECT_EQ(bus.count(bus.commands), before + 1);
}

TEST_F(LiveEdits, GetAnDiagnosedReplyFromSolves) {
  const std::uint64_t session = open();
  const v1::Reply reply = bus.ask(test::optimize(session));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  EXPECT_TRUE(reply.body().solution().is_diagnosed());
  ASSERT_EQ(apply(session, limit(-0.4)).error(), v1::ERROR_NONE);
  readyAt(1);
  ASSERT_EQ(apply(session, steps(v1::EDIT_UNDO)).error(), v1::ERROR_NONE);
  readyAt(2);
  ASSERT_FALSE(finalsOf(bus, 2).empty());
  EXPECT_TRUE(finalsOf(bus, 2).back().is_diagnosed()) << "of what stands after an undo";
}

TEST_F(LiveEdits, ThatAreRefusedLeaveTheLastPoseDiagnosedAndReady) {
  const std::uint64_t session = openSolved();
  // Refused ones among others, so that some of them cut solves and diagnoses short.
  std::uint64_t revision = 0;
  for (int i = 0; i < 30; ++i) {
    revision = apply(session, limit(i % 2 == 0 ? -0.4 : 0.6)).revision();
    v1::EditBody wrong = limit(0.1);
    wrong.joint_limit().joint("no_such_joint");
    EXPECT_EQ(apply(session, wrong).error(), v1::ERROR_INVALID_INPUT);
  }
  readyAt(revision);
  const auto diagnosed =
      bus.await<v1::PoseSolution>(bus.solutions, [&](const v1::PoseSolution& one) {
        return one.revision() == revision && one.is_diagnosed();
      });
  EXPECT_TRUE(diagnosed.has_value());
  EXPECT_EQ(settings(session).state().phase(), v1::PHASE_READY);
}

TEST_F(LiveEdits, ThatAreRefusedDoNotEndALongSolve) {
  const std::uint64_t session = openSolved();
  constexpr std::uint64_t kSolve = 77;
  bus.send(kSolve, test::optimize(session, v1::SOLVER_ALL, 1000));
  for (int i = 0; i < 3; ++i) {
    v1::EditBody wrong = limit(0.1);
    wrong.joint_limit().joint("no_such_joint");
    EXPECT_EQ(apply(session, wrong).error(), v1::ERROR_INVALID_INPUT);
  }
  const auto solve = bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == kSolve;
  });
  ASSERT_TRUE(solve.has_value());
  EXPECT_EQ(solve->error(), v1::ERROR_NONE) << solve->message();
  EXPECT_EQ(bus.count(bus.replies), bus.countDistinctReplies()) << "answered once";
}

// === Stopping

TEST_F(LiveEdits, AreKeptWhenTheirSolveIsStopped) {
  const std::uint64_t session = openSolved();
  // A solve so long that it is stopped, not done.
  v1::SolveOptions slow;
  slow.solver(v1::SOLVER_ALL);
  slow.starts(10'000);
  v1::EditBody body;
  body.solving(slow);
  ASSERT_EQ(apply(session, body).revision(), 1u);
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [](const v1::SessionState& one) {
    return one.revision() == 1 && one.phase() == v1::PHASE_OPTIMIZING && one.progress() > 0.0;
  }));
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session), 9).error(), v1::ERROR_NONE);
  const auto stopped = bus.await<v1::SessionState>(bus.states, [](const v1::SessionState& one) {
    return one.message() == "stopped";
  });
  ASSERT_TRUE(stopped.has_value());
  EXPECT_EQ(stopped->phase(), v1::PHASE_READY) << "as before the solve";
  EXPECT_EQ(stopped->revision(), 1u);
  // Nothing begins again by itself: the next thing on the strand finds the session at rest.
  EXPECT_EQ(settings(session).state().message(), "stopped");
  EXPECT_TRUE(finalsOf(bus, 1).empty());
}

TEST_F(LiveEdits, ThatWaitAreNotSolvedOnceSomebodySaidStop) {
  const std::uint64_t session = openSolved();
  constexpr std::uint64_t kSolve = 77;
  constexpr std::uint64_t kSecond = 78;
  bus.send(kSolve, test::optimize(session, v1::SOLVER_ALL, 10'000));
  bus.send(kSecond, test::optimize(session, v1::SOLVER_ALL, 10'000));
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [](const v1::SessionState& one) {
    return one.phase() == v1::PHASE_OPTIMIZING && one.progress() > 0.0;
  }));
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session), 9).error(), v1::ERROR_NONE);
  for (const std::uint64_t id : {kSolve, kSecond}) {
    const auto reply = bus.await<v1::Reply>(bus.replies, [&](const v1::Reply& one) {
      return one.request_id() == id;
    });
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(reply->error(), v1::ERROR_CANCELLED);
    EXPECT_THAT(reply->message(), HasSubstr("stopped by client 09000000"));
  }
  EXPECT_EQ(settings(session).state().phase(), v1::PHASE_READY);
  // What is asked for afterwards is solved.
  EXPECT_EQ(bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);
  EXPECT_EQ(apply(session, limit(0.6)).revision(), 1u);
  EXPECT_EQ(finalOf(session, 1).revision(), 1u);
}

TEST_F(LiveEdits, CanBeStoppedWhereNothingRuns) {
  const std::uint64_t session = openSolved();
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session)).error(), v1::ERROR_NONE);
  EXPECT_EQ(settings(session).state().phase(), v1::PHASE_READY);
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session + 1)).error(),
            v1::ERROR_NOT_FOUND);
}

TEST_F(LiveEdits, AreUndoneAndRedoneToTheSamePose) {
  const std::uint64_t session = openSolved();
  const v1::PoseSolution before = finalOf(session, 0);
  ASSERT_EQ(apply(session, limit(-0.4)).revision(), 1u);
  const v1::PoseSolution limited = finalOf(session, 1);
  EXPECT_LE(limited.joint_positions()[0], -0.4 + 1e-12);
  ASSERT_EQ(apply(session, steps(v1::EDIT_UNDO)).revision(), 2u);
  EXPECT_EQ(finalOf(session, 2).joint_positions(), before.joint_positions());
  EXPECT_EQ(finalOf(session, 2).X_WH(), before.X_WH());
  ASSERT_EQ(apply(session, steps(v1::EDIT_REDO)).revision(), 3u);
  EXPECT_EQ(finalOf(session, 3).joint_positions(), limited.joint_positions());
  const v1::EditReply beyond = apply(session, steps(v1::EDIT_REDO));
  EXPECT_EQ(beyond.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(beyond.revision(), 3u);
}

TEST_F(LiveEdits, MadeOnAnOldRevisionAreToldWhatHappenedSince) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(apply(editOf(session, limit(0.6), kOther)).error(), v1::ERROR_NONE);
  ASSERT_EQ(apply(editOf(session, weight(2.0), kMe)).error(), v1::ERROR_NONE);
  v1::Edit stale = editOf(session, weight(3.0), kMe);
  stale.base_revision(1);
  const v1::EditReply reply = apply(stale);
  EXPECT_EQ(reply.error(), v1::ERROR_CONFLICT);
  EXPECT_EQ(reply.revision(), 2u);
  EXPECT_THAT(reply.message(), HasSubstr("revision 2: 'weight palm 2' by you"));
  EXPECT_THAT(reply.message(), testing::Not(HasSubstr("hinge"))) << "that one was known";
  v1::Edit fresh = editOf(session, weight(3.0), kMe);
  fresh.base_revision(2);
  EXPECT_EQ(apply(fresh).revision(), 3u);
}

TEST_F(LiveEdits, CutALongSolveShort) {
  const std::uint64_t session = openSolved();
  constexpr std::uint64_t kSolve = 77;
  bus.send(kSolve, test::optimize(session, v1::SOLVER_ALL, 10'000));
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [](const v1::SessionState& one) {
    return one.phase() == v1::PHASE_OPTIMIZING && one.progress() > 0.0;
  }));
  EXPECT_EQ(apply(session, limit(0.6)).revision(), 1u);
  const auto solve = bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == kSolve;
  });
  ASSERT_TRUE(solve.has_value());
  EXPECT_EQ(solve->error(), v1::ERROR_CANCELLED);
  EXPECT_THAT(solve->message(), HasSubstr("an edit came"));
  EXPECT_EQ(finalOf(session, 1).revision(), 1u);
}

TEST_F(LiveEdits, AreKeptBackUnderAFloodAndTheLastOneIsSolved) {
  const std::uint64_t session = openSolved();
  constexpr int kFlood = 3000;
  std::vector<v1::Edit> sent;
  for (int i = 0; i < kFlood; ++i) {
    sent.push_back(editOf(session, weight(1.0 + 1e-4 * i)));
    bus.send(sent.back());
  }
  std::uint64_t revision = 0;
  int applied = 0;
  for (const v1::Edit& edit : sent) {
    const v1::EditReply reply = replyTo(edit);
    if (reply.error() == v1::ERROR_NONE) {
      ++applied;
      EXPECT_EQ(reply.revision(), revision + 1) << "in order, one by one";
      revision = reply.revision();
    } else {
      EXPECT_EQ(reply.error(), v1::ERROR_OVERLOADED) << reply.message();
    }
  }
  EXPECT_GT(applied, 0);
  finalOf(session, revision);
  const v1::SessionSettings settled = settings(session);
  EXPECT_EQ(settled.state().revision(), revision);
}

TEST_F(LiveEdits, ShowInTheSettings) {
  const std::uint64_t session = openSolved();
  apply(session, weight(2.5));
  apply(session, limit(0.6));
  v1::PatchEnabledEdit off;
  off.patch("index");
  off.enabled(false);
  v1::EditBody body;
  body.patch_enabled(off);
  ASSERT_EQ(apply(session, body).error(), v1::ERROR_NONE);
  apply(session, snapshot(v1::EDIT_SNAPSHOT, "mine"));
  const v1::SessionSettings now = settings(session);
  EXPECT_EQ(now.state().revision(), 4u);
  ASSERT_EQ(now.joints().size(), 1u);
  EXPECT_EQ(now.joints()[0].name(), "hinge");
  EXPECT_EQ(now.joints()[0].upper(), 0.6);
  EXPECT_EQ(now.joints()[0].model_upper(), 1.2);
  EXPECT_THAT(now.snapshots(), testing::ElementsAre("mine"));
  EXPECT_THAT(now.undo().front(), HasSubstr("index"));
  EXPECT_EQ(now.patches().size(), 6u);
  for (const v1::PatchState& patch : now.patches()) {
    EXPECT_EQ(patch.placed(), patch.name() == "palm" || patch.name() == "index");
    EXPECT_EQ(patch.enabled(), patch.name() != "index");
    if (patch.name() == "palm") {
      EXPECT_EQ(patch.weight(), 2.5);
    }
    if (!patch.placed()) {
      EXPECT_NE(patch.reason(), "");
    }
  }
}

TEST_F(LiveEdits, AreComparedWithASnapshot) {
  const std::uint64_t session = openSolved();
  apply(session, snapshot(v1::EDIT_SNAPSHOT, "before"));
  apply(session, limit(-0.4));
  finalOf(session, 2);
  v1::CompareRequest request;
  request.session_id(session);
  request.a("before");
  v1::RequestBody body;
  body.compare(request);
  const v1::Reply reply = bus.ask(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  bool tells_the_joint = false;
  for (const v1::Difference& one : reply.body().compare().differences())
    tells_the_joint = tells_the_joint || one.what().find("hinge") != std::string::npos;
  EXPECT_TRUE(tells_the_joint);
  body.compare().b("nobody's");
  EXPECT_THAT(bus.ask(body).message(), HasSubstr("nobody's"));
}

v1::RequestBody linkPosesOf(std::uint64_t session,
                            const v1::Pose& X_WH,
                            std::vector<double> q) {
  v1::LinkPosesRequest request;
  request.session_id(session);
  request.X_WH(X_WH);
  request.joint_positions(std::move(q));
  v1::RequestBody body;
  body.link_poses(request);
  return body;
}

/// The largest difference of any coordinate: quaternions come normalised anew.
double differenceOf(const v1::Pose& a, const v1::Pose& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    most = std::max(most, std::abs(a.p_m()[i] - b.p_m()[i]));
  for (std::size_t i = 0; i < 4; ++i)
    most = std::max(most, std::abs(a.q_wxyz()[i] - b.q_wxyz()[i]));
  return most;
}

TEST_F(LiveEdits, SayWhereTheLinksAreForAnyJoints) {
  const std::uint64_t session = openSolved();
  const v1::PoseSolution solution = finalOf(session, 0);
  const v1::Reply same =
      bus.ask(linkPosesOf(session, solution.X_WH(), solution.joint_positions()));
  ASSERT_EQ(same.error(), v1::ERROR_NONE) << same.message();
  ASSERT_EQ(same.body().link_poses().X_WL().size(), solution.X_WL().size());
  for (std::size_t link = 0; link < solution.X_WL().size(); ++link)
    EXPECT_LT(differenceOf(same.body().link_poses().X_WL()[link], solution.X_WL()[link]),
              1e-12);

  // The hinge turns the jaw and leaves the palm; the session is as it was.
  std::vector<double> bent = solution.joint_positions();
  bent[0] += 0.1;
  const v1::Reply other = bus.ask(linkPosesOf(session, solution.X_WH(), bent));
  ASSERT_EQ(other.error(), v1::ERROR_NONE) << other.message();
  const auto& X_WL = other.body().link_poses().X_WL();
  ASSERT_EQ(X_WL.size(), 2u);
  EXPECT_LT(differenceOf(X_WL[0], solution.X_WL()[0]), 1e-12);
  EXPECT_GT(differenceOf(X_WL[1], solution.X_WL()[1]), 0.01);
  EXPECT_EQ(settings(session).state().revision(), 0u);
}

TEST_F(LiveEdits, SayWhatIsWrongWithJointsWhoseLinksAreAskedFor) {
  const std::uint64_t session = openSolved();
  const v1::Pose X_WH = finalOf(session, 0).X_WH();
  const auto messageOf = [&](const v1::RequestBody& body) {
    const v1::Reply reply = bus.ask(body);
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reply.message();
    return reply.message();
  };
  EXPECT_THAT(messageOf(linkPosesOf(session, X_WH, {})),
              HasSubstr("joint_positions: 0 of them; hand 'clamp' has 1 joints"));
  EXPECT_THAT(messageOf(linkPosesOf(session, X_WH, {0.1, 0.2})), HasSubstr("2 of them"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(messageOf(linkPosesOf(session, X_WH, {nan})), HasSubstr("joint_positions"));
  v1::Pose flat = X_WH;
  flat.q_wxyz({0.0, 0.0, 0.0, 0.0});
  EXPECT_THAT(messageOf(linkPosesOf(session, flat, {0.1})), HasSubstr("X_WH"));
  EXPECT_EQ(bus.ask(linkPosesOf(session + 1, X_WH, {0.1})).error(), v1::ERROR_NOT_FOUND);
}

TEST_F(LiveEdits, ThatAreWrongNameWhatIsAndChangeNothing) {
  const std::uint64_t session = openSolved();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  v1::EditBody joint = limit(0.6);
  joint.joint_limit().joint("no_such_joint");
  v1::EditBody turned = drag("jaw", 0.1);
  turned.drag().target_q_wxyz({1.0, 0.0});
  v1::EditBody kind;
  kind._d() = static_cast<v1::EditKind>(99);
  const std::vector<std::pair<v1::EditBody, std::string>> wrong = {
      {weight(nan), "nan"},
      {weight(-1.0), "-1"},
      {limit(nan), "nan"},
      {joint, "no_such_joint"},
      {drag("jaw", nan), "nan"},
      {drag("no_such_link", 0.1), "no_such_link"},
      {turned, "2 numbers"},
      {steps(v1::EDIT_UNDO, 4'000'000'000U), "4000000000"},
      {snapshot(v1::EDIT_RESTORE, "nobody's"), "nobody's"},
      {swap(v1::EDIT_HAND, "no_such_hand"), "no_such_hand"},
      {swap(v1::EDIT_OBJECT, "no_such_object"), "no_such_object"},
      {kind, "99"}};
  for (const auto& [body, told] : wrong) {
    const v1::EditReply reply = apply(session, body);
    EXPECT_NE(reply.error(), v1::ERROR_NONE) << told;
    EXPECT_NE(reply.error(), v1::ERROR_INTERNAL) << reply.message();
    EXPECT_THAT(reply.message(), HasSubstr(told));
    EXPECT_EQ(reply.revision(), 0u) << told;
  }
  EXPECT_EQ(apply(session, weight(2.0)).revision(), 1u);
}

TEST_F(LiveEdits, DragToWhereNoHandReachesSaysHowMuchIsMissing) {
  const std::uint64_t session = openSolved();
  const v1::EditReply reply = apply(session, drag("jaw", 1e3));
  // Far away the whole hand may follow; what counts is a clear answer and a server that lives.
  if (reply.error() == v1::ERROR_NONE) {
    finalOf(session, reply.revision());
  } else {
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reply.message();
  }
  EXPECT_EQ(apply(session, weight(2.0)).error(), v1::ERROR_NONE);
}

TEST_F(LiveEdits, ExportWhatTheyCameTo) {
  const std::uint64_t session = open();
  const auto exported = [&](v1::ExportFormat format) {
    v1::ExportRequest request;
    request.session_id(session);
    request.format(format);
    v1::RequestBody body;
    body.export_file(request);
    return bus.ask(body);
  };
  const auto text = [&](v1::ExportFormat format) {
    const v1::Reply reply = exported(format);
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    if (reply.error() != v1::ERROR_NONE) return std::string();
    const auto& content = reply.body().exported_file().content();
    return std::string(content.begin(), content.end());
  };
  EXPECT_THAT(exported(v1::EXPORT_CSV).message(), HasSubstr("solve it first"));
  bus.ask(test::optimize(session));
  apply(session, limit(-0.45));
  EXPECT_THAT(text(v1::EXPORT_CSV), StartsWith("name,value,unit\nhinge,"));
  EXPECT_LE(
      std::stod(text(v1::EXPORT_CSV).substr(std::string("name,value,unit\nhinge,").size())),
      -0.45)
      << "not the pose that answers the edit";
  EXPECT_THAT(text(v1::EXPORT_JSON), HasSubstr("\"handgraft-grasp/1\""));
  EXPECT_THAT(text(v1::EXPORT_JSON), HasSubstr("\"palm\""));
  EXPECT_THAT(text(v1::EXPORT_OBJ), HasSubstr("g jaw\n"));
  EXPECT_THAT(text(v1::EXPORT_GLB), StartsWith("glTF"));
  EXPECT_THAT(text(v1::EXPORT_ISAAC_GRASP), StartsWith("format: isaac_grasp\n"));
  EXPECT_THAT(exported(static_cast<v1::ExportFormat>(99)).message(), HasSubstr("isaac_grasp"));
}

v1::RequestBody loadSession(const std::string& text) {
  v1::LoadSessionRequest request;
  request.text(text);
  v1::RequestBody body;
  body.load_session(request);
  return body;
}

TEST_F(LiveEdits, AreSavedLoadedAndReplayed) {
  const std::uint64_t session = openSolved();
  apply(session, limit(0.6));
  finalOf(session, 1);
  apply(session, weight(2.5));
  const v1::PoseSolution last = finalOf(session, 2);
  apply(session, steps(v1::EDIT_UNDO));
  finalOf(session, 3);
  apply(session, steps(v1::EDIT_REDO));
  finalOf(session, 4);
  const v1::Reply saved = bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session));
  ASSERT_EQ(saved.error(), v1::ERROR_NONE) << saved.message();
  const std::string text = saved.body().saved_session().text();

  const v1::Reply loaded = bus.ask(loadSession(text));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  const std::uint64_t twin = loaded.body().session().session_id();
  EXPECT_NE(twin, session);
  EXPECT_EQ(settings(twin).joints(), settings(session).joints());
  EXPECT_EQ(settings(twin).undo(), settings(session).undo());
  EXPECT_EQ(finalOf(twin, 4).joint_positions(), last.joint_positions())
      << "watchers see the saved pose";
  EXPECT_EQ(apply(twin, steps(v1::EDIT_UNDO)).revision(), 5u);

  v1::ReplayRequest request;
  request.text(text);
  v1::RequestBody body;
  body.replay(request);
  const v1::Reply replayed = bus.ask(body);
  ASSERT_EQ(replayed.error(), v1::ERROR_NONE) << replayed.message();
  EXPECT_TRUE(replayed.body().replay().same()) << replayed.body().replay().message();
  EXPECT_GE(replayed.body().replay().entries(), 4u);
  EXPECT_EQ(replayed.body().replay().result().text(), text);
}

/// A variant of `clamp`, called "stiff".
v1::RequestBody stiffClamp() {
  v1::VariantRequest variant;
  variant.hand("clamp");
  variant.name("stiff");
  v1::RequestBody made;
  made.variant(variant);
  made._d(v1::OP_MAKE_VARIANT);
  return made;
}

/// Another server, with nothing but what is built in.
struct FreshServer {
  FreshServer() : service(bus, models, {}) { service.start(); }

  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

TEST_F(LiveEdits, OpenOnAServerThatHasNoneOfTheirModels) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(bus.ask(stiffClamp()).error(), v1::ERROR_NONE);
  v1::ModelEdit hand;
  hand.name("stiff");
  v1::EditBody swap;
  swap.swapped_model(hand);
  swap._d(v1::EDIT_HAND);
  ASSERT_EQ(apply(session, swap).error(), v1::ERROR_NONE);
  const v1::PoseSolution last = finalOf(session, 1);
  const std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();

  FreshServer other;
  const v1::Reply loaded = other.bus.ask(loadSession(text));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_EQ(loaded.body().session().hand(), "stiff");
  const std::uint64_t twin = loaded.body().session().session_id();
  const auto pose =
      other.bus.await<v1::PoseSolution>(other.bus.solutions, [&](const v1::PoseSolution& one) {
        return one.session_id() == twin && one.is_final();
      });
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->joint_positions(), last.joint_positions());
  EXPECT_NO_THROW((void)other.models.hand("clamp")) << "what the variant rests on";

  // From there it goes on to a third one.
  const std::string again =
      other.bus.ask(test::ofSession(v1::OP_SAVE_SESSION, twin)).body().saved_session().text();
  FreshServer third;
  EXPECT_EQ(third.bus.ask(loadSession(again)).error(), v1::ERROR_NONE);
}

/// Likewise, but it keeps what it has.
struct KeepingServer {
  KeepingServer() : service(bus, models, options()) {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  ServiceOptions options() {
    ServiceOptions made;
    made.state = &state;
    return made;
  }

  StateStore state{":memory:"};
  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

TEST(SavedSessions, HoldTheirOwnModelsThoughAnotherHasTheName) {
  KeepingServer server;
  ASSERT_EQ(server.bus.ask(stiffClamp()).error(), v1::ERROR_NONE);
  const v1::Reply opened = server.bus.ask(test::openSession("stiff", "fruit", "marks"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const std::uint64_t session = opened.body().session().session_id();
  ASSERT_EQ(server.bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);

  // Both names go to hands that are longer.
  for (const char* name : {"stiff", "clamp"})
    ASSERT_EQ(server.bus.ask(test::unloadModel(v1::MODEL_HAND, name)).error(), v1::ERROR_NONE);
  std::string urdf = test::kClampUrdf;
  urdf.replace(urdf.find("0.035"), 5, "0.070");
  for (const auto& body :
       {test::putFile(4, "clamp.urdf", urdf), test::putFile(4, "sites.yaml", test::kClampSites),
        test::loadModel(4, v1::MODEL_HAND, "clamp", "clamp.urdf")})
    ASSERT_EQ(server.bus.ask(body).error(), v1::ERROR_NONE);
  ASSERT_EQ(server.bus.ask(stiffClamp()).error(), v1::ERROR_NONE);

  const std::string text = server.bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session))
                               .body()
                               .saved_session()
                               .text();
  FreshServer other;
  const v1::Reply loaded = other.bus.ask(loadSession(text));
  EXPECT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
}

TEST_F(LiveEdits, NameAllModelsThatAreLacking) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  const std::size_t held = text.find(",\"held\":[");
  ASSERT_NE(held, std::string::npos);
  text.erase(held, text.find(']', held) + 1 - held);
  FreshServer other;
  const v1::Reply reply = other.bus.ask(loadSession(text));
  EXPECT_EQ(reply.error(), v1::ERROR_NOT_FOUND);
  EXPECT_THAT(reply.message(), HasSubstr("contacts marks, hand clamp, object fruit"));
}

TEST_F(LiveEdits, OfADamagedModelAreRefusedByName) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  const std::size_t bytes = text.find("\"bytes\":\"", text.find("\"name\":\"clamp\""));
  ASSERT_NE(bytes, std::string::npos);
  for (const auto& [damage, told] : {std::pair{"****", "base64"}, {"AAAA", "clamp"}}) {
    std::string damaged = text;
    damaged.replace(bytes + 9, 4, damage);
    FreshServer other;
    const v1::Reply reply = other.bus.ask(loadSession(damaged));
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reply.message();
    EXPECT_THAT(reply.message(), HasSubstr(told));
  }
}

TEST_F(LiveEdits, OfADamagedFileAreRefusedByName) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  EXPECT_EQ(bus.ask(loadSession("not a session")).error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(bus.ask(loadSession(text.substr(0, text.size() / 2))).error(),
            v1::ERROR_INVALID_INPUT);
  const std::size_t hand = text.find("\"clamp\"");
  ASSERT_NE(hand, std::string::npos);
  text.replace(hand, 7, "\"cramp\"");
  const v1::Reply reply = bus.ask(loadSession(text));
  EXPECT_NE(reply.error(), v1::ERROR_NONE);
  EXPECT_NE(reply.error(), v1::ERROR_INTERNAL) << reply.message();
}

// === What an edit's diagnosis waits for: one worker, which idle tasks never go to first

class BusyServer : public LiveEdits {
 protected:
  static ServiceOptions busy() {
    ServiceOptions options;
    options.workers = 1;
    options.patience = std::chrono::hours(1);
    return options;
  }

  BusyServer() : LiveEdits(busy()) {}

  /// Queues a solve that ends when somebody stops it.
  void occupy(std::uint64_t session) {
    bus.send(5000 + session, test::optimize(session, v1::SOLVER_ALL, 10'000));
  }

  void awaitOccupied(std::uint64_t session) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.session_id() == session &&
                                                     one.phase() == v1::PHASE_OPTIMIZING &&
                                                     one.progress() > 0.0;
                                            }))
        << "session " << session << " does not solve";
  }

  void stop(std::uint64_t session) {
    EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session)).error(), v1::ERROR_NONE);
  }

  void awaitReady(std::uint64_t session, std::uint64_t revision) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.session_id() == session &&
                                                     one.revision() == revision &&
                                                     one.phase() == v1::PHASE_READY;
                                            }))
        << "session " << session << " is never ready at revision " << revision;
  }

  /// Edits `session` and lets the pose out; its diagnosis waits until `holder` is stopped.
  void holdDiagnosis(std::uint64_t session, std::uint64_t holder) {
    const std::uint64_t first = open();
    const std::uint64_t second = open();
    occupy(first);
    awaitOccupied(first);
    const v1::Edit edit = editOf(session, limit(-0.4));
    bus.send(edit);
    occupy(second);
    stop(first);
    EXPECT_EQ(replyTo(edit).revision(), 1u);
    awaitOccupied(second);
    occupy(holder);  // behind the solve
    stop(second);
    finalOf(session, 1);
    awaitOccupied(holder);
    EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
  }
};

TEST_F(BusyServer, DiagnosesPosesAfterWhatOtherSessionsHaveToDo) {
  const std::uint64_t mine = openSolved();
  const std::uint64_t yours = openSolved();
  const std::uint64_t holder = open();
  occupy(holder);
  awaitOccupied(holder);
  bus.send(editOf(mine, limit(-0.4)));
  bus.send(editOf(yours, limit(-0.4)));
  stop(holder);
  awaitReady(mine, 1);
  awaitReady(yours, 1);
  std::vector<std::pair<std::uint64_t, bool>> order;
  for (const v1::PoseSolution& one : finalsOf(bus, 1))
    order.emplace_back(one.session_id(), one.is_diagnosed());
  EXPECT_THAT(order, testing::ElementsAre(std::pair(mine, false), std::pair(yours, false),
                                          std::pair(mine, true), std::pair(yours, true)));
}

TEST_F(BusyServer, StopsDiagnosesThatWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  stop(session);
  stop(holder);
  awaitReady(session, 1);
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u) << "diagnosed, although somebody said stop";
  EXPECT_EQ(apply(session, limit(0.6)).revision(), 2u);
  awaitReady(session, 2);
  EXPECT_EQ(finalsOf(bus, 2).size(), 2u);
}

TEST_F(BusyServer, DoesNotDiagnosePosesThatAnEditOutdates) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  bus.send(editOf(session, limit(0.6)));
  stop(holder);
  awaitReady(session, 2);
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
  ASSERT_EQ(finalsOf(bus, 2).size(), 2u);
  EXPECT_TRUE(finalsOf(bus, 2).back().is_diagnosed());
}

TEST_F(BusyServer, DiagnosesPosesThatARefusedEditDoesNotOutdate) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  const std::size_t commands = bus.count(bus.commands);
  v1::EditBody wrong = limit(0.1);
  wrong.joint_limit().joint("no_such_joint");
  const v1::Edit edit = editOf(session, wrong);
  bus.send(edit);
  stop(holder);
  EXPECT_EQ(replyTo(edit).error(), v1::ERROR_INVALID_INPUT);
  awaitReady(session, 1);
  ASSERT_EQ(finalsOf(bus, 1).size(), 2u);
  EXPECT_TRUE(finalsOf(bus, 1).back().is_diagnosed());
  EXPECT_EQ(bus.count(bus.commands), commands) << "solved again";
}

TEST_F(BusyServer, ClosesSessionsWhoseDiagnosesWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  bus.send(77, test::ofSession(v1::OP_CLOSE_SESSION, session));
  stop(holder);
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& one) {
    return one.session_id() == session && one.phase() == v1::PHASE_CLOSED;
  }));
  service.stop();  // what waits is done
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
}

TEST_F(BusyServer, StopsWhileDiagnosesWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  service.stop();
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
}

class FewSessions : public LiveEdits {
 protected:
  static ServiceOptions few() {
    ServiceOptions options;
    options.most_sessions = 1;
    options.session_idle = std::chrono::seconds(3);
    return options;
  }

  FewSessions() : LiveEdits(few()) {}
};

TEST_F(FewSessions, MoreAreRefusedAndIdleOnesMakeRoom) {
  const std::uint64_t session = open();
  const v1::Reply second = bus.ask(test::openSession("clamp", "fruit", "marks"));
  EXPECT_EQ(second.error(), v1::ERROR_OVERLOADED);
  EXPECT_THAT(second.message(), HasSubstr("1 sessions"));
  const auto closed = bus.await<v1::SessionState>(bus.states, [&](const auto& one) {
    return one.session_id() == session && one.phase() == v1::PHASE_CLOSED;
  });
  ASSERT_TRUE(closed.has_value());
  EXPECT_THAT(closed->message(), HasSubstr("idle"));
  EXPECT_EQ(apply(session, weight(2.0)).error(), v1::ERROR_NOT_FOUND);
  EXPECT_NE(open(), 0u);
}

class FewBytes : public LiveEdits {
 protected:
  static constexpr std::size_t kMost = 1 << 20;

  static ServiceOptions few() {
    ServiceOptions options;
    options.most_bytes = kMost;
    return options;
  }

  FewBytes() : LiveEdits(few()) {}
};

TEST_F(FewBytes, AreTakenAgainOnceTheyAreAnswered) {
  for (int i = 0; i < 5; ++i) {  // together more than may wait at once
    EXPECT_EQ(bus.ask(loadSession(std::string(kMost / 6, ' '))).error(),
              v1::ERROR_INVALID_INPUT);
  }
  // It takes several times its size.
  const v1::Reply refused = bus.ask(loadSession(std::string(kMost / 3, ' ')));
  EXPECT_EQ(refused.error(), v1::ERROR_OVERLOADED);
  EXPECT_THAT(refused.message(), HasSubstr("1048576"));
}

}  // namespace
}  // namespace handgraft::server
