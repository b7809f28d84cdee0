// What a session promises of its history, on random edits: what was refused changed nothing,
// undoing everything leads to the first document, redoing everything to the last, and playing
// the log, or a file, to the same bytes.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "core/session/replay.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/lemon_models.h"
#include "tests/core/session/named_models.h"
#include "tests/core/session/random_edits.h"
#include "tests/support/shared_data.h"

namespace handgraft::session {
namespace {

using test::handOf;
using test::lemonModels;
using test::modelPath;
using test::RandomEdits;

constexpr int kEdits = 300;

SessionModels ballModels(bool open) {
  const test::BallGrasp grasp({"thumb", "index", "middle"}, open);
  return test::withOthers(grasp.hand(), grasp.ball, grasp.contacts);
}

/// 300 random edits, with solves between them that are committed, dropped or cancelled.
void editAtRandom(Session& session, unsigned seed) {
  RandomEdits edits(seed);
  SolverSettings quick;
  quick.starts = 2;
  int applied = 0;
  int refused = 0;
  while (applied < kEdits) {
    const Edit edit = edits.next(session);
    const Document before = session.document();
    const unsigned long long revision = session.revision();
    try {
      session.apply(edit);
      EXPECT_EQ(session.revision(), revision + 1);
      ++applied;
    } catch (const InvalidInput&) {
      EXPECT_TRUE(session.document() == before) << describe(edit);
      EXPECT_EQ(session.revision(), revision);
      ++refused;
    }
    try {
      switch (edits.below(8)) {
        case 0:
        case 1:
          session.commit(session.solve(quick, SolveRun(), Progress()));
          break;
        case 2:  // nobody waited for it
          (void)session.solve(quick, SolveRun(), Progress());
          break;
        case 3:
          session.noteCancelledSolve();
          break;
        case 4:
          session.transferPatches(Progress());
          break;
        default:
          break;
      }
    } catch (const InvalidInput&) {
      // All patches are off, or off the hand.
    }
  }
  EXPECT_GT(refused, 10);
}

void expectHistoryHolds(const SessionModels& models, unsigned seed) {
  Session session(models, Pose::Identity(), {});
  session.commit(session.solve(SolverSettings(), SolveRun(), Progress()));
  const Document first = session.document();
  editAtRandom(session, seed);
  const Document last = session.document();
  const std::string text = io::sessionText(session);

  // === The log, by value and by solving again, and the file
  const Replay played = replay(models, session.saved(), false, Progress());
  EXPECT_TRUE(played.same) << played.message;
  EXPECT_EQ(played.entries, session.log().entries().size());
  const Replay solved = replay(models, session.saved(), true, Progress());
  EXPECT_TRUE(solved.same) << solved.message;

  const io::SessionFile file = io::readSessionText(text);
  Session loaded = io::openSession(file, models, Progress());
  EXPECT_TRUE(loaded.document() == last);
  EXPECT_TRUE(io::sessionText(loaded) == text);
  Replay of_file = replay(models, file.session, false, Progress());
  EXPECT_TRUE(of_file.same) << of_file.message;
  EXPECT_TRUE(io::sessionText(of_file.session) == text);

  // === Back to the first document, and forth to the last
  for (Session* each : {&session, &loaded}) {
    const auto steps = static_cast<int>(each->history().undoCount());
    ASSERT_GT(steps, 50);
    each->apply(UndoEdit{steps});
    EXPECT_TRUE(each->document() == first);
    EXPECT_EQ(each->history().undoCount(), 0u);
    each->apply(RedoEdit{steps});
    EXPECT_TRUE(each->document() == last);
  }
  ::testing::Test::RecordProperty("bytes_of_file", static_cast<int>(text.size()));
}

TEST(SessionReplay, OfTheSmallHandGivesTheSameBytes) {
  for (const unsigned seed : {1u, 2u, 3u})
    expectHistoryHolds(ballModels(seed == 2), seed);
}

TEST(SessionReplay, OfAHumanHandOnALemonGivesTheSameBytes) {
  const std::filesystem::path folder = modelPath("hands/human20");
  expectHistoryHolds(lemonModels(handOf(folder / "human20.urdf", folder / "sites.yaml")), 4);
}

TEST(SessionReplay, OfTheRealAllegroGivesTheSameBytes) {
  const std::string urdf = "hands/allegro_right/allegro_hand_right.urdf";
  HANDGRAFT_NEEDS_SHARED_DATA(urdf);
  expectHistoryHolds(lemonModels(handOf(test::sharedData(urdf), "")), 5);
}

TEST(SessionReplay, ForgetsTheOldestEntriesAndStillPlaysTheRest) {
  const SessionModels models = ballModels(false);
  Session session(models, Pose::Identity(), {});
  for (int i = 0; i < 2000; ++i) {
    session.apply(PatchWeightEdit{"thumb", 1.0 + i});
    if (i % 7 == 0) session.apply(UndoEdit{1});
  }
  EXPECT_LE(session.log().entries().size(), kMostEntries);
  EXPECT_GE(session.log().entries().size(), kMostEntries / 2);
  EXPECT_EQ(session.history().undoCount(), kMostSteps);
  const Replay played = replay(models, session.saved(), false, Progress());
  EXPECT_TRUE(played.same) << played.message;
}

TEST(SessionReplay, SaysWhereALogDiffersFromItsFile) {
  const SessionModels models = ballModels(false);
  Session session(models, Pose::Identity(), {});
  session.apply(PatchWeightEdit{"thumb", 2.0});
  session.apply(PatchWeightEdit{"index", 2.0});
  SavedSession tampered = session.saved();
  std::get<PatchWeightEdit>(std::get<Edit>(tampered.log[1])).weight = 3.0;
  const Replay played = replay(models, tampered, false, Progress());
  EXPECT_FALSE(played.same);
  EXPECT_EQ(played.entries, 2u);
  EXPECT_THAT(played.message, ::testing::HasSubstr("the last document differs"));

  std::get<PatchWeightEdit>(std::get<Edit>(tampered.log[1])).patch = "elbow";
  const Replay refused = replay(models, tampered, false, Progress());
  EXPECT_EQ(refused.entries, 1u);
  EXPECT_THAT(refused.message,
              ::testing::HasSubstr("entry 1, weight elbow 3: there is no patch"));
}

TEST(SessionReplay, NoticesASolveThatEndsElsewhere) {
  const SessionModels models = ballModels(false);
  Session session(models, Pose::Identity(), {});
  session.commit(session.solve(SolverSettings(), SolveRun(), Progress()));
  SavedSession tampered = session.saved();
  auto solve = std::make_shared<CommittedSolve>(
      *std::get<std::shared_ptr<const CommittedSolve>>(tampered.log[0]));
  solve->change.start->q[0] += 1e-12;
  tampered.log[0] = std::shared_ptr<const CommittedSolve>(solve);
  EXPECT_THAT(replay(models, tampered, true, Progress()).message,
              ::testing::HasSubstr("entry 0, a solve: it ends elsewhere"));
}

}  // namespace
}  // namespace handgraft::session
