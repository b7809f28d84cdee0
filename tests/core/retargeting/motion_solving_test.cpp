#include "core/retargeting/motion_solving.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/placement/solids.h"
#include "core/session/session.h"

#include "tests/core/session/ball_motion.h"

namespace handgraft::retargeting {
namespace {

using test::ballMotion;
using testing::ElementsAre;
using testing::HasSubstr;

SolvedMotion solved(const test::BallGrasp& grasp,
                    const manipulation::Motion& motion,
                    const session::Document& document,
                    int threads = 1) {
  return solveMotion(document, grasp.hand(), grasp.ball, motion, motionSolving(false), threads,
                     Progress());
}

TEST(MotionSolving, TheGraspThatStandsForAMotionHasEachPatchOnce) {
  const test::BallGrasp grasp;
  manipulation::Motion motion = ballMotion(grasp);
  manipulation::PatchTrack again = motion.tracks[2];
  again.keys[0].frame = 9;
  again.end = 12;
  motion.tracks.push_back(again);
  EXPECT_THAT(patchNames(motion), ElementsAre("thumb", "index", "middle"));
  EXPECT_EQ(graspOf(motion, *grasp.ball).patches.size(), 3u);
}

TEST(MotionSolving, RecordedPointsAreCalledAfterTheirPlacesBySessionsAsWell) {
  const test::BallGrasp grasp;
  manipulation::Motion motion = ballMotion(grasp);
  for (manipulation::PatchTrack& track : motion.tracks) {
    contact::Patch& patch = track.keys[0].patch;
    patch.interpolation_boundary.resize(1);
    patch.boundary.clear();
    patch.place = hand::placeNamed("index_distal");
    track.name = track.name + "3";
    track.keys[0].hand_points = {{track.name, {}}};
  }
  motion.tracks[0].keys[0].patch.place.reset();
  nameByParts(motion);
  EXPECT_THAT(patchNames(motion), ElementsAre("c1", "index_distal", "index_distal_2"));
  const manipulation::Motion once = motion;
  nameByParts(motion);
  EXPECT_EQ(patchNames(motion), patchNames(once)) << "once and for all";
  const contact::ContactSet set = graspOf(motion, *grasp.ball);
  EXPECT_EQ(set.patches[0].name, "c1");
  EXPECT_EQ(set.patches[1].name, "index_distal");
  EXPECT_EQ(set.patches[2].name, "index_distal_2");
  EXPECT_EQ(set.patches[2].interpolation_boundary.size(), 12u);
}

// A recording of another robot's links says nothing of this hand.
TEST(MotionSolving, SaysWhoseLinksTheHandHasNot) {
  const test::BallGrasp grasp;
  manipulation::Motion motion = ballMotion(grasp);
  motion.name = "pick";
  motion.hand = "claw";
  for (manipulation::PatchTrack& track : motion.tracks) {
    for (manipulation::PatchKey& key : track.keys) {
      key.patch.interpolation_boundary.resize(1);
      key.patch.boundary.clear();
      key.patch.place.reset();
      key.hand_points = {{"claw_" + track.name, {}}};
    }
    track.name = "claw_" + track.name;
  }
  nameByParts(motion);
  session::Document document = grasp.open().document();
  document.patches.resize(motion.tracks.size());
  for (std::size_t i = 0; i < document.patches.size(); ++i)
    document.patches[i].name = motion.tracks[i].name;
  try {
    (void)solved(grasp, motion, document);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("motion 'pick'"));
    EXPECT_THAT(error.what(),
                HasSubstr("hand 'claw', whose links ('claw_index', 'claw_middle'"));
  }
}

TEST(MotionSolving, TellsOfEachFrameWhatIsThere) {
  const test::BallGrasp grasp;
  const manipulation::Motion motion = ballMotion(grasp);
  const SolvedMotion answer = solved(grasp, motion, grasp.open().document());
  ASSERT_EQ(answer.trajectory.poses.size(), 12u);
  ASSERT_EQ(answer.depths.size(), 12u);
  const MotionFits fits(motion, answer);
  EXPECT_EQ(fits.at(0).size(), 3u);
  EXPECT_EQ(fits.at(11).size(), 2u);
  for (const PatchFrameFit& fit : fits.at(0)) {
    EXPECT_GT(fit.points, 10);
    EXPECT_EQ(fit.presence, 1.0);
    EXPECT_TRUE(fit.reached);
  }
}

TEST(MotionSolving, TellsHowDeepEachFrameIs) {
  const test::BallGrasp grasp;
  session::Document document = grasp.open().document();
  document.solving.avoid_penetration = false;
  const SolvedMotion answer = solved(grasp, ballMotion(grasp), document);
  const hand::Hand hand = grasp.hand();
  quality::Depths deepest;
  for (std::size_t k = 0; k < answer.depths.size(); ++k) {
    const quality::Penetration whole =
        placement::penetrationOf(hand.model, hand.skin, grasp.ball, Pose::Identity(),
                                 answer.trajectory.poses[k], {}, Progress());
    EXPECT_NEAR(answer.depths[k].object_m, whole.max_depth_m, 1e-12) << k;
    EXPECT_NEAR(answer.depths[k].self_m, whole.self_depth_m, 1e-12) << k;
    deepest = deeperOf(deepest, answer.depths[k]);
  }
  EXPECT_GT(deepest.object_m, 1e-4);
}

// A patch that bends about an edge faces the hand if its mean normal does, as in a grasp.
TEST(MotionSolving, ABendOfAPatchCostsNoReach) {
  const test::BallGrasp grasp;
  const manipulation::Motion motion = ballMotion(grasp);
  SolvedMotion answer = solved(grasp, motion, grasp.open().document());
  const hand::LinkPoses X_OL =
      hand::forwardKinematics(*answer.problem.model, answer.trajectory.poses[0]);
  int turn = 1;
  for (optimize::PointPair& pair : answer.problem.tracks[0].spans[0].pairs) {
    // The hand's side bent by 70 degrees to either side of what the object's normal asks for.
    const Eigen::AngleAxisd bend(turn * 70.0 * std::numbers::pi / 180.0,
                                 Eigen::Vector3d::UnitZ());
    const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
    pair.n_W = Eigen::Vector3d::UnitX();
    pair.n_L = X.linear().transpose() * (bend * -pair.n_W);
    turn = -turn;
  }
  auto& pairs = answer.problem.tracks[0].spans[0].pairs;
  if (pairs.size() % 2 == 1) pairs.pop_back();
  const PatchFrameFit bent = MotionFits(motion, answer).at(0)[0];
  EXPECT_NEAR(bent.normal_deg, 70.0, 1e-6);
  EXPECT_TRUE(bent.reached);
  for (optimize::PointPair& pair : pairs)
    pair.n_L = -pair.n_L;
  EXPECT_FALSE(MotionFits(motion, answer).at(0)[0].reached);
}

TEST(MotionSolving, IsTheSameOnAnyNumberOfThreads) {
  const test::BallGrasp grasp;
  const manipulation::Motion motion = ballMotion(grasp);
  const session::Document document = grasp.open().document();
  const SolvedMotion one = solved(grasp, motion, document, 1);
  const SolvedMotion two = solved(grasp, motion, document, 2);
  for (std::size_t k = 0; k < one.trajectory.poses.size(); ++k) {
    EXPECT_EQ(one.trajectory.poses[k].q, two.trajectory.poses[k].q);
    EXPECT_EQ(one.trajectory.poses[k].X_WH.matrix(), two.trajectory.poses[k].X_WH.matrix());
    EXPECT_EQ(one.depths[k], two.depths[k]);
  }
}

TEST(MotionSolving, FollowsTheDocument) {
  const test::BallGrasp grasp;
  const manipulation::Motion motion = ballMotion(grasp);
  session::Document document = grasp.open().document();
  document.joints[0].lower = document.joints[0].upper = 0.1;
  const SolvedMotion narrowed = solved(grasp, motion, document);
  for (const hand::HandPose& pose : narrowed.trajectory.poses)
    EXPECT_NEAR(pose.q[0], 0.1, 1e-9);

  document.patches[2].enabled = false;
  const std::vector<PatchFrameFit> fits =
      MotionFits(motion, solved(grasp, motion, document)).at(0);
  ASSERT_EQ(fits.size(), 3u);
  EXPECT_EQ(fits[1].presence, 1.0);
  EXPECT_EQ(fits[2].presence, 0.0) << "told, and nothing that could be missed";
  for (session::DocumentPatch& patch : document.patches)
    patch.enabled = false;
  try {
    (void)solved(grasp, motion, document);
    ADD_FAILURE() << "nothing is left to follow";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("switched off"));
  }
}

}  // namespace
}  // namespace handgraft::retargeting
