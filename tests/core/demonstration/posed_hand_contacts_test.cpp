#include "core/demonstration/posed_hand_contacts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/demonstration/posed_hand_motion.h"

#include "tests/core/demonstration/small_hand_about_a_box.h"
#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::demonstration {
namespace {

TEST(PosedSurfaces, StandWhereThePosePutsThemSeenFromTheObject) {
  const auto hand = test::makeRigidHand(test::makePlate(2, 2, 0.01));
  hand::HandPose pose;
  pose.q = Eigen::VectorXd(0);
  pose.X_WH.translate(Eigen::Vector3d(0.1, 0.2, 0.3));
  Pose X_WO = Pose::Identity();
  X_WO.translate(Eigen::Vector3d(0.0, 0.2, 0.3));
  X_WO.rotate(Eigen::AngleAxisd(0.5 * 3.14159265358979323846, Eigen::Vector3d::UnitZ()));
  const auto parts = posedSurfaces(*hand, pose, X_WO);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].name, "plate");
  // The link's origin, the plate's middle vertex, lies 0.1 m along the world's x: -y of O.
  EXPECT_LT((parts[0].mesh_O.vertex(4) - Eigen::Vector3d(0.0, -0.1, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(parts[0].mesh_O.area(), 4e-4, 1e-12);
}

TEST(PosedSurfaces, LeaveOutLinksWithoutOne) {
  hand::Link bare;
  bare.name = "frame";
  const hand::HandModel hand("bare", {bare}, {});
  EXPECT_TRUE(
      posedSurfaces(hand, {Pose::Identity(), Eigen::VectorXd(0)}, Pose::Identity()).empty());
}

TEST_F(SmallHandAboutABox, LeavesAPatchOfEachFingerWhereItTouches) {
  const PosedContacts found = contacts();
  ASSERT_EQ(found.set.patches.size(), 6u);  // with the lower links, 3 mm off the box
  const std::map<std::string, Eigen::Vector3d> expected{
      {"thumb_distal", {-0.031, 0.0, 0.0}},
      {"index_distal", {0.031, 0.015, 0.0}},
      {"middle_distal", {0.031, -0.015, 0.0}}};
  for (const auto& [name, p_O] : expected) {
    const contact::Patch& patch = patchOf(found, name);
    EXPECT_NO_THROW(contact::validate(box_O_, patch));
    EXPECT_LT((positionOf(box_O_, patch.root) - p_O).norm(), 0.004) << name;
    ASSERT_TRUE(patch.direction_O.has_value()) << name;
    EXPECT_GT(-patch.direction_O->z(), 0.99) << name;
    // On the pad: where the finger closes to, half way round no side.
    ASSERT_TRUE(patch.place.has_value()) << name;
    EXPECT_EQ(hand::partName(patch.place->digit, patch.place->segment), name);
    EXPECT_NEAR(patch.place->around_rad, 0.0, 0.3) << name;
    // A ball of 10 mm that reaches 1 mm in is at the threshold, 3.6 mm less deep, 8.8 mm away.
    for (const geometry::SurfacePoint& point : patch.interpolation_boundary)
      EXPECT_NEAR((positionOf(box_O_, point) - p_O).norm(), 0.0088, 0.003) << name;
  }
}

TEST_F(SmallHandAboutABox, IsFollowedFromWhereItBeginsToTouchUntilItDoesNot) {
  // At 20 Hz: there at frames 3 to 9 but for 6, and once more at frame 14 alone.
  std::vector<PosedFrame> frames;
  for (int k = 0; k < 16; ++k) {
    PosedFrame frame{0.05 * k, pose, X_WO_};
    const bool touches = (k >= 3 && k <= 9 && k != 6) || k == 14;
    if (!touches) frame.pose.X_WH.translation().z() += 0.5;
    frames.push_back(frame);
  }
  const manipulation::Motion motion =
      motionOfPosedHand(hand(), frames, box_O_, PosedMotionOptions(), Progress());
  EXPECT_EQ(motion.frameCount(), 16);
  ASSERT_FALSE(motion.tracks.empty());
  for (const manipulation::PatchTrack& track : motion.tracks) {
    EXPECT_EQ(track.begin(), 3) << track.name;
    EXPECT_EQ(track.end, 10) << track.name;
    EXPECT_EQ(track.keys.size(), 6u) << track.name;
    EXPECT_TRUE(track.keys.front().patch.place.has_value()) << track.name;
  }
  EXPECT_THAT(motion.notes, testing::ElementsAre(testing::HasSubstr("there for 50 ms alone")));
  // Its way is known in all of them.
  ASSERT_EQ(motion.demonstrator.size(), 16u);
  const Pose went = motion.demonstrator[3].X_OD * inverse(motion.demonstrator[2].X_OD);
  EXPECT_NEAR(
      (motion.demonstrator[3].X_OD.translation() - motion.demonstrator[2].X_OD.translation())
          .norm(),
      0.5, 1e-9);
  EXPECT_LT(vectorFromRotation(went.linear()).norm(), 1e-9);
  EXPECT_EQ(motion.demonstrator[3].posture.size(), contacts().set.posture.size());

  // Cut half as often, each cut holds for two frames.
  PosedMotionOptions seldom;
  seldom.every_s = 0.1;
  frames.resize(10);
  const manipulation::Motion rougher =
      motionOfPosedHand(hand(), frames, box_O_, seldom, Progress());
  EXPECT_EQ(rougher.tracks.front().begin(), 4);
  EXPECT_EQ(rougher.tracks.front().end, 10);
  EXPECT_EQ(rougher.tracks.front().keys.size(), 2u);
}

TEST_F(SmallHandAboutABox, ThatNeverTouchesIsNoMotion) {
  std::vector<PosedFrame> frames{{0.0, pose, X_WO_}};
  frames[0].pose.X_WH.translation().z() += 0.5;
  EXPECT_THROW((void)motionOfPosedHand(hand(), frames, box_O_, {}, Progress()), InvalidInput);
  frames.push_back(frames[0]);
  EXPECT_THROW((void)motionOfPosedHand(hand(), frames, box_O_, {}, Progress()), InvalidInput);
  EXPECT_THROW((void)motionOfPosedHand(hand(), {}, box_O_, {}, Progress()), InvalidInput);
}

TEST_F(SmallHandAboutABox, NamesPatchesLikeTheSitesOfTheirFingers) {
  small.sites[1].name = "f7";
  const PosedContacts found = contacts();
  std::vector<std::string> names;
  for (const contact::Patch& patch : found.set.patches)
    names.push_back(patch.name);
  EXPECT_THAT(names, testing::ElementsAre("thumb_proximal", "thumb_distal", "middle_proximal",
                                          "middle_distal", "f7_proximal", "f7_distal"));
}

TEST_F(SmallHandAboutABox, TellsFingersThatTouchTooLittle) {
  contact::SegmentationOptions segmentation;
  segmentation.minimum_area_m2 = 5e-5;
  const auto notes_at = [&](double opening) {
    pose.q[2] = -opening;  // index_1
    return contactsOfPosedHand(hand(), pose, box_O_, X_WO_, {}, segmentation, Progress())
        .set.notes;
  };
  EXPECT_THAT(notes_at(0.125),
              testing::Contains(testing::ContainsRegex(
                  "'index' touches too little: [0-9.]+ mm2 in all; a patch has "
                  "50.0 mm2")));
  EXPECT_THAT(notes_at(0.125), testing::Not(testing::Contains("touches nothing: index")));
  EXPECT_THAT(notes_at(0.2), testing::Contains("touches nothing: index"));
}

TEST_F(SmallHandAboutABox, KeepsTheMapItWasFoundIn) {
  const contact::ContactMap map = contacts().map;
  EXPECT_NO_THROW(contact::validate(map));
  EXPECT_GT(map.mesh_O.vertexCount(), box_O_.vertexCount());  // 12 faces show no patch
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    const Eigen::Vector3d p_O = map.mesh_O.vertex(v);
    // On the sides where fingers are, the distance to the nearest tip's ball.
    if (std::abs(p_O.x()) < 0.0309) continue;
    const Eigen::Vector3d thumb(-0.04, 0.0, 0.0);
    const Eigen::Vector3d index(0.04, 0.015, 0.0);
    const Eigen::Vector3d middle(0.04, -0.015, 0.0);
    const double distance =
        std::min({(p_O - thumb).norm(), (p_O - index).norm(), (p_O - middle).norm()}) - 0.010;
    const double expected = std::clamp(1.0 - (0.001 + distance) / 0.006, 0.0, 1.0);
    if (p_O.z() > -0.005) {
      EXPECT_NEAR(map.value[v], expected, 0.05) << p_O.transpose();
    }
  }
}

TEST_F(SmallHandAboutABox, SaysHowFarAHandIsThatTouchesNothing) {
  X_WO_.translate(Eigen::Vector3d(0.0, 0.0, 0.14));  // 10 + 30 mm above the tips' tops
  EXPECT_THAT(
      [&] {
        (void)contacts();
      },
      testing::ThrowsMessage<InvalidInput>(testing::HasSubstr("touches nothing")));
  EXPECT_THAT(
      [&] {
        (void)contacts();
      },
      testing::ThrowsMessage<InvalidInput>(testing::HasSubstr("100 mm")));
}

TEST_F(SmallHandAboutABox, StopsOnWish) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(contactsOfPosedHand(hand(), pose, box_O_, X_WO_, {}, {}, progress), Cancelled);
}

}  // namespace
}  // namespace handgraft::demonstration
