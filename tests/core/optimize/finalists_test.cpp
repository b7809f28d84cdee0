#include "core/optimize/finalists.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class FinalistsTest : public testing::Test {
 protected:
  /// A search that stands `x` metres along an axis with an objective.
  LocalResult at(double x, double objective) const {
    LocalResult result;
    result.pose.X_WH = Pose::Identity();
    result.pose.X_WH.translation().x() = x;
    result.pose.q = model->restPose();
    result.terms.objective = objective;
    return result;
  }

  std::shared_ptr<const hand::HandModel> model = test::syntheticHand();
  Finalists finalists{*model};
};

TEST_F(FinalistsTest, TakesTheBestFirst) {
  const std::vector<LocalResult> results = {at(0.0, 3.0), at(0.1, 1.0), at(0.2, 2.0)};
  EXPECT_THAT(finalists.choose(results, 3, 2), ElementsAre(1, 2));
}

TEST_F(FinalistsTest, TakesOneOfThoseThatLieClose) {
  const std::vector<LocalResult> results = {at(0.0, 1.0), at(0.015, 1.1), at(0.1, 5.0)};
  EXPECT_THAT(finalists.choose(results, 3, 3), ElementsAre(0, 2));
}

TEST_F(FinalistsTest, MeasuresWhereTheExplorationEnded) {
  std::vector<LocalResult> results = {at(0.0, 1.0), at(0.1, 2.0), at(0.2, 3.0)};
  EXPECT_THAT(finalists.choose(results, 2, 1), ElementsAre(0));
  results[0].pose.X_WH.translation().x() = 0.1;  // it went on to there
  EXPECT_THAT(finalists.choose(results, 3, 3), ElementsAre(1, 2));
  EXPECT_THAT(finalists.choose(results, 3, 3), IsEmpty());
}

TEST_F(FinalistsTest, AgreeWhenThreeEndedInTheBestPlace) {
  std::vector<LocalResult> results;
  for (int i = 0; i < 8; ++i)
    results.push_back(at(0.1 * i, i));
  finalists.choose(results, 8, 4);
  for (LocalResult& result : results)
    result.terms.objective = 9.0;
  results[0].terms.objective = 1.0;
  results[1].terms.objective = 1.0005;
  results[2].terms.objective = 1.002;
  results[7].terms.objective = 0.5;  // no finalist
  EXPECT_FALSE(finalists.agree(results));
  results[2].terms.objective = 1.0009;
  EXPECT_TRUE(finalists.agree(results));
}

TEST_F(FinalistsTest, AgreeWhenTheBestPlaceStandsForHalfOfThem) {
  std::vector<LocalResult> results = {at(0.0, 1.0), at(0.001, 1.1), at(0.1, 2.0), at(0.2, 3.0),
                                      at(0.3, 4.0)};
  finalists.choose(results, 5, 8);
  EXPECT_FALSE(finalists.agree(results)) << "two of five";
  Finalists others(*model);
  others.choose(results, 4, 8);
  EXPECT_TRUE(others.agree(results)) << "two of four";
}

TEST_F(FinalistsTest, JointsAndTurnsTellPlacesApart) {
  const hand::HandPose pose = at(0.0, 1.0).pose;
  hand::HandPose other = pose;
  EXPECT_TRUE(liesClose(*model, pose, other));
  other.q[0] += 0.3;
  EXPECT_FALSE(liesClose(*model, pose, other));
  other = pose;
  other.X_WH.linear() = rotationFromVector({0.0, 0.3, 0.0});
  EXPECT_FALSE(liesClose(*model, pose, other));
}

// Only the tip of `b` touches, so that the palm hangs behind `b1` as a forearm behind its
// wrist.
TEST_F(FinalistsTest, BeforeTheWristNothingTellsPlacesApart) {
  PoseProblem problem = makeProblem(model);
  PointPair pair;
  pair.link = model->linkIndex("b_tip");
  problem.pairs.push_back(pair);
  pair.link = model->linkIndex("b_slider");
  problem.pairs.push_back(pair);
  const MomentTree tree = makeMomentTree(problem);
  const hand::HandPose pose = at(0.0, 1.0).pose;

  const Eigen::Vector3d p_HB(-0.03, 0.0, 0.05);  // where b1 turns the finger about z
  hand::HandPose other = pose;
  other.q[model->dofIndex("b1")] += 0.5;
  EXPECT_FALSE(liesCloseBehindTheWrist(tree, pose, other)) << "the wrist alone turns it";
  other.X_WH = Eigen::Translation3d(p_HB) * Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitZ()) *
               Eigen::Translation3d(-p_HB);
  EXPECT_FALSE(liesClose(*model, pose, other));
  EXPECT_TRUE(liesCloseBehindTheWrist(tree, pose, other));

  hand::HandPose farther = other;
  farther.X_WH.translation().z() += 0.019;
  EXPECT_TRUE(liesCloseBehindTheWrist(tree, pose, farther));
  farther.X_WH.translation().z() += 0.002;
  EXPECT_FALSE(liesCloseBehindTheWrist(tree, pose, farther));
  other.q[model->dofIndex("b3")] += 0.3;
  EXPECT_FALSE(liesCloseBehindTheWrist(tree, pose, other)) << "a joint behind it";
}

TEST_F(FinalistsTest, OfAHandWhosePalmTouchesAllJointsCount) {
  PoseProblem problem = makeProblem(model);
  PointPair pair;
  for (const char* link : {"b_tip", "a_tip"}) {
    pair.link = model->linkIndex(link);
    problem.pairs.push_back(pair);
  }
  const MomentTree tree = makeMomentTree(problem);
  const hand::HandPose pose = at(0.0, 1.0).pose;
  EXPECT_TRUE(liesCloseBehindTheWrist(tree, pose, pose));
  for (const char* joint : {"a1", "b1", "b3"}) {
    hand::HandPose other = pose;
    other.q[model->dofIndex(joint)] += 0.3;
    EXPECT_FALSE(liesCloseBehindTheWrist(tree, pose, other)) << joint;
  }
}

}  // namespace
}  // namespace handgraft::optimize
