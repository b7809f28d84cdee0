// Undo, redo, snapshots, comparison, and the kinds of edits that came with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/named_models.h"

namespace handgraft::session {
namespace {

using test::BallGrasp;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::ThrowsMessage;

Session opened() {
  const BallGrasp grasp;
  return {test::withOthers(grasp.hand(), grasp.ball, grasp.contacts), Pose::Identity(), {}};
}

void solveAndCommit(Session& session) {
  session.commit(session.solve(session.document().solving, SolveRun(), Progress()));
}

template <class Act>
void expectRefusal(const Act& act, const char* text) {
  EXPECT_THAT(act, ThrowsMessage<InvalidInput>(HasSubstr(text)));
}

// === Documents

TEST(Document, ChangesLeadFromOneToTheOther) {
  Session session = opened();
  std::vector<Document> documents = {session.document()};
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  documents.push_back(session.document());
  session.apply(PatchEnabledEdit{"thumb", false});
  documents.push_back(session.document());
  solveAndCommit(session);
  documents.push_back(session.document());
  session.apply(HandEdit{"found"});
  documents.push_back(session.document());
  for (const Document& a : documents) {
    for (const Document& b : documents)
      EXPECT_TRUE(applyTo(a, changeBetween(a, b)) == b);
  }
  EXPECT_FALSE(documents[0] == documents[1]);
  EXPECT_LT(bytesOf(documents.back()).size(), 10'000u);
}

TEST(Document, IsComparedToTheByte) {
  const Session session = opened();
  Document a = session.document();
  a.patches[0].weight = 0.0;
  Document b = a;
  b.patches[0].weight = -0.0;
  EXPECT_TRUE(a.patches[0].weight == b.patches[0].weight);
  EXPECT_FALSE(a == b);
}

TEST(Document, RefusesAChangeOfAnother) {
  Document small;
  DocumentChange change;
  change.patches.emplace_back(3, DocumentPatch());
  expectRefusal(
      [&] {
        (void)applyTo(small, change);
      },
      "number 3 of the patches: there are 0");
}

// === Undo and redo

TEST(SessionHistory, UndoesAndRedoesEditsWithTheSolvesThatAnsweredThem) {
  Session session = opened();
  const Document first = session.document();
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  solveAndCommit(session);
  const Document limited = session.document();
  session.apply(PatchWeightEdit{"thumb", 3.0});
  solveAndCommit(session);
  const Document weighted = session.document();

  EXPECT_THAT(session.history().undoLabels(20),
              ElementsAre("weight thumb 3", "limit index_1 0 to 0.7 rad"));
  EXPECT_EQ(session.apply(UndoEdit{}).message, "undone: weight thumb 3");
  EXPECT_TRUE(session.document() == limited);
  EXPECT_FALSE(session.needsSolve());
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == first);
  EXPECT_TRUE(session.needsSolve());  // it never was solved
  session.apply(RedoEdit{2});
  EXPECT_TRUE(session.document() == weighted);
  EXPECT_EQ(session.revision(), 5u);  // all of them count
}

TEST(SessionHistory, TheFirstSolveIsNoStep) {
  Session session = opened();
  solveAndCommit(session);
  const Document solved = session.document();
  expectRefusal(
      [&] {
        session.apply(UndoEdit{});
      },
      "nothing to undo");
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  solveAndCommit(session);
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == solved);
}

TEST(SessionHistory, ASolveWhereAnAnswerStandsIsAStepOfItsOwn) {
  Session session = opened();
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  solveAndCommit(session);
  const Document answered = session.document();
  SolverSettings paper = answered.solving;
  paper.paper = true;
  session.commit(session.solve(paper, SolveRun(), Progress()));
  const Document again = session.document();
  ASSERT_FALSE(again == answered);
  EXPECT_THAT(session.history().undoLabels(20),
              ElementsAre("solve", "limit index_1 0 to 0.7 rad"));
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == answered);
  session.apply(RedoEdit{});
  EXPECT_TRUE(session.document() == again);
}

