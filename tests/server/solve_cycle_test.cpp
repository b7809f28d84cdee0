// Where a session stands between an edit and its diagnosed pose, on a clock of its own: no
// session, no thread, no time that passes by itself.
#include "server/sessions/solve_cycle.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/handlers/optimize.h"

namespace handgraft::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr v1::ClientId kStopper{0xab, 0x12, 0xcd, 0x34};

class SolveCycleTest : public testing::Test {
 protected:
  /// An edit comes, and is applied. True: a solve is to be put on the strand.
  bool applyEdit() {
    cycle.editQueued();
    cycle.editTaken();
    return cycle.editApplied(cycle.asked());
  }

  /// A solve that takes so long, and looks around itself at its end.
  SolveEnd solve(milliseconds duration, Preemption patience = Preemption::kAnswer) {
    return cycle.run(whole, patience, [&](SolveCycle::Run& run) {
      now += duration;
      run.cancelForEdits();
      run.progress().checkpoint();
    });
  }

  /// As above, and an edit comes as soon as it has begun.
  SolveEnd solveUnderAnEdit(milliseconds duration, Preemption patience = Preemption::kAnswer) {
    const SolveEnd end = cycle.run(whole, patience, [&](SolveCycle::Run& run) {
      cycle.editQueued();
      now += duration;
      run.cancelForEdits();
      run.progress().checkpoint();
    });
    cycle.editTaken();
    return end;
  }

  void poseOut(unsigned long long revision = 1) {
    cycle.poseOut(revision, std::make_shared<UndiagnosedPose>());
  }

  SolveCycle::Clock::time_point now{hours(1)};
  Progress whole;
  SolveCycle cycle{[this] {
    return now;
  }};
};

TEST_F(SolveCycleTest, GoesFromAnEditToADiagnosedPose) {
  EXPECT_EQ(cycle.stage(), SolveStage::kResting);
  EXPECT_TRUE(applyEdit());
  EXPECT_EQ(cycle.stage(), SolveStage::kPending);
  EXPECT_TRUE(cycle.isAwaited());
  cycle.takePending();
  const SolveEnd solved = cycle.run(whole, Preemption::kAnswer, [&](SolveCycle::Run&) {
    EXPECT_EQ(cycle.stage(), SolveStage::kSolving);
    poseOut(1);
  });
  EXPECT_EQ(solved, SolveEnd::kDone);
  EXPECT_EQ(cycle.stage(), SolveStage::kUndiagnosed);
  EXPECT_TRUE(cycle.isSolvedAt(1));
  const SolveEnd diagnosed = cycle.run(whole, Preemption::kNone, [&](SolveCycle::Run&) {
    EXPECT_EQ(cycle.stage(), SolveStage::kDiagnosing);
  });
  EXPECT_EQ(diagnosed, SolveEnd::kDone);
  cycle.forgetUndiagnosed();
  EXPECT_EQ(cycle.stage(), SolveStage::kResting);
  EXPECT_TRUE(cycle.wasSolved());
}

TEST_F(SolveCycleTest, SolvesOnceForAllEditsThatWereApplied) {
  EXPECT_TRUE(applyEdit());
  EXPECT_FALSE(applyEdit());
  cycle.takePending();
  EXPECT_TRUE(applyEdit());
}

TEST_F(SolveCycleTest, OutdatesThePoseThatIsOutByAnEdit) {
  poseOut();
  EXPECT_NE(cycle.undiagnosed(), nullptr);
  static_cast<void>(applyEdit());
  EXPECT_EQ(cycle.undiagnosed(), nullptr);
}

TEST_F(SolveCycleTest, HasItsTimeBeforeAnEditCutsItShort) {
  EXPECT_EQ(solveUnderAnEdit(milliseconds(7)), SolveEnd::kDone);
  EXPECT_EQ(solveUnderAnEdit(milliseconds(8)), SolveEnd::kCutShort);
}

TEST_F(SolveCycleTest, HasTwiceTheTimeAfterEachThatWasCutShort) {
  EXPECT_EQ(solveUnderAnEdit(milliseconds(8)), SolveEnd::kCutShort);
  EXPECT_EQ(solveUnderAnEdit(milliseconds(15)), SolveEnd::kDone);  // and the count is over
  EXPECT_EQ(solveUnderAnEdit(milliseconds(8)), SolveEnd::kCutShort);
  EXPECT_EQ(solveUnderAnEdit(milliseconds(16)), SolveEnd::kCutShort);
  EXPECT_EQ(solveUnderAnEdit(milliseconds(31)), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, HasABoundedTimeWhereTheEditsAreApplied) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(solveUnderAnEdit(hours(1)), SolveEnd::kCutShort);
    static_cast<void>(applyEdit());
    cycle.takePending();
  }
  EXPECT_EQ(solveUnderAnEdit(milliseconds(128)), SolveEnd::kCutShort);
}

