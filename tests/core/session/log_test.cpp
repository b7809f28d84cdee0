// What a log keeps as bytes comes back as it was.
#include "core/session/log.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/session/field_bytes.h"

namespace handgraft::session {
namespace {

Pose somePose() {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  X.linear() = rotationFromVector(Eigen::Vector3d(0.4, 0.5, -0.6));
  return X;
}

hand::HandPose someHand() {
  return {somePose(), Eigen::VectorXd::LinSpaced(16, -1.0, 1.0)};
}

/// One of every kind, every field another value than the one it begins with.
std::vector<Edit> everyKind() {
  SolverSettings solving;
  solving.solver = optimize::Solver::kMma;
  solving.starts = 7;
  solving.seed = 4'000'000'000U;
  solving.avoid_penetration = false;
  const double inf = std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d R = somePose().linear();
  return {ObjectPoseEdit{somePose()},
          PatchWeightEdit{"thumb", -0.0},
          PatchRootEdit{"index", Side::kHand, {47'000, {0.25, 0.25, 0.5}}},
          PatchDirectionEdit{"palm", Side::kHand, -1.0 / 3.0},
          JointLimitEdit{"j", -inf, inf},
          JointLockEdit{"k", true},
          PriorEdit{somePose(), {"j", std::string(300, 'k')}, {0.1, 0.2}},
          WeightsEdit{{2e4, 0.5, 1e-300}},
          PatchEnabledEdit{"ring", true},
          JointSoftEdit{"j", 0.5, 10.0},
          PriorSharesEdit{{0.0, 2.0, 3.0, 0.25}},
          SolverSettingsEdit{solving},
          DragEdit{"tip", {0.0, 0.1, 0.2}, {1.0, 2.0, 3.0}, R, 0.5},
          ChoiceEdit{3, someHand()},
          HandEdit{"other"},
          ObjectEdit{std::string("zero \0 in it", 12)},
          UndoEdit{128},
          RedoEdit{16'384},
          SnapshotEdit{"before"},
          RestoreEdit{""},
          ReleaseEdit{"tip"},
          TimedEdit{{1.0, 0.5}, DragPath{"tip", {0.0, 0.1, 0.2}, 0.5, 3, {{1.0, 2.0, 3.0}}}},
          RemoveTimedEdit{2}};
}

std::string bytesOf(const Edit& edit) {
  FieldWriter bytes;
  std::visit(
      [&](const auto& one) {
        bytes.add(one);
      },
      edit);
  return bytes.take();
}

TEST(Log, GivesBackEveryKindOfEdit) {
  const std::vector<Edit> edits = everyKind();
  ASSERT_EQ(edits.size(), std::variant_size_v<Edit>);
  Log log;
  for (const Edit& edit : edits)
    log.add(edit, History(), 0);
  const std::vector<LogEntry> entries = log.entries();
  ASSERT_EQ(entries.size(), edits.size());
  for (std::size_t i = 0; i < edits.size(); ++i) {
    const auto* edit = std::get_if<Edit>(&entries[i]);
    ASSERT_NE(edit, nullptr) << i;
    ASSERT_EQ(edit->index(), i) << "the list above lacks one";
    EXPECT_EQ(describe(*edit), describe(edits[i]));
    EXPECT_EQ(bytesOf(*edit), bytesOf(edits[i])) << describe(edits[i]);
  }
  // Not by the writer alone:
  EXPECT_TRUE(std::signbit(std::get<PatchWeightEdit>(std::get<Edit>(entries[1])).weight));
  const auto& root = std::get<PatchRootEdit>(std::get<Edit>(entries[2]));
  EXPECT_EQ(root.side, Side::kHand);
  EXPECT_EQ(root.root.face, 47'000);
  EXPECT_EQ(root.root.barycentric, Eigen::Vector3d(0.25, 0.25, 0.5));
  const auto& prior = std::get<PriorEdit>(std::get<Edit>(entries[6]));
  EXPECT_EQ(prior.joints.back().size(), 300u);
  EXPECT_EQ(prior.X_WH->matrix(), somePose().matrix());
  EXPECT_EQ(std::get<SolverSettingsEdit>(std::get<Edit>(entries[11])).solving.seed,
            4'000'000'000U);
  EXPECT_EQ(std::get<ChoiceEdit>(std::get<Edit>(entries[13])).pose->q, someHand().q);
  EXPECT_EQ(std::get<ObjectEdit>(std::get<Edit>(entries[15])).name.size(), 12u);
  EXPECT_EQ(std::get<RedoEdit>(std::get<Edit>(entries[17])).count, 16'384);
}

TEST(Log, GivesBackSolvesAndCancellations) {
  CommittedSolve solve;
  solve.objective = 0.1;
  solve.change.start = someHand();
  solve.change.prior_is_start = true;
  solve.change.is_solved = true;
  solve.change.patches.emplace_back(200, DocumentPatch());
  solve.change.patches.back().second.name = "thumb";
  solve.change.notes = {{"a", ""}};
  Log log;
  log.add(std::make_shared<const CommittedSolve>(solve), History(), 0);
  log.add(CancelledSolve(), History(), 0);
  const std::vector<LogEntry> entries = log.entries();
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<CancelledSolve>(entries[1]));
  const CommittedSolve& kept = *std::get<std::shared_ptr<const CommittedSolve>>(entries[0]);
  EXPECT_EQ(kept.objective, 0.1);
  EXPECT_EQ(kept.change.start->q, someHand().q);
  EXPECT_EQ(kept.change.start->X_WH.matrix(), somePose().matrix());
  EXPECT_FALSE(kept.change.prior.has_value());
  EXPECT_TRUE(kept.change.prior_is_start);
  EXPECT_EQ(kept.change.is_solved, true);
  EXPECT_FALSE(kept.change.start_is_known.has_value());
  ASSERT_EQ(kept.change.patches.size(), 1u);
  EXPECT_EQ(kept.change.patches[0].first, 200u);
  EXPECT_EQ(kept.change.patches[0].second.name, "thumb");
  EXPECT_EQ(kept.change.notes, (std::vector<std::string>{"a", ""}));
}

}  // namespace
}  // namespace handgraft::session
