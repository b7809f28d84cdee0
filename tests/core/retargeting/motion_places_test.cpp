#include "core/retargeting/motion_places.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/geometry/surface_locator.h"
#include "core/io/contact_file.h"
#include "core/manipulation/grasp_interpolation.h"
#include "core/retargeting/edited_motion.h"
#include "core/retargeting/motion_grasps.h"
#include "core/retargeting/motion_layer.h"
#include "core/session/session.h"
#include "core/session/timed_edit.h"

#include "tests/core/session/library_models.h"
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

TEST_F(MotionOfPlates, APatchThatSomebodyPutElsewhereLiesThereThroughout) {
  TwoPlates plates;
  plates.hand.sites_are_found = false;
  EditedMotion bench(heldTo(plates), plates.plate);
  session::Document document = touching(plates);
  solve(bench, plates, document);
  const auto on_the_skin = [&](double x) {
    return geometry::SurfaceLocator(plates.hand.skin->mesh()).nearest({x, 0.0, 0.0}).point;
  };
  // As far apart as on the object.
  document.patches[0].placement->root_S = on_the_skin(0.025);
  document.patches[1].placement->root_S = on_the_skin(-0.025);
  EXPECT_LT(worstOf(plates, *solve(bench, plates, document)), 1.0);
}

/// A hand's own site goes before where a hand of its build has such a place, in motions as in
/// grasps.
TEST(MotionOfAGrasp, ThatStaysIsHeldAsTheGraspIs) {
  const hand::Hand hand = test::handOfLibrary("human20");
  const io::MeshFile file = io::readMesh(test::libraryPath("objects/lemon.obj"));
  const auto mesh = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  const contact::ContactSet contacts =
      io::readContactSet(test::libraryPath("contacts/lemon_6.json"), file);
  session::Session grasp(hand, mesh, contacts, Pose::Identity(), {});
  const session::Solution held = grasp.solve(session::SolverSettings(), {}, Progress());

  const auto motion =
      std::make_shared<const manipulation::Motion>(manipulation::interpolateGrasps(
          *mesh, contacts, contacts, {{0.0, Pose::Identity()}, {0.2, Pose::Identity()}}));
  session::Session standing(hand, mesh, graspOf(*motion, *mesh), Pose::Identity(), {});
  EditedMotion bench(motion, mesh);
  const auto solved =
      bench.solve(standing.document(), hand, motionSolving(false), 1, Progress());
  const std::vector<PatchFrameFit> fits = MotionFits(*motion, *solved).at(6);
  ASSERT_EQ(fits.size(), held.report.patches.size());
  for (std::size_t i = 0; i < fits.size(); ++i)
    EXPECT_NEAR(fits[i].mean_mm, held.report.patches[i].mean_mm, 1.0) << i;
}

