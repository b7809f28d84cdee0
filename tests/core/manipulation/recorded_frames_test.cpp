#include "core/manipulation/recorded_frames.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/mano_joints.h"

namespace handgraft::manipulation {
namespace {

using hand::HandSide;
using hand::JointPlaces;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using ManoPose = Eigen::Matrix<double, hand::kManoPoseSize, 1>;

/// MANO's mean hand with its fingers bent at all joints (rad).
JointPlaces bentHand(double bend_rad, HandSide side = HandSide::kRight) {
  ManoPose pose = ManoPose::Zero();
  for (int entry = 3; entry < 39; entry += 3)
    pose[entry + 2] = side == HandSide::kRight ? bend_rad : -bend_rad;
  return hand::manoJointPlaces(pose, {0.1, 0.2, 0.3}, side);
}

std::string faultOf(const JointPlaces& joints, HandSide side = HandSide::kRight) {
  try {
    hand::requireHand(joints, side);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// 60 frames a second; hand and object stand still.
std::vector<DemonstratedFrame> framesOf(const JointPlaces& joints, int count = 60) {
  std::vector<DemonstratedFrame> frames(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].time_s = static_cast<double>(k) / 60.0;
    frames[k].joints_W = joints;
  }
  return frames;
}

std::string objectionTo(std::vector<DemonstratedFrame> frames) {
  try {
    (void)withoutGlitches(std::move(frames));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

// === A hand

TEST(RequireHand, TakesHandsOfAnySizeWithNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.003);
  for (const double size : {0.7, 0.85, 1.0, 1.25}) {
    for (const double bend : {0.0, 0.3, 0.6, 0.9}) {
      for (const HandSide side : {HandSide::kRight, HandSide::kLeft}) {
        for (int draw = 0; draw < 50; ++draw) {
          JointPlaces joints = size * bentHand(bend, side);
          for (double& number : joints.reshaped())
            number += noise(random);
          EXPECT_EQ(faultOf(joints, side), "") << size << ' ' << bend;
        }
      }
    }
  }
}

TEST(RequireHand, TellsTheOrderThatJointsSeemToStandIn) {
  const auto ordered = [](const std::array<int, 21>& joint_of) {
    const JointPlaces ours = bentHand(0.5);
    JointPlaces joints;
    for (int column = 0; column < joints.cols(); ++column)
      joints.col(column) = ours.col(joint_of[static_cast<std::size_t>(column)]);
    return faultOf(joints);
  };
  EXPECT_THAT(
      ordered({0, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17}),
      AllOf(HasSubstr("another order, each digit's tip first"),
            HasSubstr("it must be the wrist, then thumb, index")));
  EXPECT_THAT(
      ordered({0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 1, 2, 3, 4}),
      HasSubstr("another order, the thumb last;"));
  EXPECT_THAT(
      ordered({0, 5, 6, 7, 9, 10, 11, 17, 18, 19, 13, 14, 15, 1, 2, 3, 4, 8, 12, 16, 20}),
      HasSubstr("MANO's order"));
  EXPECT_THAT(
      ordered({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 0}),
      HasSubstr("the wrist last"));
}

TEST(RequireHand, RefusesOtherUnitsAndWhatIsNoPlace) {
  const JointPlaces joints = bentHand(0.5);
  EXPECT_THAT(faultOf(1e3 * joints), HasSubstr("millimetres?"));
  EXPECT_THAT(faultOf(1e2 * joints), HasSubstr("centimetres?"));
  EXPECT_THAT(faultOf(0.0 * joints), HasSubstr("a hand has 0.05 to 0.5"));
  EXPECT_THAT(faultOf(std::nan("") * joints), HasSubstr("not finite"));
}

TEST(RequireHand, RefusesATipThatIsElsewhere) {
  JointPlaces joints = bentHand(0.5);
  joints.col(8).x() -= 0.1;
  EXPECT_THAT(faultOf(joints),
              AllOf(HasSubstr("joints 7 and 8, of the index finger"), HasSubstr("permitted")));
}

TEST(RequireHand, RefusesTheOtherSidesHandOnceItIsBent) {
  EXPECT_THAT(faultOf(bentHand(0.5), HandSide::kLeft),
              AllOf(HasSubstr("bend backwards by"), HasSubstr("a right hand, or mirrored?")));
  JointPlaces mirrored = bentHand(0.5);
  mirrored.row(0) *= -1.0;
  EXPECT_THAT(faultOf(mirrored), HasSubstr("is it a left hand"));
  EXPECT_EQ(faultOf(mirrored, HandSide::kLeft), "");
  EXPECT_EQ(faultOf(bentHand(0.0), HandSide::kLeft), "") << "a flat hand tells nothing";
}

TEST(ManoPose, IsNotInDegrees) {
  ManoPose pose = ManoPose::Zero();
  pose[3 + 2] = 35.0;
  try {
    (void)hand::manoJointPlaces(pose, Eigen::Vector3d::Zero(), HandSide::kRight);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("joint 1 turns by 35 rad"), HasSubstr("degrees?")));
  }
}

// === A recording

TEST(WithoutGlitches, KeepsWhatIsRight) {
  std::vector<DemonstratedFrame> frames = framesOf(bentHand(0.5));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Eigen::Vector3d way(0.04 * static_cast<double>(k), 0.0, 0.0);  // 2.4 m/s
    frames[k].joints_W.colwise() += way;
    frames[k].X_WO.translation() = way;
  }
  frames.back().joints_W.colwise() += Eigen::Vector3d::UnitY();  // and never back
  const RecordedFrames recorded = withoutGlitches(frames);
  EXPECT_EQ(recorded.frames.size(), 60u);
  EXPECT_THAT(recorded.notes, IsEmpty());
}

TEST(WithoutGlitches, LeavesOutFramesThatShowNoHandOrLeap) {
  std::vector<DemonstratedFrame> frames = framesOf(bentHand(0.5));
  frames[12].joints_W.setZero();
  EXPECT_THAT(withoutGlitches(frames).notes,
              ElementsAre(AllOf(HasSubstr("left out 1 of 60 frames: at 0.200 s"),
                                HasSubstr("to its tip 0 m"))));
  frames[6].joints_W.colwise() += Eigen::Vector3d(0.2, 0.0, 0.0);
  frames[7].joints_W.colwise() += Eigen::Vector3d(0.2, 0.0, 0.0);
  frames[30].X_WO.translation().z() = 0.5;
  const RecordedFrames recorded = withoutGlitches(frames);
  EXPECT_EQ(recorded.frames.size(), 56u);
  EXPECT_THAT(recorded.notes,
              ElementsAre(AllOf(HasSubstr("left out 4 of 60 frames, the first: at 0.100 s"),
                                HasSubstr("the hand leaps by 200 mm and comes back"))));
  for (const DemonstratedFrame& frame : recorded.frames) {
    EXPECT_TRUE(frame.joints_W.isApprox(bentHand(0.5)));
    EXPECT_EQ(frame.X_WO.translation().z(), 0.0);
  }
}

TEST(WithoutGlitches, ARecordingThatIsWrongThroughoutIsRefused) {
  EXPECT_THAT(
      objectionTo(framesOf(1e3 * bentHand(0.5))),
      AllOf(HasSubstr("60 of 60 frames show no hand; at 0.000 s"), HasSubstr("millimetres?")));
  // Too little in any one frame to tell, but not in all of them.
  const JointPlaces mirrored = Eigen::Vector3d(-1, 1, 1).asDiagonal() * bentHand(0.15);
  EXPECT_EQ(faultOf(mirrored), "");
  EXPECT_THAT(objectionTo(framesOf(mirrored)),
              AllOf(HasSubstr("bend backwards"), HasSubstr("in the mean: is it a left hand")));
}

}  // namespace
}  // namespace handgraft::manipulation