TEST(SessionHistory, ASolveOfALogFromBeforeIsAStepWhereItIsTheFirst) {
  Session session = opened();
  const Document first = session.document();
  CommittedSolve solve;
  solve.change =
      changeBetween(first, session.solve(first.solving, SolveRun(), Progress()).document);
  session.commit(solve);
  EXPECT_THAT(session.history().undoLabels(20), ElementsAre("solve"));
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == first);
}

TEST(SessionHistory, AnEditAfterAnUndoForgetsWhatCouldBeRedone) {
  Session session = opened();
  session.apply(PatchWeightEdit{"thumb", 3.0});
  session.apply(UndoEdit{});
  session.apply(PatchWeightEdit{"index", 3.0});
  expectRefusal(
      [&] {
        session.apply(RedoEdit{});
      },
      "nothing to redo");
}

TEST(SessionHistory, ACommittedSolveAfterAnUndoLeavesTheFutureAsItWas) {
  Session session = opened();
  session.apply(PatchWeightEdit{"thumb", 3.0});  // not solved
  session.apply(PatchWeightEdit{"index", 3.0});
  const Document last = session.document();
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.needsSolve());
  solveAndCommit(session);
  session.apply(RedoEdit{});
  EXPECT_TRUE(session.document() == last);
}

TEST(SessionHistory, RefusesMoreStepsThanThereAre) {
  Session session = opened();
  expectRefusal(
      [&] {
        session.apply(UndoEdit{});
      },
      "nothing to undo");
  session.apply(PatchWeightEdit{"thumb", 3.0});
  expectRefusal(
      [&] {
        session.apply(UndoEdit{2});
      },
      "undo 2: permitted are 1 to 1");
  expectRefusal(
      [&] {
        session.apply(UndoEdit{0});
      },
      "undo 0");
  EXPECT_EQ(session.revision(), 1u);
}

TEST(SessionHistory, BringsBackTheChartsOfTheRootBefore) {
  Session session = opened();
  session.transferPatches(Progress());
  const auto* chart = session.patches()[1].stages.skinChart().get();
  geometry::SurfacePoint root = session.patches()[1].placement->root_S;
  root.barycentric = Eigen::Vector3d::Constant(1.0 / 3.0);
  session.apply(PatchRootEdit{"index", Side::kHand, root});
  session.transferPatches(Progress());
  ASSERT_NE(session.patches()[1].stages.skinChart().get(), chart);
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.patches()[1].up_to_date);
  EXPECT_EQ(session.patches()[1].stages.skinChart().get(), chart);
}

// === Solves

TEST(SessionSolve, ChangesNothingUntilItIsCommitted) {
  Session session = opened();
  const Document before = session.document();
  const Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  EXPECT_TRUE(session.document() == before);
  const Solution again = session.solve(SolverSettings(), SolveRun(), Progress());
  EXPECT_TRUE(solution.document == again.document);
  session.commit(solution);
  EXPECT_TRUE(session.document() == solution.document);
  EXPECT_TRUE(session.document().is_solved);
  EXPECT_EQ(session.revision(), 0u);
}

TEST(SessionSolve, OfAnOlderRevisionIsNotTaken) {
  Session session = opened();
  Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  session.apply(PatchWeightEdit{"thumb", 2.0});
  EXPECT_THROW(session.commit(std::move(solution)), BrokenContract);
}

TEST(SessionSolve, IsTheSameWhateverWasAskedBefore) {
  const BallGrasp grasp({"thumb", "index", "middle"}, true);
  Session fresh = grasp.open();
  Session used = grasp.open();
  used.transferPatches(Progress());
  (void)used.solve(SolverSettings(), SolveRun(), Progress());
  (void)used.suggest("thumb", {}, Progress());
  for (Session* session : {&fresh, &used}) {
    session->apply(ObjectPoseEdit{Pose(Eigen::Translation3d(0.01, 0, 0))});
    session->apply(PatchDirectionEdit{"index", Side::kObject, 0.3});
  }
  EXPECT_TRUE(fresh.document() == used.document());
  EXPECT_TRUE(fresh.solve(SolverSettings(), SolveRun(), Progress()).document ==
              used.solve(SolverSettings(), SolveRun(), Progress()).document);
}

