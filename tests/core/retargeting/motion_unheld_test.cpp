// What no contact holds goes as the demonstrator's hand does. The hand that demonstrates is the
// one that follows: where it goes is known.
#include "core/retargeting/motion_unheld.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/demonstration/shown_posture.h"
#include "core/hand/finger_coordinates.h"
#include "core/hand/turned_parts.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::retargeting {
namespace {

constexpr int kFrames = 180;
constexpr double kRate = 60.0;
constexpr int kTouches = 60;
constexpr int kLetsGo = 120;
constexpr double kAway = 0.1;   // m
constexpr double kOpen = 0.35;  // rad

/// From far to holding the ball, and away again.
class ReachingForABall : public testing::Test {
 protected:
  ReachingForABall() : session_(grasp_.open()) {
    session_.solve({}, {}, Progress());
    held_O_ = session_.solve({}, {}, Progress()).report.pose;
    const hand::Hand hand = grasp_.hand();
    const std::vector<hand::TurnedPart> parts =
        turnedParts(hand::coordinatesOf(hand)->anatomy());
    motion_.name = "reach";
    motion_.object = "ball";
    for (int k = 0; k < kFrames; ++k) {
      motion_.time_s.push_back(k / kRate);
      Pose X_WO = Pose::Identity();
      X_WO.translation().x() = 0.002 * k;
      motion_.X_WO.push_back(X_WO);
      if (isDemonstratorDue(motion_, k)) {
        hand::HandPose shown = shownAt(k);
        shown.X_WH = X_WO * shown.X_WH;
        motion_.demonstrator.push_back(demonstration::shownAt(k, hand, parts, shown, X_WO));
      }
    }
    for (const contact::Patch& patch : grasp_.contacts.patches) {
      manipulation::PatchTrack track;
      track.name = patch.name;
      track.end = kLetsGo;
      track.keys.resize(1);
      track.keys[0].frame = kTouches;
      track.keys[0].patch = patch;
      motion_.tracks.push_back(track);
    }
  }

