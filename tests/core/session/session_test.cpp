#include "core/session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/posture.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::session {
namespace {

using test::BallGrasp;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Pose somePose() {
  Pose X = Pose::Identity();
  X.linear() = rotationFromVector({0.6, -1.2, 2.0});
  X.translation() << 0.3, -0.4, 0.9;
  return X;
}

TEST(Session, GraspsABall) {
  Session session = BallGrasp().open(somePose());
  const optimize::SolveReport report = session.optimize({}, Progress());
  ASSERT_EQ(report.patches.size(), 3u);
  for (const optimize::PatchFit& fit : report.patches) {
    EXPECT_EQ(fit.point_count, 25);
    // Balls of 10 and 30 mm that touch are 3.3 mm apart 7 mm beside that place: by the normals
    // alone, and where they keep out of each other, a little more.
    EXPECT_LT(fit.mean_mm, 4.2);
    EXPECT_LT(fit.normal_mean_deg, 60.0);
  }
}

TEST(Session, LaysEveryPatchOnTheSiteOfItsName) {
  Session session = BallGrasp().open();
  session.transferPatches(Progress());
  const hand::HandModel& model = *session.hand().model;
  for (int i = 0; i < 3; ++i) {
    const SessionPatch& item = session.patches()[i];
    EXPECT_EQ(item.site, item.patch.name);
    EXPECT_TRUE(item.up_to_date);
    EXPECT_TRUE(item.transferred.lost.empty());
    for (const transfer::Correspondence& pair : item.transferred.correspondences) {
      EXPECT_EQ(model.links()[pair.link].name, item.patch.name + "_tip");
      EXPECT_EQ(pair.patch, i);
    }
  }
}

TEST(Session, DropsAFingerThatTheHandLacks) {
  Session session = BallGrasp({"thumb", "index", "ring", "little"}).open();
  std::vector<std::string> sites;
  for (const SessionPatch& patch : session.patches()) {
    if (patch.placement) {
      sites.push_back(patch.site);
    } else {
      EXPECT_THAT(patch.dropped, AllOf(HasSubstr("hand has fewer fingers than touched"),
                                       HasSubstr(patch.patch.name)));
    }
  }
  EXPECT_EQ(sites, (std::vector<std::string>{"thumb", "index", "middle"}));
  const optimize::SolveReport report = session.optimize({}, Progress());
  EXPECT_EQ(report.patches.size(), 3u);
}

TEST(Session, GivesALackingFingersPatchToOneThatIsFree) {
  const Session session = BallGrasp({"thumb", "index", "little"}).open();
  const SessionPatch& little = session.patches()[2];
  EXPECT_EQ(little.site, "middle");
  const hand::Hand& hand = session.hand();
  EXPECT_EQ(little.placement->root_S.face,
            transfer::placementAt(*hand.model, *hand.skin, hand.sites[2]).root_S.face);
  EXPECT_FALSE(little.root_is_open) << "the hand's own site";
  EXPECT_THAT(session.notes(),
              Contains(HasSubstr("little's contacts go to the hand's middle")));
}

TEST(Session, RefusesNamesThatAreNoSite) {
  const BallGrasp grasp({"thumb", "elbow"});
  EXPECT_THAT(
      [&] {
        (void)grasp.open();
      },
      ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("'elbow'"), HasSubstr("thumb, index, middle"))));
}

TEST(Session, RefusesANameThatComesTwice) {
  const BallGrasp grasp({"thumb", "thumb"});
  EXPECT_THAT(
      [&] {
        (void)grasp.open();
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'thumb' twice")));
}

TEST(Session, RefusesASetWithoutAnySiteOnTheHand) {
  BallGrasp grasp({"ring", "little"});
  grasp.small.sites.resize(1);
  EXPECT_THAT(
      [&] {
        (void)grasp.open();
      },
      ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("ring, little"), HasSubstr("its sites are thumb"))));
}

