// What is dragged stays where it was dragged to, through solves and edits, until it is let go.
#include "core/session/pinned_points.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/session/session.h"
#include "core/verdict/verdicts.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/lemon_models.h"
#include "tests/support/wrapping.h"

namespace handgraft::session {
namespace {

using Eigen::Vector3d;
using test::BallGrasp;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

const Vector3d tip_L(0, 0, 0.02);

/// As a server answers an edit.
optimize::SolveReport answered(Session& session) {
  SolveRun run;
  run.places_stay = true;
  Solution solution = session.solve(session.document().solving, run, Progress());
  optimize::SolveReport report = solution.report;
  session.commit(std::move(solution));
  return report;
}

Vector3d placeOf(const Session& session, const std::string& link, const Vector3d& p_L) {
  const hand::HandModel& model = *session.hand().model;
  const auto index = static_cast<std::size_t>(model.linkIndex(link));
  return forwardKinematics(model, session.document().start)[index] * p_L;
}

TEST(PinnedPoint, StaysThroughSolvesAndEditsUntilItIsLetGo) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Vector3d before_W = placeOf(session, "index_tip", tip_L);
  const Vector3d target_W = before_W + Vector3d(0.004, 0.002, -0.004);
  session.apply(DragEdit{"index_tip", tip_L, target_W});
  EXPECT_LT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 1e-4) << "at once";
  answered(session);
  EXPECT_LT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 5e-4) << "solved";
  session.apply(PatchWeightEdit{"thumb", 2.0});
  answered(session);
  session.apply(JointLimitEdit{"thumb_1", -0.5, 1.0});
  answered(session);
  EXPECT_LT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 5e-4) << "edited";
  ASSERT_THAT(session.document().held, SizeIs(1));
  const HeldFit fit =
      fitOf(session.document().held[0], *session.hand().model, session.document().start);
  EXPECT_EQ(fit.off_m, (placeOf(session, "index_tip", tip_L) - target_W).norm());
  EXPECT_EQ(fit.off_rad, 0.0);

  session.apply(ReleaseEdit{"index_tip"});
  answered(session);
  EXPECT_THAT(session.document().held, IsEmpty());
  EXPECT_GT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 2e-3)
      << "the patch has it back";
}

// From where a drag has left the hand, steps downhill may lead nowhere: this one stood beside
// the lemon and reached nothing.
TEST(PinnedPoint, ThatIsLetGoFarFromTheObjectGivesTheHandBack) {
  HANDGRAFT_NEEDS_CGAL();
  Session session(
      test::lemonModels(test::handOf(test::modelPath("hands/barrett8/barrett8.urdf"),
                                     test::modelPath("hands/barrett8/sites.yaml"))),
      Pose::Identity(), {});
  session.commit(session.solve(SolverSettings(), SolveRun(), Progress()));
  const hand::ContactSite& thumb = session.hand().sites.front();
  ASSERT_EQ(thumb.name, "thumb");
  SolverSettings brief;
  brief.starts = 2;  // as a server after an edit
  session.apply(SolverSettingsEdit{brief});
  const auto missedNow = [&] {
    const optimize::SolveReport report = answered(session);
    return optimize::missedPatches(session.problem(), report).size();
  };
  session.apply(DragEdit{thumb.link, tip_L, Vector3d(0.3, 0.2, 0.4)});
  const std::size_t dragged = missedNow();
  session.apply(ReleaseEdit{});
  EXPECT_LT(missedNow(), dragged);
}

TEST(PinnedPoint, ThatIsLetGoWhileTheHandTouchesGivesBackNoMoreThanItsPlace) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Vector3d before_W = placeOf(session, "index_tip", tip_L);
  session.apply(DragEdit{"index_tip", tip_L, before_W + Vector3d(0.002, 0.0, 0.0)});
  session.apply(ReleaseEdit{});
  EXPECT_TRUE(session.document().start_is_known) << "from where the hand stands";
}

TEST(PinnedPoint, OfWeightZeroIsTakenBackByTheNextSolve) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Vector3d target_W =
      placeOf(session, "index_tip", tip_L) + Vector3d(0.004, 0.002, -0.004);
  session.apply(DragEdit{"index_tip", tip_L, target_W, std::nullopt, 0.0});
  EXPECT_LT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 1e-4);
  EXPECT_THAT(session.document().held, IsEmpty());
  answered(session);
  EXPECT_GT((placeOf(session, "index_tip", tip_L) - target_W).norm(), 2e-3);
}

TEST(PinnedPoint, IsOneALinkAndMovesWithUndoAndRedo) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Vector3d tip_W = placeOf(session, "index_tip", tip_L);
  session.apply(DragEdit{"index_tip", tip_L, tip_W + Vector3d(0.002, 0, 0)});
  session.apply(DragEdit{"index_tip", {0, 0, 0.01}, tip_W});
  ASSERT_THAT(session.document().held, SizeIs(1));
  EXPECT_EQ(session.document().held[0].target_W, tip_W);
  session.apply(DragEdit{"thumb_tip", tip_L, placeOf(session, "thumb_tip", tip_L)});
  EXPECT_EQ(heldLinks(session.document()),
            (std::vector<std::string>{"index_tip", "thumb_tip"}));
  session.apply(UndoEdit{2});
  ASSERT_THAT(session.document().held, SizeIs(1));
  EXPECT_EQ(session.document().held[0].p_L, tip_L);
  session.apply(RedoEdit{2});
  EXPECT_THAT(session.document().held, SizeIs(2));
  session.apply(ReleaseEdit{});
  EXPECT_THAT(session.document().held, IsEmpty());
}

