#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::session {
namespace {

using test::BallGrasp;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Session transferred() {
  Session session = BallGrasp().open();
  session.transferPatches(Progress());
  return session;
}

std::vector<bool> upToDate(const Session& session) {
  std::vector<bool> flags;
  for (const SessionPatch& item : session.patches())
    flags.push_back(item.up_to_date);
  return flags;
}

TEST(SessionEdit, CountsTheRevision) {
  Session session = transferred();
  EXPECT_EQ(session.revision(), 0u);
  session.apply(PatchWeightEdit{"thumb", 2.0});
  session.apply(JointLockEdit{"index_1", true});
  EXPECT_EQ(session.revision(), 2u);
}

TEST(SessionEdit, TellsLimitsInDegrees) {
  Session session = BallGrasp().open();
  EXPECT_EQ(session.apply(JointLimitEdit{"thumb_1", -0.4, 1.2}).message, "");
  EXPECT_THAT(session.apply(JointLimitEdit{"thumb_1", 30.0, 60.0}).message,
              HasSubstr("angles are radians, not degrees"));
  EXPECT_EQ(session.document().joints[0].upper, 60.0) << "taken all the same";
}

TEST(SessionEdit, TellsLimitsBeyondTheHandsAlsoOfATime) {
  Session session = BallGrasp().open();
  const hand::HandModel& model = *session.hand().model;
  const int dof = model.dofIndex("thumb_1");
  const double lower = model.lower()[dof];
  const double upper = model.upper()[dof];
  const auto told = [&](double most) {
    return session.apply(TimedEdit{{2.0, 0.5}, JointLimitEdit{"thumb_1", lower, most}}).message;
  };
  EXPECT_EQ(told(upper), "");
  EXPECT_THAT(told(upper + 0.1), HasSubstr("go beyond the hand's own"));
  EXPECT_THAT(told(60.0), HasSubstr("angles are radians, not degrees"));
}

TEST(SessionEdit, OfATimeIsToldWithUnits) {
  const Session session = BallGrasp().open();
  const hand::HandModel& model = *session.hand().model;
  const TimedEdit limit{{2.0, 1e6}, JointLimitEdit{"thumb_1", -0.4, 1.2}};
  EXPECT_EQ(describe(limit, model), "limit thumb_1 -0.4 to 1.2 rad at 2 s +- 1000000 s");
  EXPECT_EQ(describe(limit.change, model), "limit thumb_1 -0.4 to 1.2 rad");
  EXPECT_EQ(describe(TimedEdit{{0.5, 0.0}, JointSoftEdit{"thumb_1", 0.25, 2.0}}, model),
            "soft thumb_1 0.25 rad weight 2 at 0.5 s");
}

TEST(SessionEdit, ThatIsWrongChangesNothing) {
  Session session = transferred();
  const auto refuses = [&](const Edit& edit, const char* text) {
    EXPECT_THAT(
        [&] {
          session.apply(edit);
        },
        ThrowsMessage<InvalidInput>(HasSubstr(text)));
  };
  Pose broken = Pose::Identity();
  broken.linear() *= 2.0;
  refuses(ObjectPoseEdit{broken}, "no rigid motion");
  broken.translation().x() = kNaN;
  refuses(ObjectPoseEdit{broken}, "not finite");
  refuses(PatchWeightEdit{"thumb", -1.0}, "'thumb' is -1; permitted are 0 to");
  refuses(PatchWeightEdit{"thumb", kNaN}, "nan");
  refuses(PatchWeightEdit{"elbow", 1.0}, "'elbow'; there are thumb, index, middle");
  refuses(PatchRootEdit{"thumb", Side::kObject, {99'999'999, {1, 0, 0}}}, "thumb");
  refuses(PatchRootEdit{"thumb", Side::kHand, {0, {0.7, 0.7, 0.7}}}, "thumb");
  refuses(PatchDirectionEdit{"thumb", Side::kHand, kInfinity}, "inf");
  refuses(JointLimitEdit{"thumb_1", 1.0, 0.5}, "above its upper limit");
  refuses(JointLimitEdit{"thumb_1", -kInfinity, 0.5}, "-inf rad; permitted are");
  refuses(JointSoftEdit{"thumb_1", 99.0, 1.0}, "'thumb_1' is 99 rad; permitted are");
  refuses(JointLimitEdit{"elbow", 0.0, 0.5}, "elbow");
  refuses(JointLockEdit{"elbow", true}, "elbow");
  refuses(PriorEdit{std::nullopt, {"thumb_1"}, {}}, "1 joints with 0 values");
  refuses(PriorEdit{std::nullopt, {"thumb_1"}, {2.1}}, "'thumb_1' is 2.1");
  refuses(PriorEdit{std::nullopt, {"thumb_1", "thumb_1"}, {0.1, 0.2}}, "twice");
  refuses(PriorEdit{std::nullopt, {"thumb_2", "thumb_1"}, {0.1, kNaN}}, "nan");
  refuses(WeightsEdit{{1.0, -1.0, 1.0}}, "normals");
  refuses(WeightsEdit{{0.0, 0.0, 0.0}}, "all 0");

  EXPECT_EQ(session.revision(), 0u);
  const Session untouched = transferred();
  EXPECT_EQ(upToDate(session), upToDate(untouched));
  EXPECT_EQ(session.problem().lower, untouched.problem().lower);
  EXPECT_EQ(session.problem().start.q, untouched.problem().start.q);
  EXPECT_EQ(session.objectPose().matrix(), untouched.objectPose().matrix());
}

TEST(SessionEdit, OfAWeightNeedsNoNewTransfer) {
  Session session = transferred();
  session.apply(PatchWeightEdit{"index", 3.0});
  for (const optimize::PointPair& pair : session.problem().pairs) {
    EXPECT_EQ(pair.weight, pair.patch == 1 ? 3.0 : 1.0);
  }
}

TEST(SessionEdit, OfARootMakesThatPatchAloneStale) {
  Session session = transferred();
  session.apply(PatchRootEdit{"index", Side::kObject, {100, {0.2, 0.3, 0.5}}});
  EXPECT_EQ(upToDate(session), (std::vector<bool>{true, false, true}));
  session.transferPatches(Progress());
  EXPECT_EQ(upToDate(session), (std::vector<bool>{true, true, true}));
}

TEST(SessionEdit, OfARootTakesTheDirectionAlong) {
  Session session = transferred();
  const geometry::SurfacePoint root{100, {0.2, 0.3, 0.5}};
  session.apply(PatchRootEdit{"thumb", Side::kObject, root});
  const Eigen::Vector3d d = *session.patches()[0].patch.direction_O;
  EXPECT_NEAR(d.norm(), 1.0, 1e-12);
  EXPECT_NEAR(d.dot(normalOf(session.object(), root)), 0.0, 1e-12);
}

TEST(SessionEdit, OfADirectionTurnsCounterClockwise) {
  Session session = transferred();
  const auto direction_of = [&] {
    return *session.patches()[0].patch.direction_O;
  };
  const Eigen::Vector3d n = normalOf(session.object(), session.patches()[0].patch.root);
  const Eigen::Vector3d before = direction_of();
  session.apply(PatchDirectionEdit{"thumb", Side::kObject, kPi / 2});
  const Eigen::Vector3d tangent = (before - before.dot(n) * n).normalized();
  EXPECT_GT(direction_of().dot(n.cross(tangent)), 0.999);
  EXPECT_FALSE(session.patches()[0].up_to_date);
}

TEST(SessionEdit, OfAnOpenDirectionFixesIt) {
  Session session = BallGrasp({"thumb", "index", "middle"}, true).open();
  session.apply(PatchDirectionEdit{"thumb", Side::kObject, 0.3});
  EXPECT_FALSE(session.patches()[0].direction_is_open);
  const Eigen::Vector3d fixed = *session.patches()[0].patch.direction_O;
  session.optimize({}, Progress());
  EXPECT_EQ(*session.patches()[0].patch.direction_O, fixed);
}

TEST(SessionEdit, OfBothDirectionsByOppositeAnglesChangesNoOutline) {
  // A turn on the object and its mirror image on the hand cancel.
  Session session = transferred();
  const auto before = session.patches()[0].transferred.points_S;
  session.apply(PatchDirectionEdit{"thumb", Side::kObject, 0.4});
  session.apply(PatchDirectionEdit{"thumb", Side::kHand, -0.4});
  session.transferPatches(Progress());
  const auto after = session.patches()[0].transferred.points_S;
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT((before[i] - after[i]).norm(), 1e-4) << i;
  }
}