TEST_F(SolveCycleTest, HasTimeWithoutBoundWhereTheEditsAreRefused) {
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(solveUnderAnEdit(hours(1)), SolveEnd::kCutShort);
  EXPECT_EQ(solveUnderAnEdit(milliseconds(511)), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, NeverCutsShortWhatNeedsNoSearch) {
  EXPECT_EQ(solveUnderAnEdit(hours(1000), Preemption::kUnhurried), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, CutsADiagnosisShortAtOnceAndLeavesItsPose) {
  poseOut();
  EXPECT_EQ(solveUnderAnEdit(milliseconds(0), Preemption::kNone), SolveEnd::kCutShort);
  EXPECT_EQ(cycle.stage(), SolveStage::kUndiagnosed);
  cycle.editQueued();  // before it begins
  EXPECT_EQ(solve(milliseconds(0), Preemption::kNone), SolveEnd::kCutShort);
}

TEST_F(SolveCycleTest, IsDoneWhereAnEditCameTooLateToCutItShort) {
  const SolveEnd end = cycle.run(whole, Preemption::kAnswer, [&](SolveCycle::Run& run) {
    cycle.editQueued();
    now += hours(1);
    run.cancelForEdits();  // and nobody looked before the answer was there
  });
  EXPECT_EQ(end, SolveEnd::kDone);
}

TEST_F(SolveCycleTest, StopsWhatRunsAndWhatWasAskedForBefore) {
  const SolveCycle::StopEpoch before = cycle.asked();
  cycle.workFor(before);
  const SolveEnd end = cycle.run(whole, Preemption::kUnhurried, [&](SolveCycle::Run& run) {
    cycle.stop(kStopper);
    run.progress().checkpoint();
  });
  EXPECT_EQ(end, SolveEnd::kStopped);
  EXPECT_EQ(cycle.whoStopped(), "stopped by client ab12cd34");
  bool has_run = false;
  EXPECT_EQ(cycle.run(whole, Preemption::kAnswer,
                      [&](SolveCycle::Run&) {
                        has_run = true;
                      }),
            SolveEnd::kStopped);
  EXPECT_FALSE(has_run);
  cycle.workFor(cycle.asked());
  EXPECT_EQ(solve(milliseconds(1)), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, StopsTheSolveOfAnEditButNotThatOfALaterOne) {
  static_cast<void>(applyEdit());
  cycle.stop(kStopper);
  cycle.takePending();
  EXPECT_EQ(solve(milliseconds(1)), SolveEnd::kStopped);
  static_cast<void>(applyEdit());
  cycle.takePending();
  EXPECT_EQ(solve(milliseconds(1)), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, StopsTheDiagnosisOfWhatWasStopped) {
  poseOut();
  cycle.stop(kStopper);
  cycle.workFor(cycle.asked());  // for something else since
  EXPECT_EQ(solve(milliseconds(1), Preemption::kNone), SolveEnd::kStopped);
}

TEST_F(SolveCycleTest, StopsWhatTakesTooLong) {
  EXPECT_EQ(cycle.run(whole, Preemption::kUnhurried,
                      [&](SolveCycle::Run& run) {
                        now += milliseconds(1000);
                        cycle.stopLongerThan(std::chrono::seconds(1));
                        run.progress().checkpoint();  // not longer
                        now += milliseconds(1);
                        cycle.stopLongerThan(std::chrono::seconds(1));
                        run.progress().checkpoint();
                      }),
            SolveEnd::kStopped);
  EXPECT_THAT(cycle.whoStopped(), HasSubstr("its time is over"));
}

TEST_F(SolveCycleTest, PrefersAStopToAnEdit) {
  const SolveEnd end = cycle.run(whole, Preemption::kNone, [&](SolveCycle::Run& run) {
    cycle.editQueued();
    cycle.stop(kStopper);
    run.progress().checkpoint();
  });
  EXPECT_EQ(end, SolveEnd::kStopped);
}

TEST_F(SolveCycleTest, IsCancelledWithTheWholeThatItIsAPartOf) {
  whole.cancel();
  EXPECT_EQ(solve(milliseconds(0)), SolveEnd::kCancelled);
}

TEST_F(SolveCycleTest, LetsErrorsPassAndRunsAgain) {
  EXPECT_THROW(cycle.run(whole, Preemption::kAnswer,
                         [](SolveCycle::Run&) {
                           throw InvalidInput("no way");
                         }),
               InvalidInput);
  EXPECT_EQ(cycle.stage(), SolveStage::kResting);
  EXPECT_EQ(solve(milliseconds(0)), SolveEnd::kDone);
}

TEST_F(SolveCycleTest, IsAwaitedWhileARequestWaitsForWhatBecomesOfAnEdit) {
  EXPECT_FALSE(cycle.isAwaited());
  cycle.requestWaits();
  EXPECT_TRUE(cycle.isAwaited());
  cycle.requestGoesOn();
  EXPECT_FALSE(cycle.isAwaited());
}

TEST_F(SolveCycleTest, PassesReportsOnAndLooksForEditsAtEach) {
  std::string said;
  const Progress listening([&](std::string_view stage, double) {
    said = stage;
  });
  cycle.editQueued();
  const SolveEnd end = cycle.run(listening, Preemption::kAnswer, [&](SolveCycle::Run& run) {
    now += milliseconds(9);
    run.progress().report("searching", 0.5);
    run.progress().checkpoint();
  });
  EXPECT_EQ(end, SolveEnd::kCutShort);
  EXPECT_EQ(said, "searching");
}

}  // namespace
}  // namespace handgraft::server
