#include "core/manipulation/contact_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/mano_joints.h"

namespace handgraft::manipulation {
namespace {

using hand::HandSide;
using hand::JointPlaces;
using hand::manoJointPlaces;
using testing::HasSubstr;

using ManoPose = Eigen::Matrix<double, hand::kManoPoseSize, 1>;

/// A flat box; its upper face at y = 0 where `y_m` is 0, the rest below.
geometry::TriangleMesh slab(double y_m) {
  Eigen::Matrix3Xd vertices(3, 8);
  Eigen::Matrix3Xi faces(3, 12);
  const double x = 0.4, z = 0.4, thick = 0.1;
  vertices << -x, x, x, -x, -x, x, x, -x,                                      //
      y_m - thick, y_m - thick, y_m - thick, y_m - thick, y_m, y_m, y_m, y_m,  //
      -z, -z, z, z, -z, -z, z, z;
  faces << 0, 0, 4, 4, 0, 0, 1, 1, 2, 2, 3, 3,  //
      1, 2, 6, 7, 4, 5, 5, 6, 6, 7, 7, 4,       //
      2, 3, 5, 6, 5, 1, 6, 2, 7, 3, 4, 0;
  return geometry::TriangleMesh(vertices, faces);
}

DemonstratedFrame frameOf(const ManoPose& pose, double time_s = 0.0) {
  DemonstratedFrame frame;
  frame.time_s = time_s;
  frame.joints_W = manoJointPlaces(pose, Eigen::Vector3d::Zero(), HandSide::kRight);
  return frame;
}

// === MANO's joints

TEST(ManoJoints, HaveTheirBonesWhateverThePose) {
  const ManoPose rest = ManoPose::Zero();
  ManoPose pose = 0.3 * ManoPose::Ones();
  const JointPlaces a = manoJointPlaces(rest, Eigen::Vector3d::Zero(), HandSide::kRight);
  const JointPlaces b = manoJointPlaces(pose, {1, 2, 3}, HandSide::kRight);
  for (int digit = 0; digit < 5; ++digit) {
    for (int joint = 1; joint < 4; ++joint) {
      const int at = 1 + 4 * digit + joint;
      EXPECT_NEAR((a.col(at) - a.col(at - 1)).norm(), (b.col(at) - b.col(at - 1)).norm(),
                  1e-12);
    }
  }
  EXPECT_LT(a(0, 8), a(0, 7)) << "fingers lie to -x";
}

TEST(ManoJoints, ARootTurnsAllAndAJointWhatLiesBehindIt) {
  ManoPose turned = ManoPose::Zero();
  turned[1] = std::numbers::pi / 2;
  const JointPlaces a =
      manoJointPlaces(ManoPose::Zero(), Eigen::Vector3d::Zero(), HandSide::kRight);
  const JointPlaces b = manoJointPlaces(turned, Eigen::Vector3d::Zero(), HandSide::kRight);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_LT((b.colwise() - b.col(0) - R * (a.colwise() - a.col(0))).norm(), 1e-12);
  ManoPose bent = ManoPose::Zero();
  bent[3 + 3 + 2] = 1.0;  // the index' second joint, about z
  const JointPlaces c = manoJointPlaces(bent, Eigen::Vector3d::Zero(), HandSide::kRight);
  for (int joint = 0; joint < 21; ++joint) {
    const bool is_behind = joint == 7 || joint == 8;
    EXPECT_EQ((c.col(joint) - a.col(joint)).norm() > 1e-6, is_behind) << joint;
  }
  EXPECT_LT(c(1, 8), a(1, 8)) << "it bends to the palm";
}

TEST(ManoJoints, ALeftHandIsTheMirrorOfARightOne) {
  const JointPlaces right =
      manoJointPlaces(ManoPose::Zero(), Eigen::Vector3d::Zero(), HandSide::kRight);
  JointPlaces left =
      manoJointPlaces(ManoPose::Zero(), Eigen::Vector3d::Zero(), HandSide::kLeft);
  left.row(0) *= -1;
  EXPECT_LT((left - right).norm(), 1e-12);
}

// === Touches

TEST(ContactTracker, AHandFlatOnATableTouchesWithItsPalmarSide) {
  const geometry::TriangleMesh table = slab(-0.014);
  ContactTracker tracker(table);
  const std::vector<DetectedContact> touches = tracker.see(frameOf(ManoPose::Zero()));
  ASSERT_GE(touches.size(), 8u);
  for (const DetectedContact& touch : touches) {
    EXPECT_NEAR(positionOf(table, touch.point_O).y(), -0.014, 1e-9);
    if (touch.place.digit == "palm" || touch.place.digit == "thumb") continue;
    EXPECT_NEAR(touch.place.around_rad, 0.0, 0.5)
        << ContactTracker::partNames()[static_cast<std::size_t>(touch.part)];
  }
}

// Cameras see a hand in what it holds as easily as beside it.
TEST(ContactTracker, BonesMeasuredInsideTheTableTouchWithTheSameSide) {
  const DemonstratedFrame frame = frameOf(ManoPose::Zero());
  const double lowest = frame.joints_W.row(1).minCoeff();
  const double highest = frame.joints_W.row(1).maxCoeff();
  for (const double inside_m : {-0.004, 0.0, 0.004}) {
    const geometry::TriangleMesh table = slab(lowest + inside_m);
    const auto outside = ContactTracker(table).see(frame);
    const geometry::TriangleMesh above = slab(highest + inside_m + 0.1);
    for (const DetectedContact& touch : outside)
      EXPECT_LT(std::abs(touch.place.around_rad), std::numbers::pi / 2)
          << ContactTracker::partNames()[static_cast<std::size_t>(touch.part)] << ", "
          << inside_m;
    for (const DetectedContact& touch : ContactTracker(above).see(frame))
      EXPECT_TRUE(touch.place.digit == hand::kPalmPart || touch.place.digit == "thumb" ||
                  std::abs(touch.place.around_rad) > std::numbers::pi / 2)
          << "the box's lower face, which the back touches";
  }
}

TEST(ContactTracker, FromBehindItTouchesWithItsBack) {
  // The same table above the hand.
  const geometry::TriangleMesh table = slab(0.116);
  ContactTracker tracker(table);
  int backs = 0;
  for (const DetectedContact& touch : tracker.see(frameOf(ManoPose::Zero()))) {
    if (touch.place.digit != "middle") continue;
    ++backs;
    EXPECT_GT(std::abs(touch.place.around_rad), 2.6);
  }
  EXPECT_GT(backs, 0);
}

TEST(ContactTracker, ALeftHandTouchesWithItsPalmToo) {
  const geometry::TriangleMesh table = slab(-0.006);
  ContactTracker tracker(table);
  DemonstratedFrame frame = frameOf(ManoPose::Zero());
  frame.side = HandSide::kLeft;
  frame.joints_W = manoJointPlaces(ManoPose::Zero(), Eigen::Vector3d::Zero(), HandSide::kLeft);
  int fingers = 0;
  for (const DetectedContact& touch : tracker.see(frame)) {
    if (touch.place.digit != "middle" && touch.place.digit != "ring") continue;
    ++fingers;
    EXPECT_NEAR(touch.place.around_rad, 0.0, 0.5);
  }
  EXPECT_GT(fingers, 2);
}

TEST(ContactTracker, WhatTouchesStaysUntilItIsClearlyAway) {
  const geometry::TriangleMesh table = slab(0.0);
  const auto count_at = [&](ContactTracker& tracker, double height_m) {
    DemonstratedFrame frame = frameOf(ManoPose::Zero());
    frame.X_WO.translation().y() = -height_m;
    return tracker.see(frame).size();
  };
  ContactTracker fresh(table), known(table);
  const std::size_t near = count_at(known, 0.012);
  const std::size_t begun = count_at(fresh, 0.018);
  EXPECT_GT(near, begun);
  EXPECT_GT(count_at(known, 0.018), begun);
  EXPECT_EQ(count_at(known, 0.1), 0u);
}

TEST(ContactTracker, WhatIsNotFiniteIsRefused) {
  const geometry::TriangleMesh table = slab(0.0);
  ContactTracker tracker(table);
  DemonstratedFrame frame = frameOf(ManoPose::Zero());
  frame.joints_W(1, 4) = std::nan("");
  EXPECT_THROW(tracker.see(frame), InvalidInput);
}

// === A whole demonstration

TEST(MotionOfDemonstration, TracksBeginAndEndWithTheTouch) {
  const geometry::TriangleMesh table = slab(0.0);
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 60; ++k) {
    DemonstratedFrame frame = frameOf(ManoPose::Zero(), k / 60.0);
    // Down, along the table and up again.
    const double height = std::max(0.01, 0.002 * std::abs(k - 30.0));
    frame.X_WO.translation() = Eigen::Vector3d(0.001 * k, -height, 0.0);
    frames.push_back(frame);
  }
  const Motion motion = motionOfDemonstration(frames, table);
  EXPECT_EQ(motion.frameCount(), 60);
  ASSERT_EQ(motion.demonstrator.size(), 20u) << "each 40 ms, of 60 frames a second: 50 ms";
  for (const DemonstratorKey& key : motion.demonstrator) {
    const DemonstratedFrame& frame = frames[static_cast<std::size_t>(key.frame)];
    EXPECT_TRUE(key.X_OD.isApprox(palmOf(frame).value(), 1e-9));
    EXPECT_EQ(key.posture.size(), postureOf(frame).size());
  }
  ASSERT_GT(motion.tracks.size(), 5u);
  for (const PatchTrack& track : motion.tracks) {
    EXPECT_GT(track.begin(), 0);
    EXPECT_LT(track.end, 60);
    EXPECT_TRUE(track.keys.front().patch.place.has_value());
    EXPECT_GT(track.keys.size(), 3u) << "it slides";
  }
}

// Knuckles in one line tell no palm: such a hand touches, but nothing goes as it goes.
TEST(MotionOfDemonstration, AHandWithoutAPalmIsNoDemonstratorOfWays) {
  const geometry::TriangleMesh table = slab(0.0);
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 60; ++k) {
    DemonstratedFrame frame = frameOf(ManoPose::Zero(), k / 60.0);
    for (int joint = 1; joint < 21; ++joint)
      frame.joints_W.col(joint).tail<2>() = frame.joints_W.col(0).tail<2>();
    frame.X_WO.translation().y() = frame.joints_W(1, 0) - 0.005;
    frames.push_back(frame);
  }
  EXPECT_FALSE(palmOf(frames.front()));
  EXPECT_FALSE(shownBy(frames.front()).X_OD);
  EXPECT_TRUE(motionOfDemonstration(frames, table).demonstrator.empty());
}

