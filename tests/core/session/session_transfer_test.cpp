// What an edit makes the session lay anew, and what it leaves alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::session {
namespace {

using test::BallGrasp;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// The charts of every patch, as objects.
struct Charts {
  std::vector<const void*> object;
  std::vector<const void*> skin;

  explicit Charts(const Session& session) {
    for (const SessionPatch& item : session.patches()) {
      object.push_back(item.stages.patchChart().get());
      skin.push_back(item.stages.skinChart().get());
    }
  }
};

TEST(SessionTransfer, ARootOnTheHandMakesThatPatchsSkinChartAloneAnew) {
  Session session = BallGrasp().open();
  session.transferPatches(Progress());
  const Charts before(session);
  const auto others = session.patches()[2].transferred.points_S;
  geometry::SurfacePoint root = session.patches()[1].placement->root_S;
  root.barycentric = Eigen::Vector3d::Constant(1.0 / 3.0);
  session.apply(PatchRootEdit{"index", Side::kHand, root});
  session.transferPatches(Progress());
  const Charts after(session);
  EXPECT_EQ(after.object, before.object);
  EXPECT_EQ(after.skin[0], before.skin[0]);
  EXPECT_NE(after.skin[1], before.skin[1]);
  EXPECT_EQ(after.skin[2], before.skin[2]);
  EXPECT_EQ(session.patches()[2].transferred.points_S, others);
}

TEST(SessionTransfer, ADirectionTurnsThePatchWithoutALogMap) {
  Session session = BallGrasp().open();
  session.transferPatches(Progress());
  const Charts before(session);
  for (const Side side : {Side::kHand, Side::kObject}) {
    const auto points = session.patches()[0].transferred.points_S;
    session.apply(PatchDirectionEdit{"thumb", side, 0.5});
    EXPECT_FALSE(session.patches()[0].up_to_date);
    session.transferPatches(Progress());
    EXPECT_NE(session.patches()[0].transferred.points_S, points);
  }
  const Charts after(session);
  EXPECT_EQ(after.object, before.object);
  EXPECT_EQ(after.skin, before.skin);
}

TEST(SessionTransfer, WeightsPosesAndLimitsLayNothing) {
  Session session = BallGrasp().open();
  session.optimize({}, Progress());
  const Charts before(session);
  session.apply(PatchWeightEdit{"thumb", 2.0});
  session.apply(ObjectPoseEdit{Pose(Eigen::Translation3d(0.1, 0, 0))});
  session.apply(JointLimitEdit{"index_1", -0.2, 0.9});
  session.apply(WeightsEdit{});
  for (const SessionPatch& item : session.patches())
    EXPECT_TRUE(item.up_to_date);
  session.optimize({}, Progress());
  const Charts after(session);
  EXPECT_EQ(after.object, before.object);
  EXPECT_EQ(after.skin, before.skin);
}

TEST(SessionTransfer, OpenDirectionsAreFoundWithOneLogMapAPatch) {
  const BallGrasp grasp({"thumb", "index", "middle"}, true);
  Session session = grasp.open();
  session.transferPatches(Progress());
  const Charts before(session);
  session.optimize({}, Progress());  // finds the directions anew
  const Charts after(session);
  EXPECT_EQ(after.object, before.object);
  EXPECT_EQ(after.skin, before.skin);
}

TEST(SessionTransfer, LaysInteriorRingsOnWish) {
  const BallGrasp grasp;
  Session session(grasp.hand(), grasp.ball, grasp.contacts, Pose::Identity(), {},
                  {geometry::LogMapMethod::kExact, 3});
  session.transferPatches(Progress());
  for (const SessionPatch& item : session.patches()) {
    EXPECT_EQ(item.transferred.correspondences.size() + item.transferred.lost.size(), 100u);
    EXPECT_EQ(item.transferred.method_S, geometry::LogMapMethod::kExact);
  }
  EXPECT_EQ(session.problem().pairs.size(), 300u);
  EXPECT_THAT(
      [&] {
        Session(grasp.hand(), grasp.ball, grasp.contacts, Pose::Identity(), {},
                {geometry::LogMapMethod::kFast, 99});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("interior rings: 99")));
}

TEST(SessionTransfer, SuggestsNothingWhereNothingIsLostAndRefusesUnknownPatches) {
  Session session = BallGrasp().open();
  session.transferPatches(Progress());
  EXPECT_TRUE(session.suggest("thumb", {}, Progress()).empty());  // nothing is lost

  EXPECT_THAT(
      [&] {
        (void)session.suggest("nose", {}, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("no patch 'nose'")));
  EXPECT_THAT(
      [&] {
        (void)session.suggest("thumb", {1.0, 5}, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("reach is 1 m")));
}

}  // namespace
}  // namespace handgraft::session