TEST_F(MotionOfPlates, LeavesOutWhatTheHandHasNoFingerFor) {
  const TwoPlates plates;
  EditedMotion bench(heldTo(plates), plates.plate);
  session::Document document = touching(plates);
  document.patches[1].placement.reset();
  document.patches[1].dropped = "it goes without";
  const auto solved = solve(bench, plates, document);
  ASSERT_EQ(solved->track_of, std::vector<int>{0});
  EXPECT_TRUE(std::any_of(solved->notes.begin(), solved->notes.end(), [](const auto& note) {
    return note.find("it goes without") != std::string::npos;
  }));
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

TEST_F(MotionOfPlates, ItsFramesAreGraspedAsASessionDoes) {
  const TwoPlates plates;
  auto motion = std::make_shared<manipulation::Motion>(*heldTo(plates));
  motion->tracks[1].keys.resize(1);
  motion->tracks[1].end = 10;
  const session::Document document = touching(plates);
  const std::vector<FrameGrasp> grasps =
      graspFrames(document, plates.hand, plates.plate, graspOf(*motion, *plates.plate), *motion,
                  1, Progress());
  // The middle of what has most patches in each third: 0 to 9, 13 to 25, 26 to 39.
  ASSERT_EQ(grasps.size(), 3u);
  EXPECT_EQ(grasps[0].frame, 5);
  EXPECT_EQ(grasps[1].frame, 19);
  EXPECT_EQ(grasps[2].frame, 33);
  session::Session session = plates.open();
  session::SolverSettings solving;
  solving.avoid_penetration = false;
  const session::Solution solution = session.solve(solving, {}, Progress());
  for (std::size_t t = 0; t < 2; ++t) {
    ASSERT_TRUE(grasps[0].placements[t].has_value());
    EXPECT_EQ(grasps[0].placements[t]->root_S.face, solution.patches[t].placement->root_S.face);
    EXPECT_EQ(grasps[0].placements[t]->direction_S, solution.patches[t].placement->direction_S);
  }
  EXPECT_EQ(grasps[0].pose_O.X_WH.matrix(), solution.report.pose.X_WH.matrix());
  EXPECT_TRUE(grasps[1].placements[0].has_value());
  EXPECT_FALSE(grasps[1].placements[1].has_value()) << "it has gone";

  const session::SessionModels models = modelsOfMotion(plates.hand, plates.plate, *motion);
  ASSERT_EQ(models.frames.size(), 3u) << "the same frames";
  EXPECT_EQ(models.frames[0].is_there, (std::vector<bool>{true, true}));
  EXPECT_EQ(models.frames[1].is_there, (std::vector<bool>{true, false}));

  placeAsGrasped(grasps, *motion);
  const auto face_of = [&](const manipulation::PatchKey& key) {
    return key.placement->root_S.face;
  };
  EXPECT_EQ(face_of(motion->tracks[0].keys[0]), grasps[0].placements[0]->root_S.face);
  EXPECT_EQ(face_of(motion->tracks[0].keys[1]), grasps[1].placements[0]->root_S.face);
  EXPECT_EQ(face_of(motion->tracks[1].keys[0]), grasps[0].placements[1]->root_S.face);
}

TEST_F(MotionOfPlates, ChartsThatAreKeptLayThePatchesAlike) {
  const TwoPlates plates;
  manipulation::Motion motion = *heldTo(plates);
  const session::Document document = touching(plates);
  const MotionLayer layer(document, plates.hand, *plates.plate, motion);
  MotionPlaces(document, plates.hand, *plates.plate, motion).deal(motion);
  manipulation::MotionCharts charts;
  charts.uses_drafts = true;
  (void)layer.lay(motion, Progress(), {}, &charts);
  // Another place, then in full: what was kept must not show.
  const geometry::TriangleMesh& skin_S = plates.hand.skin->mesh();
  auto& placement = *motion.tracks[0].keys[0].placement;
  placement = transfer::movedTo(
      skin_S, placement,
      plates.hand.skin->locator()
          .nearest(positionOf(skin_S, placement.root_S) + Eigen::Vector3d(0.003, 0.0, 0.0))
          .point);
  charts.uses_drafts = false;
  const manipulation::TransferredMotion kept = layer.lay(motion, Progress(), {}, &charts);
  const manipulation::TransferredMotion anew = layer.lay(motion, Progress());
  ASSERT_EQ(kept.tracks.size(), anew.tracks.size());
  for (std::size_t t = 0; t < anew.tracks.size(); ++t)
    for (std::size_t i = 0; i < anew.tracks[t].spans.size(); ++i) {
      const auto& a = anew.tracks[t].spans[i].pairs;
      const auto& b = kept.tracks[t].spans[i].pairs;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t p = 0; p < a.size(); ++p)
        EXPECT_EQ(a[p].p_L, b[p].p_L);
    }
}

// `wrist` is a link of many hands: one that coincides says nothing of the others.
TEST_F(MotionOfPlates, PointsOfAnotherHandAreNotThisOnesForOneLinksName) {
  const TwoPlates plates;
  manipulation::Motion motion = *heldTo(plates);
  const char* const kLinks[] = {"plate", "index_tip_of_another_hand"};
  for (std::size_t t = 0; t < 2; ++t)
    for (manipulation::PatchKey& key : motion.tracks[t].keys)
      key.hand_points.assign(key.patch.interpolation_boundary.size(),
                             {kLinks[t], Eigen::Vector3d::Zero()});
  const session::Document document = touching(plates);
  const auto lay = [&] {
    return MotionLayer(document, plates.hand, *plates.plate, motion).lay(motion, Progress());
  };

  // Nothing else tells where they belong: what is known counts, and the rest is told.
  const manipulation::TransferredMotion laid = lay();
  EXPECT_EQ(laid.track_of, std::vector<int>{0});
  ASSERT_EQ(laid.notes.size(), 1U);
  EXPECT_NE(laid.notes[0].find("'index'"), std::string::npos) << laid.notes[0];

  // With places all are laid as another hand's patches are.
  for (manipulation::PatchTrack& track : motion.tracks)
    for (manipulation::PatchKey& key : track.keys)
      key.patch.place = hand::placeNamed("index_distal");
  EXPECT_EQ(lay().track_of, (std::vector<int>{0, 1}));
  EXPECT_TRUE(lay().tracks[0].spans[0].pairs[0].has_normals) << "of the skin";

  // All are this hand's: then its links say it, whatever the places.
  for (manipulation::PatchTrack& track : motion.tracks)
    for (manipulation::PatchKey& key : track.keys)
      for (manipulation::HandPoint& point : key.hand_points)
        point.link = "plate";
  EXPECT_EQ(lay().track_of, (std::vector<int>{0, 1}));
  EXPECT_FALSE(lay().tracks[0].spans[0].pairs[0].has_normals);
}

