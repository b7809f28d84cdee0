// Motions among what is swept: in how many frames each patch is reached.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/retargeting/motion_solving.h"
#include "core/sweep/sweep.h"
#include "core/sweep/sweep_places.h"

#include "tests/core/session/ball_motion.h"

namespace handgraft::sweep {
namespace {

using hand::HandProperty;
using test::BallGrasp;
using ::testing::HasSubstr;

constexpr int kFrames = 12;

SweepGrasp carried(const BallGrasp& grasp) {
  return {grasp.ball,
          {},
          std::make_shared<const manipulation::Motion>(test::ballMotion(grasp, kFrames))};
}

std::vector<SweepRow> sweepOf(const std::vector<SweepGrasp>& grasps,
                              const std::vector<SweepAxis>& axes,
                              int threads = 1) {
  SweepOptions options;
  options.threads = threads;
  return sweep(BallGrasp().hand(), grasps, axes, options, Progress()).rows;
}

const SweepPatch& patchOf(const SweepRow& row, const std::string& name) {
  for (const SweepPatch& patch : row.patches)
    if (patch.name == name) return patch;
  throw std::out_of_range(name);
}

void expectSame(const SweepRow& a, const SweepRow& b) {
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.terms.objective, b.terms.objective);
  EXPECT_EQ(a.mean_mm, b.mean_mm);
  EXPECT_EQ(a.frames_reached, b.frames_reached);
  ASSERT_EQ(a.patches.size(), b.patches.size());
  for (std::size_t i = 0; i < a.patches.size(); ++i) {
    EXPECT_EQ(a.patches[i].frames, b.patches[i].frames);
    EXPECT_EQ(a.patches[i].reached, b.patches[i].reached);
  }
}

TEST(SweepMotion, OfNothingIsTheMotionAsASessionHasIt) {
  const BallGrasp grasp;
  const SweepGrasp motion = carried(grasp);
  const std::vector<SweepRow> rows = sweepOf({motion}, {});
  ASSERT_EQ(rows.size(), 1u);
  const SweepRow& row = rows[0];
  ASSERT_EQ(row.error, "");
  EXPECT_EQ(row.frame_count, kFrames);
  EXPECT_EQ(row.patch_count, 3);
  EXPECT_EQ(row.q.size(), 0);
  EXPECT_EQ(patchOf(row, "thumb").frames, kFrames);
  EXPECT_EQ(patchOf(row, "middle").frames, kFrames / 2);

  const retargeting::SolvedMotion solved = retargeting::solveMotion(
      grasp.open().document(), grasp.hand(), grasp.ball, *motion.motion,
      retargeting::motionSolving(false), 1, Progress());
  const retargeting::MotionFits fits(*motion.motion, solved);
  int thumb = 0;
  for (int k = 0; k < kFrames; ++k)
    for (const retargeting::PatchFrameFit& fit : fits.at(k))
      thumb += fit.patch == 0 && fit.reached ? 1 : 0;
  EXPECT_EQ(patchOf(row, "thumb").reached, thumb);
  EXPECT_GT(thumb, 0);
  EXPECT_EQ(row.reached_count, 3);
  EXPECT_EQ(row.frames_reached, kFrames);
  quality::Depths deepest;
  for (const quality::Depths& one : solved.depths)
    deepest = deeperOf(deepest, one);
  EXPECT_NEAR(row.depths.object_m, deepest.object_m, 2e-4);
  EXPECT_NEAR(row.depths.self_m, deepest.self_m, 2e-4);
}

TEST(SweepMotion, AHandTooSmallForTheBallLosesItsPatches) {
  const std::vector<SweepRow> rows =
      sweepOf({carried(BallGrasp())}, {{HandProperty::kSize, "", {0.3, 1.0}}});
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[0].error, "");
  EXPECT_EQ(patchOf(rows[0], "index").frames, kFrames);
  EXPECT_LT(rows[0].frames_reached, kFrames);
  EXPECT_LT(rows[0].reached_count, 3);
  EXPECT_EQ(patchOf(rows[1], "index").reached, kFrames);
  EXPECT_GT(rows[0].mean_mm, rows[1].mean_mm);
}

TEST(SweepMotion, RowsKeepTheirLimitsAndNameJointsThatStandThere) {
  const std::vector<SweepRow> rows =
      sweepOf({carried(BallGrasp())}, {{HandProperty::kUpper, "thumb_1", {-0.5}}});
  ASSERT_EQ(rows[0].error, "");
  const LimitedJoint thumb{"thumb_1", true};
  EXPECT_THAT(rows[0].joints_at_limit, ::testing::Contains(thumb));
}

TEST(SweepMotion, GraspsAndMotionsAreSweptTogetherOnAnyNumberOfThreads) {
  const BallGrasp grasp;
  const std::vector<SweepGrasp> both = {{grasp.ball, grasp.contacts}, carried(grasp)};
  const std::vector<SweepAxis> axes = {{HandProperty::kSize, "", {0.9, 1.2}},
                                       {HandProperty::kRange, "thumb_2", {0.3, 1.0}}};
  const std::vector<SweepRow> one = sweepOf(both, axes, 1);
  const std::vector<SweepRow> two = sweepOf(both, axes, 2);
  ASSERT_EQ(one.size(), 8u);
  ASSERT_EQ(two.size(), 8u);
  for (std::size_t i = 0; i < one.size(); ++i) {
    expectSame(one[i], two[i]);
    EXPECT_EQ(one[i].patches.empty(), i % 2 == 0);
  }
  // A row alone is that of the whole sweep.
  const std::vector<SweepRow> alone = sweepOf(
      {both[1]}, {{HandProperty::kSize, "", {1.2}}, {HandProperty::kRange, "thumb_2", {0.3}}});
  expectSame(alone[0], one[5]);
}

TEST(SweepMotion, RecordedPointsGoWithTheSkin) {
  const BallGrasp grasp;
  manipulation::Motion points = test::ballMotion(grasp);
  for (manipulation::PatchTrack& track : points.tracks) {
    contact::Patch& patch = track.keys[0].patch;
    patch.interpolation_boundary.resize(1);
    patch.interpolation_boundary[0] = patch.root;
    patch.boundary.clear();
    patch.place = hand::placeNamed(track.name + "_distal");
  }
  const SweepGrasp recorded{
      grasp.ball, {}, std::make_shared<const manipulation::Motion>(points)};
  const std::vector<SweepRow> rows =
      sweepOf({recorded}, {{HandProperty::kSize, "", {1.0, 1.3}}});
  for (const SweepRow& row : rows) {
    EXPECT_EQ(row.error, "");
    EXPECT_EQ(row.patch_count, 3);
    EXPECT_LT(row.mean_mm, 10.0);
  }
}

TEST(SweepMotion, TellsOfAMotionThatFindsNoPlaceInItsOwnRows) {
  const BallGrasp grasp;
  manipulation::Motion motion = test::ballMotion(grasp);
  for (manipulation::PatchTrack& track : motion.tracks) {
    track.name = "heel";
    track.keys[0].patch.name = "heel";
  }
  const SweepGrasp lost{grasp.ball, {}, std::make_shared<const manipulation::Motion>(motion)};
  const std::vector<SweepRow> rows = sweepOf({lost, {grasp.ball, grasp.contacts}},
                                             {{HandProperty::kUpper, "thumb_1", {0.5, 1.0}}});
  EXPECT_THAT(rows[0].error, HasSubstr("heel"));
  EXPECT_EQ(rows[1].error, "");
  EXPECT_EQ(rows[3].error, "");
}

}  // namespace
}  // namespace handgraft::sweep