// A hand that rests is one grasp, however its joints are measured.
TEST(MotionOfDemonstration, NoiseMovesNoTouch) {
  const geometry::TriangleMesh table = slab(-0.012);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 240; ++k) {
    frames.push_back(frameOf(ManoPose::Zero(), k / 60.0));
    for (double& coordinate : frames.back().joints_W.reshaped())
      coordinate += noise(random);
  }
  const Motion motion = motionOfDemonstration(frames, table);
  EXPECT_THAT(motion.notes, testing::Contains(HasSubstr("some 2.0 mm of noise")));
  std::size_t keys = 0;
  for (const PatchTrack& track : motion.tracks)
    keys += track.keys.size();
  ASSERT_GE(motion.tracks.size(), 8u);
  EXPECT_LT(keys, 3 * motion.tracks.size());
}

TEST(MotionOfDemonstration, LeavesOutGlitchesAndTellsJointsInsideTheObject) {
  const geometry::TriangleMesh table = slab(0.0);
  std::vector<DemonstratedFrame> frames;
  for (int k = 0; k < 60; ++k) {
    frames.push_back(frameOf(ManoPose::Zero(), k / 60.0));
    frames.back().X_WO.translation().y() = k < 30 ? -0.01 : 0.012;
  }
  frames[10].joints_W.setZero();
  const Motion motion = motionOfDemonstration(frames, table);
  EXPECT_EQ(motion.frameCount(), 59);
  EXPECT_THAT(motion.notes,
              testing::ElementsAre(
                  HasSubstr("left out 1 of 60 frames: at 0.167 s"),
                  testing::ContainsRegex("joints lie up to 3[0-9] mm inside the object, in "
                                         "30 of 59 frames more than 20: is it that object")));
}

TEST(MotionOfDemonstration, SaysWhatIsWrong) {
  const geometry::TriangleMesh table = slab(-1.0);
  const auto objection = [&](const std::vector<DemonstratedFrame>& frames) -> std::string {
    try {
      motionOfDemonstration(frames, table);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  const DemonstratedFrame frame = frameOf(ManoPose::Zero());
  EXPECT_THAT(objection({}), HasSubstr("without frames"));
  EXPECT_THAT(objection({frame}), HasSubstr("touches nothing: its joints come no nearer than"));
  EXPECT_THAT(objection({frame, frame}), HasSubstr("does not lie behind"));
  DemonstratedFrame in_mm = frame;
  in_mm.X_WO.translation().x() = 500.0;
  EXPECT_THAT(objection({in_mm}), HasSubstr("both in metres?"));
  EXPECT_THAT(objection({frame}), testing::Not(HasSubstr("both in metres?")));
}

}  // namespace
}  // namespace handgraft::manipulation