TEST(SessionSolve, StandsAsItWasCommitted) {
  Session session = opened();
  const Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  session.commit(solution);
  const Solution standing = session.standing(Progress());
  EXPECT_EQ(standing.report.pose.q, solution.report.pose.q);
  EXPECT_EQ(standing.report.minima.size(), solution.report.minima.size());
  ASSERT_EQ(standing.report.patches.size(), 3u);
  EXPECT_EQ(standing.report.patches[0].mean_mm, solution.report.patches[0].mean_mm);
  EXPECT_LT(standing.report.terms.prior, 1e-20);  // the prior is the pose
}

TEST(SessionSolve, ThePriorIsRestThenTheOptimumThenThePoseThatWasEdited) {
  Session session = opened();
  const Eigen::VectorXd rest = session.hand().model->restPose();
  EXPECT_EQ(session.document().prior.q, rest);
  (void)session.solve(SolverSettings(), SolveRun(), Progress());
  EXPECT_EQ(session.document().prior.q, rest);
  const Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  session.commit(solution);
  EXPECT_EQ(session.document().prior.q, solution.report.pose.q);
  session.apply(PriorEdit{std::nullopt, {"thumb_1"}, {0.2}});
  EXPECT_EQ(session.document().prior.q[0], 0.2);
  EXPECT_EQ(session.document().prior.q.tail(5), solution.report.pose.q.tail(5));
  session.apply(UndoEdit{});
  EXPECT_EQ(session.document().prior.q, solution.report.pose.q);
}

TEST(SessionSolve, InThePapersWayLeavesRootsWhereTheyAre) {
  const BallGrasp grasp;
  hand::Hand hand = grasp.hand();
  hand.sites_are_found = true;
  Session session(hand, grasp.ball, grasp.contacts, Pose::Identity(), {});
  SolverSettings paper;
  paper.paper = true;
  const Solution solution = session.solve(paper, SolveRun(), Progress());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(solution.document.patches[i].placement->root_S.barycentric,
              session.document().patches[i].placement->root_S.barycentric);
  }
  EXPECT_EQ(solution.report.solver, "mma");
}

// === Edits

TEST(SessionEdit, SwitchesAPatchOffAndKeepsItsWeight) {
  Session session = opened();
  session.apply(PatchWeightEdit{"thumb", 2.5});
  session.apply(PatchEnabledEdit{"thumb", false});
  session.transferPatches(Progress());
  EXPECT_EQ(session.problem().pairs.front().weight, 0.0);
  EXPECT_EQ(session.document().patches[0].weight, 2.5);
  session.apply(PatchEnabledEdit{"thumb", true});
  EXPECT_EQ(session.problem().pairs.front().weight, 2.5);
}

TEST(SessionEdit, HoldsAJointSoftly) {
  Session session = opened();
  session.apply(JointSoftEdit{"middle_1", 0.9, 1e9});
  Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  EXPECT_NEAR(solution.report.pose.q[4], 0.9, 1e-3);
  session.apply(JointLimitEdit{"middle_1", 0.0, 0.5});  // beyond its limit: held at that
  solution = session.solve(SolverSettings(), SolveRun(), Progress());
  EXPECT_NEAR(solution.report.pose.q[4], 0.5, 1e-3);
  expectRefusal(
      [&] {
        session.apply(JointSoftEdit{"middle_1", 0.9, 1.0});
      },
      "is 0.9");
  session.apply(JointSoftEdit{"middle_1", 7.0, 0.0});  // lets go, whatever the value
  EXPECT_EQ(session.document().joints[4].soft_weight, 0.0);
}

TEST(SessionEdit, OfPriorSharesScalesThePrior) {
  Session session = opened();
  session.transferPatches(Progress());
  session.apply(PriorSharesEdit{{2.0, 3.0, 5.0, 0.0}});
  const Eigen::VectorXd weights = session.problem().prior_weights;
  EXPECT_EQ(weights[0], 2.0);
  EXPECT_EQ(weights[3], 3.0);
  EXPECT_EQ(weights[6], 5.0);
  expectRefusal(
      [&] {
        session.apply(PriorSharesEdit{{-1.0, 1.0, 1.0, 0.0}});
      },
      "rotation is -1");
}