TEST(SessionEdit, OfARootOnTheHandBringsADroppedPatchBack) {
  Session session = BallGrasp({"thumb", "index", "middle", "little"}).open();
  const auto dropped = std::find_if(session.patches().begin(), session.patches().end(),
                                    [](const SessionPatch& patch) {
                                      return !patch.dropped.empty();
                                    });
  ASSERT_NE(dropped, session.patches().end());
  const std::string name = dropped->patch.name;
  const hand::ContactSite middle = session.hand().sites[2];
  const transfer::PatchPlacement there =
      transfer::placementAt(*session.hand().model, *session.hand().skin, middle);
  session.apply(PatchRootEdit{name, Side::kHand, there.root_S});
  for (const SessionPatch& patch : session.patches())
    EXPECT_TRUE(patch.dropped.empty()) << patch.patch.name;
  const optimize::SolveReport report = session.optimize({}, Progress());
  EXPECT_EQ(report.patches.size(), 4u);
}

TEST(SessionEdit, OfLimitsMovesTheStartInside) {
  Session session = transferred();
  session.apply(JointLimitEdit{"index_2", 0.4, 0.6});
  const optimize::PoseProblem problem = session.problem();
  const int dof = session.hand().model->dofIndex("index_2");
  EXPECT_EQ(problem.lower[dof], 0.4);
  EXPECT_EQ(problem.upper[dof], 0.6);
  EXPECT_EQ(problem.start.q[dof], 0.4);
  const optimize::SolveReport report = session.optimize({}, Progress());
  EXPECT_GE(report.pose.q[dof], 0.4 - 1e-12);
  EXPECT_LE(report.pose.q[dof], 0.6 + 1e-12);
}