TEST(Session, RefusesPatchesOfAnotherMesh) {
  BallGrasp grasp;
  grasp.contacts.patches[1].boundary[0] = grasp.ball->vertexCount();
  EXPECT_THAT(
      [&] {
        (void)grasp.open();
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'index'")));
}

TEST(Session, SolvesTheSameGraspWhereverTheObjectIs) {
  const BallGrasp grasp;
  optimize::Weights weights;
  weights.prior = 0.0;
  Session here(grasp.hand(), grasp.ball, grasp.contacts, Pose::Identity(), weights);
  Session there(grasp.hand(), grasp.ball, grasp.contacts, somePose(), weights);
  const auto a = here.optimize({}, Progress());
  const auto b = there.optimize({}, Progress());
  EXPECT_NEAR(a.terms.objective, b.terms.objective, 1e-3 * a.terms.objective);
}

TEST(Session, ProblemIsInTheWorld) {
  Session session = BallGrasp().open(somePose());
  session.transferPatches(Progress());
  const optimize::PoseProblem problem = session.problem();
  ASSERT_EQ(problem.pairs.size(), 75u);
  std::size_t k = 0;
  for (const SessionPatch& item : session.patches()) {
    for (const transfer::Correspondence& pair : item.transferred.correspondences) {
      EXPECT_EQ(problem.pairs[k].p_W, somePose() * pair.p_O);
      EXPECT_EQ(problem.pairs[k].n_W, somePose().linear() * pair.n_O);
      EXPECT_EQ(problem.pairs[k].p_L, pair.p_L);
      ++k;
    }
  }
  EXPECT_TRUE(problem.start.X_WH.isApprox(Pose::Identity()));
  EXPECT_EQ(problem.prior.q,
            hand::relaxedPosture(*session.hand().model, session.hand().skin->qReference()));
}

TEST(Session, ProblemNeedsATransferFirst) {
  const Session session = BallGrasp().open();
  EXPECT_THROW((void)session.problem(), BrokenContract);
}

TEST(Session, KeepsTheOptimumAsNextPriorAndStart) {
  Session session = BallGrasp().open();
  const optimize::SolveReport report = session.optimize({}, Progress());
  const optimize::PoseProblem next = session.problem();
  EXPECT_EQ(next.prior.q, report.pose.q);
  EXPECT_EQ(next.start.q, report.pose.q);
  EXPECT_TRUE(next.prior.X_WH.isApprox(report.pose.X_WH));
  const optimize::SolveReport again = session.optimize({}, Progress());
  EXPECT_LE(again.terms.objective, report.terms.objective * (1 + 1e-9));
}

TEST(Session, SolvesTheSameBytesAgain) {
  const BallGrasp grasp({"c1", "c2", "c3"}, true);
  Session first = grasp.open();
  Session second = grasp.open();
  const auto a = first.optimize({}, Progress());
  const auto b = second.optimize({}, Progress());
  EXPECT_EQ(a.pose.q, b.pose.q);
  EXPECT_EQ(a.pose.X_WH.matrix(), b.pose.X_WH.matrix());
}

TEST(Session, FindsOpenDirectionsThatServeAsWellAsGivenOnes) {
  Session given = BallGrasp().open();
  Session open = BallGrasp({"thumb", "index", "middle"}, true).open();
  EXPECT_FALSE(open.patches()[0].patch.direction_O.has_value());
  const auto a = given.optimize({}, Progress());
  const auto b = open.optimize({}, Progress());
  EXPECT_LT(b.terms.objective, 1.2 * a.terms.objective);
  for (const SessionPatch& item : open.patches()) {
    EXPECT_TRUE(item.direction_is_open);
    ASSERT_TRUE(item.patch.direction_O.has_value());
    EXPECT_NEAR(item.patch.direction_O->norm(), 1.0, 1e-9);
  }
}

/// What lies near its patches through a wall reaches none of them.
TEST(Session, CountsAHandInsideAsOneThatReachesNothing) {
  Session session = BallGrasp().open();
  Solution solution = session.solve(SolverSettings(), {}, Progress());
  ASSERT_GT(solution.report.patches.size(), 0u);
  EXPECT_EQ(failedPatches(solution.problem, solution.report), 0);
  solution.report.terms.penetration = 1e-6;  // m^2: pressed on
  EXPECT_EQ(failedPatches(solution.problem, solution.report), 0);
  solution.report.terms.penetration = 6e-6;
  EXPECT_EQ(failedPatches(solution.problem, solution.report),
            std::ssize(solution.report.patches));
}

/// Edits of a grasp that is lost were each answered by a whole search: 300 ms in place of 4.
TEST(Session, AnswersAnEditByFewStepsWhereNothingIsReachedEither) {
  Session session = BallGrasp().open();
  session.optimize({}, Progress());
  optimize::PriorShares where_it_is;
  where_it_is.root_rotation = where_it_is.root_translation = 1e12;
  session.apply(PriorSharesEdit{where_it_is});
  Pose away = Pose::Identity();
  away.translation().x() = 0.4;
  session.apply(ObjectPoseEdit{away});
  SolverSettings brief;
  brief.starts = 2;  // as a server after an edit
  SolveRun run;
  run.places_stay = true;
  const Solution lost = session.solve(brief, run, Progress());
  ASSERT_TRUE(reachesNothing(lost.problem, lost.report));
  const Solution whole = session.solve({}, {}, Progress());
  EXPECT_LT(10 * lost.report.evaluations, whole.report.evaluations);
}

TEST(Session, FindsTheFingersOfAnonymousPatches) {
  Session session = BallGrasp({"c1", "c2", "c3"}, true).open();
  // One patch is opposed to the two others: that one is the thumb's.
  EXPECT_EQ(session.patches()[0].site, "thumb");
  EXPECT_NE(session.patches()[1].site, session.patches()[2].site);
  EXPECT_THAT(session.notes(), Contains(HasSubstr("'c1' laid on site 'thumb'")));
}

TEST(Session, SaysWhenNoPatchHasAPoint) {
  Session session = BallGrasp().open();
  for (const char* patch : {"thumb", "index", "middle"}) {
    session.apply(PatchWeightEdit{patch, 0.0});
  }
  EXPECT_THAT(
      [&] {
        session.optimize({}, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("no patch with a weight above 0")));
}

TEST(Session, StaysAsItWasWhenCancelled) {
  Session session = BallGrasp({"thumb", "index", "middle"}, true).open();
  Progress progress;
  progress.cancel();
  EXPECT_THROW(session.optimize({}, progress), Cancelled);
  EXPECT_NO_THROW(session.optimize({}, Progress()));
}

}  // namespace
}  // namespace handgraft::session