TEST(SessionEdit, OfADragMovesTheFingerAndSaysHowShortItIs) {
  Session session = opened();
  solveAndCommit(session);
  const auto tip = static_cast<std::size_t>(session.hand().model->linkIndex("index_tip"));
  const auto place_of = [&] {
    return Eigen::Vector3d(
        forwardKinematics(*session.hand().model, session.document().start)[tip] *
        Eigen::Vector3d(0, 0, 0.02));
  };
  const Eigen::Vector3d target_W = place_of() + Eigen::Vector3d(0.002, 0.0, -0.001);
  const EditResult near =
      session.apply(DragEdit{"index_tip", {0, 0, 0.02}, target_W, std::nullopt});
  EXPECT_LT((place_of() - target_W).norm(), 1e-4);
  EXPECT_THAT(near.message, IsEmpty());
  EXPECT_TRUE(session.needsSolve());
  EXPECT_EQ(session.document().prior.q, session.document().start.q);

  const EditResult far = session.apply(
      DragEdit{"index_tip", {0, 0, 0.02}, target_W + Eigen::Vector3d(1, 0, 0), std::nullopt});
  EXPECT_THAT(far.message, HasSubstr("mm short of its target"));
  expectRefusal(
      [&] {
        session.apply(DragEdit{"elbow", {0, 0, 0}, {0, 0, 0}, std::nullopt});
      },
      "elbow");
}

TEST(SessionEdit, ChoosesAMinimumOfTheLastSolution) {
  Session session = opened();
  expectRefusal(
      [&] {
        session.apply(ChoiceEdit{1, std::nullopt});
      },
      "no solution");
  const Solution solution = session.solve(SolverSettings(), SolveRun(), Progress());
  session.commit(solution);
  ASSERT_GE(solution.report.minima.size(), 2u);
  session.apply(ChoiceEdit{1, std::nullopt});
  EXPECT_EQ(session.document().start.q, solution.report.minima[1].pose.q);
  EXPECT_EQ(session.chosenMinimum(), 1);
  EXPECT_FALSE(session.needsSolve());
  EXPECT_EQ(session.standing(Progress()).report.minima.size(), solution.report.minima.size());
  expectRefusal(
      [&] {
        session.apply(ChoiceEdit{99, std::nullopt});
      },
      "minimum 99");
}

// === Snapshots

TEST(SessionSnapshot, IsRestoredAndThatIsUndone) {
  Session session = opened();
  session.apply(SnapshotEdit{"before"});
  const Document before = session.document();
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  const Document limited = session.document();
  session.apply(RestoreEdit{"before"});
  EXPECT_TRUE(session.document() == before);
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == limited);
  EXPECT_THAT(session.history().snapshotNames(), ElementsAre("before"));
  EXPECT_THAT(session.apply(SnapshotEdit{"before"}).message, HasSubstr("of revision 0"));
  expectRefusal(
      [&] {
        session.apply(RestoreEdit{"after"});
      },
      "'after'; there are before");
  expectRefusal(
      [&] {
        session.apply(SnapshotEdit{"a b"});
      },
      "letters");
  expectRefusal(
      [&] {
        session.apply(SnapshotEdit{""});
      },
      "letters");
}

std::vector<std::string> namesOf(const std::vector<Difference>& differences) {
  std::vector<std::string> names;
  for (const Difference& one : differences)
    names.push_back(one.what);
  return names;
}

TEST(SessionSnapshot, IsComparedWithThePresent) {
  Session session = opened();
  solveAndCommit(session);
  session.apply(SnapshotEdit{"a"});
  EXPECT_THAT(session.compare("a", "", Progress()), IsEmpty());
  session.apply(JointLimitEdit{"index_1", -0.5, 0.1});
  session.apply(PatchWeightEdit{"thumb", 2.0});
  session.apply(ObjectPoseEdit{Pose(Eigen::Translation3d(0, 0.003, 0))});
  solveAndCommit(session);
  const std::vector<Difference> rows = session.compare("a", "", Progress());
  const std::vector<std::string> names = namesOf(rows);
  for (const char* expected : {"objective", "patch thumb mean", "joint index_1 upper",
                               "patch thumb weight", "object place"}) {
    EXPECT_THAT(names, Contains(expected));
  }
  EXPECT_THAT(names, Not(Contains("joint index_1 lower")));
  for (const Difference& row : rows) {
    if (row.what == "joint index_1 upper") {
      EXPECT_NEAR(row.change, 0.1 - 1.5, 1e-12);
    }
    if (row.what == "object place") {
      EXPECT_NEAR(row.change, 3.0, 1e-9);
    }
  }
  // The other way about, changes have the other sign.
  for (const Difference& row : session.compare("", "a", Progress())) {
    if (row.what == "patch thumb weight") {
      EXPECT_EQ(row.change, -1.0);
    }
  }
}

