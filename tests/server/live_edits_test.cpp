// Edits as the service runs them: in order, answered, followed by solutions.
#include "tests/server/live_edits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/optimize/diagnosis.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;
using testing::Not;

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
    const v1::PatchDiagnosis& diagnosis = diagnosed.patches()[k].diagnosis();
    EXPECT_NE(diagnosis.text(), "");
    const bool is_reached = diagnosed.patches()[k].mean_mm() <= v1::REACHED_MM &&
                            diagnosis.facing_deg() <= v1::REACHED_FACING_DEG;
    EXPECT_EQ(diagnosis.verdict() == v1::VERDICT_REACHED, is_reached) << diagnosis.text();
  }
}

TEST_F(LiveEdits, SayThatASolveSearchesAnewWhereAPatchIsMissed) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(apply(session, limit(-0.4)).error(), v1::ERROR_NONE);
  readyAt(1);
  const v1::PoseSolution gone_on = finalsOf(bus, 1).back();
  ASSERT_TRUE(std::any_of(gone_on.patches().begin(), gone_on.patches().end(),
                          [](const v1::PatchFit& fit) {
                            return fit.diagnosis().verdict() != v1::VERDICT_REACHED;
                          }));
  EXPECT_THAT(gone_on.verdict(), HasSubstr("'solve' searches anew"));
  const v1::Reply anew = bus.ask(test::optimize(session));
  EXPECT_THAT(anew.body().solution().verdict(), Not(HasSubstr("searches anew")));
}

TEST(Contract, TellsWhatCountsAsReached) {
  EXPECT_EQ(v1::REACHED_MM, optimize::DiagnosisOptions().reached_mm);
  EXPECT_EQ(v1::REACHED_FACING_DEG, optimize::DiagnosisOptions().facing_deg);
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

TEST_F(LiveEdits, ThatSayNothingAreToldWhatIsMissing) {
  EXPECT_THAT(apply(open(), v1::EditBody()).message(),
              HasSubstr("the edit says nothing: an EditBody needs"));
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
  const auto message_of = [&](const v1::RequestBody& body) {
    const v1::Reply reply = bus.ask(body);
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reply.message();
    return reply.message();
  };
  EXPECT_THAT(message_of(linkPosesOf(session, X_WH, {})),
              HasSubstr("joint_positions: 0 of them; hand 'clamp' has 1 joints"));
  EXPECT_THAT(message_of(linkPosesOf(session, X_WH, {0.1, 0.2})), HasSubstr("2 of them"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of(linkPosesOf(session, X_WH, {nan})), HasSubstr("joint_positions"));
  v1::Pose flat = X_WH;
  flat.q_wxyz({0.0, 0.0, 0.0, 0.0});
  EXPECT_THAT(message_of(linkPosesOf(session, flat, {0.1})), HasSubstr("X_WH"));
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

}  // namespace
}  // namespace handgraft::server