// Points of a demonstrator lie where their patches were found to lie, as areas do.
TEST_F(MotionOfPlates, PointsThatTellAPlaceLieWhereItWasFound) {
  const TwoPlates plates;
  manipulation::Motion motion = *heldTo(plates);
  for (manipulation::PatchTrack& track : motion.tracks)
    for (manipulation::PatchKey& key : track.keys) {
      key.patch.interpolation_boundary.resize(1);
      key.hand_points = {{"index_tip_of_another_hand", Eigen::Vector3d::Zero()}};
      key.patch.place = hand::placeNamed("index_distal");
    }
  const session::Document document = touching(plates);
  const MotionLayer layer(document, plates.hand, *plates.plate, motion);
  MotionPlaces(document, plates.hand, *plates.plate, motion).deal(motion);
  manipulation::PatchKey& key = motion.tracks[0].keys[0];
  ASSERT_TRUE(key.placement);
  const geometry::TriangleMesh& skin_S = plates.hand.skin->mesh();
  key.placement = transfer::movedTo(
      skin_S, *key.placement,
      plates.hand.skin->locator()
          .nearest(positionOf(skin_S, key.placement->root_S) + Eigen::Vector3d(0.003, 0.0, 0.0))
          .point);
  const hand::LinkPoint found = *plates.hand.skin->project(key.placement->root_S);
  const optimize::PointPair pair = layer.lay(motion, Progress()).tracks[0].spans[0].pairs[0];
  EXPECT_EQ(pair.link, found.link);
  EXPECT_EQ(pair.p_L, found.p_L);
}

// A hand of fewer fingers drops some; these must not pull at the finger of their own name,
// which may hold another one's contacts.
TEST_F(MotionOfPlates, PointsThatAreDroppedPullAtNoFinger) {
  const TwoPlates plates;
  const auto motion = std::make_shared<manipulation::Motion>(*heldTo(plates));
  for (manipulation::PatchTrack& track : motion->tracks)
    for (manipulation::PatchKey& key : track.keys) {
      key.patch.interpolation_boundary.resize(1);
      key.hand_points = {{"index_tip_of_another_hand", Eigen::Vector3d::Zero()}};
      key.patch.place = hand::placeNamed("index_distal");
    }
  session::Document document = touching(plates);
  document.notes = {"thumb's contacts go to the hand's index", "said twice", "said twice"};
  EditedMotion all(motion, plates.plate);
  EXPECT_EQ(solve(all, plates, document)->track_of, (std::vector<int>{0, 1}));
  document.patches[1].placement.reset();
  document.patches[1].dropped = "it has no such finger";
  EditedMotion fewer(motion, plates.plate);
  const auto solved = solve(fewer, plates, document);
  EXPECT_EQ(solved->track_of, std::vector<int>{0});
  const auto told = [&](const std::string& note) {
    return std::count(solved->notes.begin(), solved->notes.end(), note);
  };
  EXPECT_EQ(told("patch 'index' left out: it has no such finger"), 1);
  EXPECT_EQ(told("thumb's contacts go to the hand's index"), 1)
      << "as the grasp's matching said";
  EXPECT_EQ(told("said twice"), 1);
}

// Halfway between two fingers there is no finger: a patch goes from one and comes to the other.
TEST_F(MotionOfPlates, ARootFarAwayOnTheHandFadesOutAndIn) {
  TwoPlates plates;
  plates.hand.sites_are_found = false;  // nothing slides
  EditedMotion bench(heldTo(plates), plates.plate);
  session::Document document = touching(plates);
  const geometry::TriangleMesh& skin_S = plates.hand.skin->mesh();
  const Eigen::Vector3d old_S = positionOf(skin_S, document.patches[1].placement->root_S);
  const Eigen::Vector3d new_S = old_S + Eigen::Vector3d(0.0, 0.03, 0.0);
  session::Models models;
  models.hand = &plates.hand;
  models.object_O = plates.plate;
  const session::PatchRootEdit far{"index", session::Side::kHand,
                                   plates.hand.skin->locator().nearest(new_S).point};
  constexpr int kAt = 20;
  session::addTimed({{kAt / 120.0, 0.1}, far}, models, document);
  const auto solved = solve(bench, plates, document);
  const manipulation::FrameProblems frames(solved->problem, solved->solving.options.fade);
  const auto motion = heldTo(plates);
  const MotionFits fits(*motion, *solved);
  double least = 1.0;
  for (int k = 0; k < kFrames; ++k) {
    Eigen::Vector3d middle_S = Eigen::Vector3d::Zero();
    int count = 0;
    for (const optimize::PointPair& pair :
         frames.at(k, solved->trajectory.poses[static_cast<std::size_t>(k)]).pairs) {
      if (pair.patch != 1) continue;
      middle_S += pair.p_L;  // the rigid plate's link is its skin
      ++count;
    }
    double presence = 0.0;
    for (const PatchFrameFit& fit : fits.at(k))
      if (fit.patch == 1) presence = fit.presence;
    least = std::min(least, presence);
    if (count == 0) continue;
    middle_S /= count;
    const double off = std::min((middle_S - old_S).norm(), (middle_S - new_S).norm());
    EXPECT_LT(off, 3e-3) << "frame " << k;
    EXPECT_TRUE(k != kAt || (middle_S - new_S).norm() < 3e-3);
  }
  EXPECT_LT(least, 0.3);
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