// === Swaps

TEST(SessionSwap, OfTheHandKeepsWhatFits) {
  Session session = opened();
  solveAndCommit(session);
  session.apply(JointLimitEdit{"index_1", 0.0, 0.7});
  session.apply(PatchWeightEdit{"thumb", 2.0});
  const Document before = session.document();
  session.apply(HandEdit{"bent"});
  EXPECT_EQ(session.document().hand, "bent");
  EXPECT_EQ(session.document().joints[2].upper, 0.7);
  EXPECT_EQ(session.document().patches[0].weight, 2.0);
  EXPECT_EQ(session.document().start.q, before.start.q);  // the same joints
  EXPECT_TRUE(session.needsSolve());
  session.apply(UndoEdit{});
  EXPECT_TRUE(session.document() == before);
  expectRefusal(
      [&] {
        session.apply(HandEdit{"none"});
      },
      "no hand 'none'");
}

TEST(SessionSwap, OfTheHandNotesWhatIsDropped) {
  const BallGrasp grasp;
  SessionModels models = test::withOthers(grasp.hand(), grasp.ball, grasp.contacts);
  // A hand without a middle finger, and with tighter joints.
  std::vector<hand::Link> links;
  std::vector<hand::Joint> joints;
  for (const hand::Link& link : grasp.small.model->links())
    if (link.name.rfind("middle", 0) != 0) links.push_back(link);
  for (hand::Joint joint : grasp.small.model->joints()) {
    if (joint.name.rfind("middle", 0) == 0) continue;
    joint.upper = 1.0;
    joints.push_back(joint);
  }
  hand::Hand fewer;
  fewer.model = std::make_shared<const hand::HandModel>("fewer", links, joints);
  fewer.skin = std::make_shared<const hand::Skin>(
      *fewer.model, geometry::makeBox({0.1, 0.06, 0.05}), fewer.model->restPose(), 0.03);
  fewer.sites = {grasp.small.sites[0], grasp.small.sites[1]};
  dynamic_cast<test::NamedModels&>(*models.source).hands["fewer"] = fewer;
  Session session(models, Pose::Identity(), {});
  session.apply(JointLimitEdit{"index_1", 0.0, 1.2});
  session.apply(JointLockEdit{"middle_2", true});
  session.apply(PatchEnabledEdit{"index", false});
  const EditResult result = session.apply(HandEdit{"fewer"});
  EXPECT_THAT(result.message, HasSubstr("limits of 'index_1' were dropped"));
  EXPECT_THAT(result.message, HasSubstr("settings of joint 'middle_2' were dropped"));
  EXPECT_THAT(result.message, HasSubstr("'middle' goes without one"));
  EXPECT_EQ(session.document().joints.size(), 4u);
  EXPECT_FALSE(session.document().patches[1].enabled);
  EXPECT_FALSE(session.document().patches[2].placement.has_value());
  EXPECT_THAT(session.notes(), Contains(HasSubstr("'middle_2'")));
}

TEST(SessionSwap, OfTheObjectCarriesThePatches) {
  Session session = opened();
  solveAndCommit(session);
  const Document before = session.document();
  session.apply(PatchWeightEdit{"thumb", 2.0});
  session.apply(ObjectEdit{"shaved"});
  EXPECT_EQ(session.document().patches.size(), 3u);
  EXPECT_EQ(session.document().patches[0].weight, 2.0);
  solveAndCommit(session);
  session.apply(ObjectEdit{"object"});
  EXPECT_EQ(session.document().patches[0].root_O.face, before.patches[0].root_O.face);
  expectRefusal(
      [&] {
        session.apply(ObjectEdit{"speck"});
      },
      "do not fit the object");
  EXPECT_EQ(session.document().object, "object");
}

}  // namespace
}  // namespace handgraft::session
