#include "core/retargeting/motion_solving.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::retargeting {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A ball held by thumb, index and middle while it moves along x; the middle finger goes after
/// half of the time.
manipulation::Motion ballMotion(const test::BallGrasp& grasp, int frames = 12) {
  manipulation::Motion motion;
  motion.name = "carry";
  motion.object = "ball";
  for (int k = 0; k < frames; ++k) {
    motion.time_s.push_back(k / 60.0);
    Pose X_WO = Pose::Identity();
    X_WO.translation().x() = 0.01 * k;
    motion.X_WO.push_back(X_WO);
  }
  for (const contact::Patch& patch : grasp.contacts.patches) {
    manipulation::PatchTrack track;
    track.name = patch.name;
    track.end = patch.name == "middle" ? frames / 2 : frames;
    track.keys.resize(1);
    track.keys[0].patch = patch;
    motion.tracks.push_back(track);
  }
  return motion;
}

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

TEST(MotionSolving, RecordedPointsAreCalledAfterTheirPlaces) {
  const test::BallGrasp grasp;
  manipulation::Motion motion = ballMotion(grasp);
  for (manipulation::PatchTrack& track : motion.tracks) {
    contact::Patch& patch = track.keys[0].patch;
    patch.interpolation_boundary.resize(1);
    patch.boundary.clear();
    patch.place = hand::placeNamed("index_distal");
    track.name = track.name + "3";
  }
  motion.tracks[0].keys[0].patch.place.reset();
  const contact::ContactSet set = graspOf(motion, *grasp.ball);
  EXPECT_EQ(set.patches[0].name, "c1");
  EXPECT_EQ(set.patches[1].name, "index_distal");
  EXPECT_EQ(set.patches[2].name, "index_distal_2");
  EXPECT_EQ(set.patches[2].interpolation_boundary.size(), 12u);
}

TEST(MotionSolving, TellsOfEachFrameWhatIsThere) {
  const test::BallGrasp grasp;
  const manipulation::Motion motion = ballMotion(grasp);
  const SolvedMotion answer = solved(grasp, motion, grasp.open().document());
  ASSERT_EQ(answer.trajectory.poses.size(), 12u);
  ASSERT_EQ(answer.depth_m.size(), 12u);
  const MotionFits fits(motion, answer);
  EXPECT_EQ(fits.at(0).size(), 3u);
  EXPECT_EQ(fits.at(11).size(), 2u);
  for (const PatchFrameFit& fit : fits.at(0)) {
    EXPECT_GT(fit.points, 10);
    EXPECT_EQ(fit.presence, 1.0);
    EXPECT_EQ(fit.reached, fit.mean_mm <= 6.0 && fit.normal_deg <= 60.0);
  }
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
    EXPECT_EQ(one.depth_m[k], two.depth_m[k]);
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
  EXPECT_EQ(MotionFits(motion, solved(grasp, motion, document)).at(0).size(), 3u);
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