  /// 1 far away, 0 holding.
  static double farness(int frame) {
    const double t = std::clamp(
        frame < kTouches ? (kTouches - 1 - frame) / 50.0 : (frame - kLetsGo) / 50.0, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  }

  /// In O: below the ball, its fingers open.
  [[nodiscard]] hand::HandPose shownAt(int frame) const {
    hand::HandPose pose = held_O_;
    pose.X_WH.translation().z() -= kAway * farness(frame);
    pose.q.array() -= kOpen * farness(frame);
    pose.q = pose.q.cwiseMax(grasp_.small.model->lower());
    return pose;
  }

  [[nodiscard]] SolvedMotion solved(int threads = 1) {
    return solveMotion(session_.document(), grasp_.hand(), grasp_.ball, motion_,
                       motionSolving(false), threads, Progress());
  }

  test::BallGrasp grasp_;
  session::Session session_;
  hand::HandPose held_O_;
  manipulation::Motion motion_;
};

TEST_F(ReachingForABall, TheHandComesAndGoesAsItIsShown) {
  const SolvedMotion answer = solved();
  double far = 0.0;
  for (int k = 0; k < kFrames; ++k) {
    const hand::HandPose& is = answer.trajectory.poses[static_cast<std::size_t>(k)];
    const hand::HandPose was = shownAt(k);
    EXPECT_LT((is.X_WH.translation() - was.X_WH.translation()).norm(), 0.006) << k;
    EXPECT_LT(vectorFromRotation(is.X_WH.linear() * was.X_WH.linear().transpose()).norm(), 0.1)
        << k;
    EXPECT_LT((is.q - was.q).cwiseAbs().maxCoeff(), 0.12) << k;
    far = std::max(far, (is.X_WH.translation() - held_O_.X_WH.translation()).norm());
  }
  EXPECT_GT(far, 0.9 * kAway);
}

TEST_F(ReachingForABall, WithoutADemonstratorTheHandStaysOverTheObject) {
  motion_.demonstrator.clear();
  const SolvedMotion answer = solved();
  for (const hand::HandPose& pose : answer.trajectory.poses)
    EXPECT_LT((pose.X_WH.translation() - held_O_.X_WH.translation()).norm(), 0.02);
}

// The middle finger comes a third of a second later than the others.
TEST_F(ReachingForABall, AFingerThatTouchesNothingYetIsHeldAsItIsShown) {
  motion_.tracks[2].keys[0].frame = kTouches + 20;
  motion_.demonstrator.clear();
  const hand::Hand hand = grasp_.hand();
  const std::vector<hand::TurnedPart> parts = turnedParts(hand::coordinatesOf(hand)->anatomy());
  const std::vector<int> of_middle = {4, 5};
  const auto shown_at = [&](int k) {
    hand::HandPose shown = held_O_;
    if (k < kTouches + 10) {
      for (const int joint : of_middle)
        shown.q[joint] -= kOpen;
    }
    return shown;
  };
  for (int k = 0; k < kFrames; ++k) {
    if (!isDemonstratorDue(motion_, k)) continue;
    hand::HandPose shown = shown_at(k);
    const Pose& X_WO = motion_.X_WO[static_cast<std::size_t>(k)];
    shown.X_WH = X_WO * shown.X_WH;
    motion_.demonstrator.push_back(demonstration::shownAt(k, hand, parts, shown, X_WO));
  }
  const SolvedMotion answer = solved();
  const hand::HandPose& open = answer.trajectory.poses[kTouches];
  for (const int joint : of_middle)
    EXPECT_NEAR(open.q[joint], shown_at(kTouches).q[joint], 0.12) << joint;
  EXPECT_TRUE(MotionFits(motion_, answer).at(kTouches)[0].reached);
}

// A finger that brushes the object on the way leaves the hand where it is shown.
TEST_F(ReachingForABall, WhatGrazesHoldsNoHand) {
  manipulation::PatchTrack graze = motion_.tracks[0];
  graze.keys[0].frame = 20;
  graze.end = 28;
  motion_.tracks.insert(motion_.tracks.begin(), graze);
  const SolvedMotion answer = solved();
  for (const int k : {0, 10, 40, 50}) {
    const hand::HandPose& is = answer.trajectory.poses[static_cast<std::size_t>(k)];
    const hand::HandPose was = shownAt(k);
    EXPECT_LT((is.X_WH.translation() - was.X_WH.translation()).norm(), 0.015) << k;
    EXPECT_LT(vectorFromRotation(is.X_WH.linear() * was.X_WH.linear().transpose()).norm(), 0.2)
        << k;
  }
}

// What a single touch leaves open is decided by that.
TEST_F(ReachingForABall, PrefersToBeTurnedAsItIsShown) {
  const hand::Hand hand = grasp_.hand();
  manipulation::MotionProblem problem =
      motionProblemOf(session_.document(), hand, motion_.time_s, motionSolving(false));
  turnAlike(hand, motion_, problem);
  ASSERT_EQ(problem.turns.size(), motion_.time_s.size());
  const manipulation::FrameProblems frames(problem, {});
  hand::HandPose rest;
  rest.q = problem.prior;
  for (int k = 0; k < kFrames; k += 30) {
    const optimize::PoseProblem single = frames.at(k, rest);
    EXPECT_GT(single.prior_weights[0] * single.weights.prior, 0.0);
    EXPECT_EQ(single.prior_weights[3], 0.0) << "not where it is";
    const Eigen::Matrix3d off =
        single.prior.X_WH.linear() * shownAt(k).X_WH.linear().transpose();
    EXPECT_LT(vectorFromRotation(off).norm(), 0.1) << k;
  }
  motion_.demonstrator.clear();
  problem.turns.clear();
  turnAlike(hand, motion_, problem);
  EXPECT_TRUE(problem.turns.empty());
}

TEST_F(ReachingForABall, IsTheSameOnTwoThreads) {
  const SolvedMotion one = solved(1);
  const SolvedMotion two = solved(2);
  for (std::size_t k = 0; k < kFrames; ++k) {
    EXPECT_EQ(one.trajectory.poses[k].q, two.trajectory.poses[k].q);
    EXPECT_EQ(one.trajectory.poses[k].X_WH.matrix(), two.trajectory.poses[k].X_WH.matrix());
  }
}

TEST_F(ReachingForABall, AJointThatIsLockedStaysSo) {
  session::Document document = session_.document();
  document.joints[1].locked = true;
  const double locked = document.start.q[1];
  const SolvedMotion answer = solveMotion(document, grasp_.hand(), grasp_.ball, motion_,
                                          motionSolving(false), 1, Progress());
  for (const hand::HandPose& pose : answer.trajectory.poses)
    EXPECT_NEAR(pose.q[1], locked, 1e-9);
}

}  // namespace
}  // namespace handgraft::retargeting