TEST(SessionEdit, OfALockHoldsTheJoint) {
  Session session = transferred();
  session.apply(PriorEdit{std::nullopt, {"middle_1"}, {0.25}});
  session.apply(JointLockEdit{"middle_1", true});
  const optimize::SolveReport report = session.optimize({}, Progress());
  EXPECT_DOUBLE_EQ(report.pose.q[session.hand().model->dofIndex("middle_1")], 0.25);
}

TEST(SessionEdit, OfThePriorSetsTheStartToo) {
  Session session = transferred();
  Pose X_WH = Pose::Identity();
  X_WH.translation().z() = 0.1;
  session.apply(PriorEdit{X_WH, {"thumb_2"}, {0.7}});
  const optimize::PoseProblem problem = session.problem();
  const int dof = session.hand().model->dofIndex("thumb_2");
  EXPECT_EQ(problem.prior.q[dof], 0.7);
  EXPECT_EQ(problem.start.q[dof], 0.7);
  EXPECT_EQ(problem.prior.X_WH.matrix(), X_WH.matrix());
  EXPECT_EQ(problem.start.X_WH.matrix(), X_WH.matrix());
}

TEST(SessionEdit, OfTheObjectsPoseMovesThePairsAlone) {
  Session session = transferred();
  Pose X_WO = Pose::Identity();
  X_WO.translation() << 1, 2, 3;
  const Eigen::Vector3d before = session.problem().pairs[0].p_W;
  session.apply(ObjectPoseEdit{X_WO});
  EXPECT_EQ(upToDate(session), (std::vector<bool>{true, true, true}));
  EXPECT_TRUE(session.problem().pairs[0].p_W.isApprox(before + X_WO.translation()));
}

}  // namespace
}  // namespace handgraft::session
