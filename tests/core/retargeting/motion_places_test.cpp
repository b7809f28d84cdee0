#include "core/retargeting/motion_places.h"

#include <gtest/gtest.h>

#include "core/retargeting/edited_motion.h"

#include "tests/core/session/two_plates.h"

namespace handgraft::retargeting {
namespace {

using test::TwoPlates;

/// The rigid plate held to the other one for a third of a second.
class MotionOfPlates : public testing::Test {
 protected:
  static constexpr int kFrames = 40;

  static std::shared_ptr<const manipulation::Motion> heldTo(const TwoPlates& plates) {
    auto motion = std::make_shared<manipulation::Motion>();
    motion->name = "plates";
    for (int k = 0; k < kFrames; ++k) {
      motion->time_s.push_back(k / 120.0);
      motion->X_WO.push_back(Pose::Identity());
    }
    for (const contact::Patch& patch : plates.contacts.patches) {
      manipulation::PatchTrack track;
      track.name = patch.name;
      track.end = kFrames;
      track.keys.resize(2);
      track.keys[1].frame = 20;
      track.keys[0].patch = track.keys[1].patch = patch;
      motion->tracks.push_back(track);
    }
    return motion;
  }

  /// Nothing keeps the plates apart.
  static session::Document touching(const TwoPlates& plates) {
    session::Document document = plates.open().document();
    document.solving.avoid_penetration = false;
    return document;
  }

  static std::shared_ptr<const SolvedMotion> solve(EditedMotion& bench,
                                                   const TwoPlates& plates,
                                                   const session::Document& document,
                                                   int threads = 1) {
    return bench.solve(document, plates.hand, motionSolving(false), threads, Progress());
  }

  /// Of the last frame's patches.
  static double worstOf(const TwoPlates& plates, const SolvedMotion& solved) {
    const auto motion = heldTo(plates);
    double worst = 0.0;
    for (const PatchFrameFit& fit : MotionFits(*motion, solved).at(kFrames - 1))
      worst = std::max(worst, fit.mean_mm);
    return worst;
  }

  static std::vector<Eigen::Vector3d> placesOf(const SolvedMotion& solved) {
    std::vector<Eigen::Vector3d> places;
    for (const manipulation::PairTrack& track : solved.problem.tracks)
      for (const manipulation::PairSpan& span : track.spans)
        for (const optimize::PointPair& pair : span.pairs)
          places.push_back(pair.p_L);
    return places;
  }
};

TEST_F(MotionOfPlates, SlidesPatchesOnFoundSitesToWhereTheyFit) {
  const TwoPlates plates;
  EditedMotion bench(heldTo(plates), plates.plate);
  const auto solved = solve(bench, plates, touching(plates));
  // Roots lie in the middle of faces of 2 mm.
  EXPECT_LT(worstOf(plates, *solved), 1.0);
}

TEST_F(MotionOfPlates, LeavesPatchesOnSitesThatSomebodyChose) {
  TwoPlates plates;
  plates.hand.sites_are_found = false;
  EditedMotion bench(heldTo(plates), plates.plate);
  const auto solved = solve(bench, plates, touching(plates));
  EXPECT_NEAR(worstOf(plates, *solved), 5.0, 0.5);
}

TEST_F(MotionOfPlates, LeavesPatchesWhereTheySlidAfterAnEdit) {
  const TwoPlates plates;
  EditedMotion bench(heldTo(plates), plates.plate);
  session::Document document = touching(plates);
  const auto before = solve(bench, plates, document);
  document.patches[0].weight = 50.0;
  const auto after = solve(bench, plates, document);
  EXPECT_EQ(placesOf(*after), placesOf(*before));
  EXPECT_NE(after->problem.tracks[0].spans[0].pairs[0].weight,
            before->problem.tracks[0].spans[0].pairs[0].weight);
}

TEST_F(MotionOfPlates, HasTheSameBytesOnTwoThreads) {
  const TwoPlates plates;
  const session::Document document = touching(plates);
  EditedMotion one(heldTo(plates), plates.plate);
  EditedMotion two(heldTo(plates), plates.plate);
  const auto a = solve(one, plates, document, 1);
  const auto b = solve(two, plates, document, 2);
  EXPECT_EQ(placesOf(*a), placesOf(*b));
  for (std::size_t k = 0; k < kFrames; ++k)
    EXPECT_EQ(a->trajectory.poses[k].X_WH.matrix(), b->trajectory.poses[k].X_WH.matrix()) << k;
}

}  // namespace
}  // namespace handgraft::retargeting