TEST(PinnedPoint, HoldsARotationToo) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Pose X_WL = forwardKinematics(*session.hand().model, session.document().start)[0];
  DragEdit palm{session.hand().model->links()[0].name, Vector3d::Zero(),
                X_WL.translation() + Vector3d(0, 0, -0.003)};
  palm.target_R_WL = rotationFromVector({0.0, 0.05, 0.0}) * X_WL.linear();
  session.apply(palm);
  answered(session);
  session.apply(PatchWeightEdit{"thumb", 0.5});
  answered(session);
  const HeldFit fit =
      fitOf(session.document().held.at(0), *session.hand().model, session.document().start);
  EXPECT_LT(fit.off_m, 1e-3);
  EXPECT_LT(fit.off_rad, 0.02);
}

TEST(PinnedPoint, IsLetGoWhereThereIsOneAlone) {
  const BallGrasp grasp;
  Session session = grasp.open();
  const auto refused = [&](const Edit& edit, const char* text) {
    EXPECT_THAT(
        [&] {
          session.apply(edit);
        },
        ThrowsMessage<InvalidInput>(HasSubstr(text)));
  };
  refused(ReleaseEdit{}, "nothing is held");
  session.apply(DragEdit{"index_tip", tip_L, placeOf(session, "index_tip", tip_L)});
  refused(ReleaseEdit{"thumb_tip"}, "held are index_tip");
  refused(DragEdit{"index_tip", tip_L, tip_L, std::nullopt, -1.0}, "weight of a drag is -1");
}

TEST(PinnedPoint, StaysOutOfTheObjectAllTheSame) {
  const BallGrasp grasp;
  Session session = grasp.open();
  answered(session);
  const Vector3d inwards = (-placeOf(session, "index_tip", tip_L)).normalized();
  const Vector3d target_W = placeOf(session, "index_tip", tip_L) + 0.01 * inwards;
  session.apply(DragEdit{"index_tip", tip_L, target_W});
  const double pulled_m =
      verdict::penetrationOf(session, session.document().start, Progress()).max_depth_m;
  ASSERT_GT(pulled_m, 0.006);
  answered(session);
  // Who holds it there presses it in, but not as far.
  EXPECT_LT(verdict::penetrationOf(session, session.document().start, Progress()).max_depth_m,
            0.5 * pulled_m);
}

// Shows 8 of the plan: drags at random on three hands.
TEST(PinnedPoint, EndsWhereItIsDraggedToWhereverTheHandReaches) {
  std::mt19937 random(8);
  const auto some = [&] {
    const auto one = [&] {
      return 2.0 * static_cast<double>(random()) / 4294967295.0 - 1.0;
    };
    const double x = one();
    const double y = one();
    return Vector3d(x, y, one());
  };
  int reached = 0;
  std::vector<double> losses_mm;
  double farthest = 0.0;
  for (const char* name : {"human20", "tendon16", "allegro16"}) {
    const std::string folder = std::string("hands/") + name;
    const hand::Hand hand = test::handOf(test::modelPath(folder + "/" + name + ".urdf"),
                                         test::modelPath(folder + "/sites.yaml"));
    for (int k = 0; k < 34; ++k) {
      Session session(test::lemonModels(hand), Pose::Identity(), {});
      // Half of these targets lie inside the lemon or the hand, where neither may be.
      SolverSettings touch_only;
      touch_only.avoid_penetration = false;
      session.apply(SolverSettingsEdit{touch_only});
      const optimize::SolveReport before = answered(session);
      const hand::ContactSite& site = hand.sites[random() % hand.sites.size()];
      const Vector3d target_W = placeOf(session, site.link, site.p_L) + 0.02 * some();
      const EditResult dragged = session.apply(DragEdit{site.link, site.p_L, target_W});
      if (!dragged.message.empty()) continue;  // out of reach
      ++reached;
      const optimize::SolveReport after = answered(session);
      session.apply(PatchWeightEdit{session.patches()[0].patch.name, 1.5});
      answered(session);
      session.apply(ObjectPoseEdit{Pose(Eigen::Translation3d(0.001 * some()))});
      answered(session);
      farthest = std::max(farthest, (placeOf(session, site.link, site.p_L) - target_W).norm());
      for (std::size_t i = 0; i < before.patches.size(); ++i) {
        const SessionPatch& patch =
            session.patches()[static_cast<std::size_t>(before.patches[i].patch)];
        if (patch.site == site.name) continue;
        losses_mm.push_back(after.patches[i].mean_mm - before.patches[i].mean_mm);
      }
    }
  }
  EXPECT_GT(reached, 80);
  EXPECT_LT(farthest, 2e-3);
  std::nth_element(losses_mm.begin(), losses_mm.begin() + std::ssize(losses_mm) / 2,
                   losses_mm.end());
  EXPECT_LT(losses_mm[losses_mm.size() / 2], 2.0);
}

}  // namespace
}  // namespace handgraft::session
