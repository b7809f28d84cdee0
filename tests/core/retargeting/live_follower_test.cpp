#include "core/retargeting/live_follower.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/demonstration/posed_hand_tracker.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/mano_joints.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/library_models.h"

namespace handgraft::retargeting {
namespace {

using manipulation::DemonstratedFrame;

/// A hand whose fingers, more and more bent, have the ball between them and the palm.
DemonstratedFrame grip(double time_s, double bend_rad, double away_m = 0.0) {
  Eigen::Matrix<double, hand::kManoPoseSize, 1> pose;
  pose.setZero();
  for (int joint = 0; joint < 12; ++joint)
    pose[3 + 3 * joint + 2] = bend_rad;
  DemonstratedFrame frame;
  frame.time_s = time_s;
  frame.joints_W = hand::manoJointPlaces(pose, Eigen::Vector3d::Zero(), hand::HandSide::kRight);
  // The ball's middle lies before the knuckles, below the palm.
  frame.X_WO.translation() = Eigen::Vector3d(-0.01, -0.045 - away_m, -0.01);
  return frame;
}

double meanDistance(const LiveFollower::Answer& answer) {
  double sum_mm = 0.0;
  for (const LiveFollower::PartFit& fit : answer.parts)
    sum_mm += fit.distance_mm;
  return sum_mm / static_cast<double>(std::max<std::size_t>(1, answer.parts.size()));
}

bool isOf(const std::string& digit, int part) {
  return manipulation::ContactTracker::partNames()[static_cast<std::size_t>(part)].rfind(
             digit, 0) == 0;
}

std::vector<manipulation::DetectedContact> without(
    const std::string& digit, std::vector<manipulation::DetectedContact> touches) {
  std::erase_if(touches, [&](const manipulation::DetectedContact& touch) {
    return isOf(digit, touch.part);
  });
  return touches;
}

class LiveFollowing : public testing::Test {
 protected:
  LiveFollowing() : session(grasp.open()) {}

  std::unique_ptr<LiveFollower> follower() {
    return std::make_unique<LiveFollower>(session.document(), grasp.hand(), grasp.ball,
                                          Progress());
  }

  test::BallGrasp grasp;
  session::Session session;
};

TEST_F(LiveFollowing, BeginsWithTheFirstTouchAndIsTheSameAgain) {
  std::vector<Eigen::VectorXd> ways[2];
  for (std::vector<Eigen::VectorXd>& way : ways) {
    const auto follower = this->follower();
    EXPECT_FALSE(follower->follow(grip(0.0, 0.6, 1.0), Progress())) << "nothing is touched";
    for (int k = 1; k < 30; ++k) {
      const auto answer = follower->follow(grip(k / 60.0, 0.6 + 0.005 * k), Progress());
      if (!answer) continue;
      EXPECT_TRUE(answer->pose.q.allFinite());
      EXPECT_GT(answer->touches, 0);
      if (!way.empty()) {
        EXPECT_LT((answer->pose.q - way.back()).cwiseAbs().maxCoeff(), 0.3);
      }
      way.push_back(answer->pose.q);
    }
  }
  ASSERT_GT(ways[0].size(), 10u);
  EXPECT_EQ(ways[0], ways[1]);
}

// As people close their hands: part by part within a tenth of a second.
TEST_F(LiveFollowing, BeginsWhenNoMoreTouchesCome) {
  const auto follower = this->follower();
  manipulation::ContactTracker tracker(*grasp.ball);
  std::optional<LiveFollower::Answer> first;
  int frames = 0;
  std::size_t all = 0;
  for (; !first && frames < 60; ++frames) {
    const DemonstratedFrame frame = grip(frames / 100.0, 0.8);
    std::vector<manipulation::DetectedContact> touches = tracker.see(frame);
    all = touches.size();
    touches.resize(std::min<std::size_t>(all, frames / 3));
    first = follower->follow(frame.time_s, frame.X_WO, touches, manipulation::postureOf(frame),
                             Progress());
  }
  ASSERT_TRUE(first);
  ASSERT_GT(all, 5u);
  EXPECT_EQ(first->touches, static_cast<int>(all));
  EXPECT_NEAR(frames, 3 * static_cast<int>(all) + 9, 2) << "75 ms behind the last one";
}

TEST_F(LiveFollowing, AWrongFrameChangesNothing) {
  const auto follower = this->follower();
  const auto before = follower->follow(grip(1.0, 0.8), Progress());
  DemonstratedFrame nothing = grip(1.02, 0.8);
  nothing.joints_W(0, 3) = std::nan("");
  EXPECT_THROW(follower->follow(nothing, Progress()), InvalidInput);
  EXPECT_THROW(follower->follow(grip(0.9, 0.8), Progress()), InvalidInput);
  EXPECT_THROW(follower->follow(grip(1.0, 0.8), Progress()), InvalidInput);
  const auto after = follower->follow(grip(1.03, 0.8), Progress());
  ASSERT_EQ(before.has_value(), after.has_value());
  if (before) {
    EXPECT_LT((after->pose.q - before->pose.q).cwiseAbs().maxCoeff(), 0.2);
  }
}

TEST_F(LiveFollowing, GoesOnAfterAPauseAndWhenTimeBeginsAnew) {
  const auto follower = this->follower();
  const auto before = follower->follow(grip(10.0, 0.8), Progress());
  ASSERT_TRUE(before);
  for (const double time_s : {20.0, 0.0, 0.02}) {
    const auto after = follower->follow(grip(time_s, 0.8), Progress());
    ASSERT_TRUE(after);
    EXPECT_LT((after->pose.q - before->pose.q).cwiseAbs().maxCoeff(), 0.2) << time_s;
  }
}

TEST_F(LiveFollowing, AFrameThatJumpsIsPassedOver) {
  const auto steady = this->follower();
  const auto jumping = this->follower();
  for (int k = 0; k < 40; ++k) {
    const DemonstratedFrame frame = grip(k / 60.0, 0.8);
    DemonstratedFrame glitch = frame;
    if (k == 15) glitch.joints_W.col(8) += Eigen::Vector3d(0.0, 0.08, 0.0);  // an index's tip
    if (k == 25 || k == 26) glitch.joints_W = -frame.joints_W;
    const auto there = steady->follow(frame, Progress());
    const auto answer = jumping->follow(glitch, Progress());
    ASSERT_EQ(answer.has_value(), there.has_value());
    if (answer) {
      EXPECT_EQ(answer->pose.q, there->pose.q) << k;
    }
  }
}

TEST_F(LiveFollowing, WhatStaysSoIsNoGlitch) {
  const auto follower = this->follower();
  for (int k = 0; k < 20; ++k)
    (void)follower->follow(grip(k / 60.0, 0.8), Progress());
  const int before = follower->touches();
  ASSERT_GT(before, 0);
  for (int k = 20; k < 24; ++k) {
    DemonstratedFrame other = grip(k / 60.0, 0.8);
    other.joints_W = (-other.joints_W).eval();  // far from the ball, all of it
    (void)follower->follow(other, Progress());
    EXPECT_EQ(follower->touches() == before, k < 22) << k;
  }
}

// A hand of other proportions: its parts touch where they can, on the links that are meant.
TEST_F(LiveFollowing, PlacesYieldToWhereTheHandShowsATouch) {
  constexpr double kBend_rad = 0.75;  // at more, a bone lies in the ball
  const auto follower = this->follower();
  manipulation::ContactTracker tracker(*grasp.ball);
  const auto follow = [&](const DemonstratedFrame& frame) {
    // Of fingers that this hand has.
    return follower->follow(frame.time_s, frame.X_WO, without("ring", tracker.see(frame)),
                            manipulation::postureOf(frame), Progress());
  };
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 40; ++k)
    answer = follow(grip(k / 60.0, kBend_rad));
  ASSERT_TRUE(answer);
  ASSERT_GE(answer->parts.size(), 3u);
  int reached = 0;
  for (const LiveFollower::PartFit& fit : answer->parts)
    reached += fit.reached ? 1 : 0;
  EXPECT_LT(meanDistance(*answer), 7.0) << "13.9 where they do not";
  EXPECT_GE(2 * reached, static_cast<int>(answer->parts.size()));
  // At rest: nobody moves, so the hand comes to rest, too.
  const Eigen::VectorXd before = answer->pose.q;
  answer = follow(grip(40 / 60.0, kBend_rad));
  EXPECT_LT((answer->pose.q - before).cwiseAbs().maxCoeff(), 0.01);
}

// The hand has thumb, index and middle: what a ring finger touches another one shows.
TEST_F(LiveFollowing, AFingerThatTheHandLacksIsShownByAnother) {
  const auto follower = this->follower();
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 40; ++k)
    answer = follower->follow(grip(k / 60.0, 0.8), Progress());
  ASSERT_TRUE(answer);
  int of_ring = 0;
  int reached = 0;
  for (const LiveFollower::PartFit& fit : answer->parts) {
    if (!isOf("ring", fit.part)) continue;
    ++of_ring;
    reached += fit.reached ? 1 : 0;
  }
  EXPECT_GE(of_ring, 2);
  EXPECT_GE(reached, 1);
  EXPECT_LT(meanDistance(*answer), 7.0);
}

TEST_F(LiveFollowing, AFingerThatComesLaterIsShownBesideTheOthers) {
  const hand::Hand claw = test::handOfLibrary("barrett8");
  const session::Session opened(claw, grasp.ball, grasp.contacts, Pose::Identity(), {});
  const auto follower =
      std::make_unique<LiveFollower>(opened.document(), claw, grasp.ball, Progress());
  manipulation::ContactTracker tracker(*grasp.ball);
  std::vector<std::vector<std::string>> shown;
  for (int k = 0; k < 120; ++k) {
    const DemonstratedFrame frame = grip(k / 60.0, 0.8);
    std::vector<manipulation::DetectedContact> touches = tracker.see(frame);
    if (k < 40) touches = without("ring", touches);
    const auto answer = follower->follow(frame.time_s, frame.X_WO, touches,
                                         manipulation::postureOf(frame), Progress());
    if (!answer) continue;
    std::vector<std::string>& digits = shown.emplace_back();
    for (const LiveFollower::PartFit& fit : answer->parts)
      for (const char* digit : {"index", "ring"})
        if (isOf(digit, fit.part) && (digits.empty() || digits.back() != digit))
          digits.emplace_back(digit);
  }
  ASSERT_EQ(shown.size(), 120u);
  EXPECT_EQ(shown[30], (std::vector<std::string>{"index"}));
  EXPECT_EQ(shown.back(), (std::vector<std::string>{"index", "ring"}));
}

// This hand can show ring or index, not both: what it finds for the index misses as much, so
// the ring keeps its finger, and the hand stays where it is.
TEST_F(LiveFollowing, ADealingThatShowsNoMoreIsNotTaken) {
  const auto follower = this->follower();
  manipulation::ContactTracker tracker(*grasp.ball);
  std::optional<Eigen::VectorXd> before;
  for (int k = 0; k < 120; ++k) {
    const DemonstratedFrame frame = grip(k / 60.0, 0.8);
    std::vector<manipulation::DetectedContact> touches = tracker.see(frame);
    if (k < 40) touches = without("index", touches);
    const auto answer = follower->follow(frame.time_s, frame.X_WO, touches,
                                         manipulation::postureOf(frame), Progress());
    ASSERT_TRUE(answer);
    EXPECT_FALSE(answer->is_on_its_way) << k;
    for (const LiveFollower::PartFit& fit : answer->parts)
      EXPECT_FALSE(isOf("index", fit.part)) << k;
    // It had come to rest long before fingers are dealt anew, 0.25 s behind the index's touch.
    if (k > 60) {
      EXPECT_LT((answer->pose.q - *before).cwiseAbs().maxCoeff(), 0.02) << k;
    }
    before = answer->pose.q;
  }
}

// A search that is called off leaves nothing behind.
TEST_F(LiveFollowing, IsAsItWasAfterASearchThatWasCalledOff) {
  const auto follower = this->follower();
  const auto other = this->follower();
  const DemonstratedFrame frame = grip(0.0, 0.8);
  Progress stopped;
  stopped.cancel();
  EXPECT_THROW((void)follower->follow(frame, stopped), Cancelled);
  const auto answer = follower->follow(grip(0.02, 0.8), Progress());
  const auto fresh = other->follow(grip(0.02, 0.8), Progress());
  ASSERT_TRUE(answer && fresh);
  EXPECT_EQ(answer->parts.size(), fresh->parts.size());
  EXPECT_LT((answer->pose.q - fresh->pose.q).cwiseAbs().maxCoeff(), 1e-6);
}

// What the demonstrator touches is all of a sudden on the ball's other side. Followed from
// where it is, the hand stays 20 mm and 11 mm off for good (5.6 mm where it begins there).
TEST_F(LiveFollowing, AHandThatIsLostIsFoundAgain) {
  const auto turned = [](double time_s, const Eigen::Vector3d& turn_rad, double away_m) {
    DemonstratedFrame frame = grip(time_s, 0.8, away_m);
    frame.X_WO.linear() = rotationFromVector(turn_rad);
    return frame;
  };
  for (const Eigen::Vector3d& turn_rad :
       {Eigen::Vector3d(0.0, 0.0, 3.1), Eigen::Vector3d(1.0, 0.0, 0.0)}) {
    const auto follower = this->follower();
    const auto fresh = this->follower();
    std::optional<LiveFollower::Answer> answer;
    std::optional<LiveFollower::Answer> as_fresh;
    for (int k = 0; k < 20; ++k)
      answer = follower->follow(turned(k / 60.0, Eigen::Vector3d::Zero(), 0.02), Progress());
    ASSERT_TRUE(answer);
    int on_the_way = 0;
    for (int k = 20; k < 150; ++k) {
      const Eigen::VectorXd before = answer->pose.q;
      answer = follower->follow(turned(k / 60.0, turn_rad, 0.0), Progress());
      as_fresh = fresh->follow(turned(k / 60.0, turn_rad, 0.0), Progress());
      ASSERT_TRUE(answer && as_fresh);
      EXPECT_LT((answer->pose.q - before).cwiseAbs().maxCoeff(), 0.3) << "no jump at " << k;
      EXPECT_LT(answer->depths.object_m, 0.003) << k;
      on_the_way += answer->is_on_its_way ? 1 : 0;
    }
    EXPECT_GT(on_the_way, 0);
    EXPECT_FALSE(answer->is_on_its_way);
    EXPECT_LT(meanDistance(*answer), meanDistance(*as_fresh) + 2.0);
  }
}

// One part is told to touch the ball's other side as well, 60 mm from where its finger is. Of
// all that weighs the same the hand would show nothing.
TEST_F(LiveFollowing, WhatTheHandCannotShowYieldsToWhatItCan) {
  session.solve({}, {}, Progress());
  const hand::HandPose shown = session.solve({}, {}, Progress()).report.pose;
  demonstration::PosedHandTracker tracker(grasp.hand(), grasp.ball, Progress());
  std::vector<manipulation::DetectedContact> touches = tracker.see(shown, Pose::Identity());
  ASSERT_GE(touches.size(), 3u);
  manipulation::DetectedContact wrong = touches.back();
  const Eigen::Vector3d there_O = -positionOf(*grasp.ball, wrong.point_O);
  wrong.point_O = geometry::SurfaceLocator(*grasp.ball).nearest(there_O).point;
  wrong.part = static_cast<int>(tracker.partNames().size());
  touches.push_back(wrong);
  const auto follower = this->follower();
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 60; ++k)
    answer = follower->follow(k / 60.0, Pose::Identity(), touches,
                              tracker.postureOf(shown, Pose::Identity()), Progress());
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->parts.size(), touches.size());
  EXPECT_FALSE(answer->parts.back().reached);
  for (std::size_t i = 0; i + 1 < touches.size(); ++i) {
    EXPECT_TRUE(answer->parts[i].reached) << i;
    EXPECT_LT(answer->parts[i].distance_mm, 4.0) << i;
  }
}

// Told by its own joints, a hand that closes about the ball is where it is shown.
TEST_F(LiveFollowing, AHandThatIsShownToItselfIsThere) {
  const hand::Hand hand = grasp.hand();
  session.solve({}, {}, Progress());
  const hand::HandPose shown = session.solve({}, {}, Progress()).report.pose;
  demonstration::PosedHandTracker tracker(hand, grasp.ball, Progress());
  const auto follower = this->follower();
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 20; ++k) {
    Pose X_WO = Pose::Identity();
    X_WO.translation().x() = 0.01 * k;
    hand::HandPose pose = shown;
    pose.X_WH = X_WO * shown.X_WH;
    answer = follower->follow(k / 60.0, X_WO, tracker.see(pose, X_WO),
                              tracker.postureOf(pose, X_WO), Progress());
    ASSERT_TRUE(answer) << k;
    EXPECT_GE(answer->touches, 3);
    EXPECT_LT((answer->pose.q - pose.q).cwiseAbs().maxCoeff(), 0.2) << k;
    EXPECT_LT((answer->pose.X_WH.translation() - pose.X_WH.translation()).norm(), 0.006) << k;
    // What is said of the pose is said where the object is now.
    ASSERT_EQ(answer->parts.size(), static_cast<std::size_t>(answer->touches)) << k;
    for (const LiveFollower::PartFit& fit : answer->parts) {
      EXPECT_LT(static_cast<std::size_t>(fit.part), tracker.partNames().size());
      EXPECT_NEAR(fit.distance_mm, 1e3 * (fit.on_hand_W - fit.on_object_W).norm(), 1e-9);
      const Eigen::Vector3d out_W = fit.on_object_W - X_WO.translation();
      EXPECT_NEAR(out_W.norm(), 0.03, 5e-4) << "on the ball, in frame " << k;
      EXPECT_EQ(fit.reached, fit.distance_mm <= 6.0 && fit.facing_deg <= 60.0);
    }
    EXPECT_LT(answer->depths.object_m, 0.002) << k;
  }
}

std::vector<manipulation::DetectedContact> threeOf(
    const std::vector<manipulation::DetectedContact>& touches, std::size_t first) {
  const auto begin = touches.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + 3};
}

// Three touches leave a hand free to turn about the ball, and the fingers that come next would
// find it the other way round.
TEST_F(LiveFollowing, IsTurnedAsTheDemonstratorsHandWhereFewTouch) {
  const hand::Hand hand = test::handOfLibrary("human20");
  session::Session opened(hand, grasp.ball, grasp.contacts, Pose::Identity(), {});
  const hand::HandPose shown = opened.solve({}, {}, Progress()).report.pose;
  demonstration::PosedHandTracker tracker(hand, grasp.ball, Progress());
  const std::vector<manipulation::DetectedContact> all = tracker.see(shown, Pose::Identity());
  ASSERT_GE(all.size(), 5u);
  for (std::size_t first = 0; first + 3 <= all.size(); ++first) {
    LiveFollower follower(opened.document(), hand, grasp.ball, Progress());
    const auto answer = follower.follow(0.0, Pose::Identity(), threeOf(all, first),
                                        tracker.postureOf(shown, Pose::Identity()), Progress());
    ASSERT_TRUE(answer) << first;
    const Pose moved = answer->pose.X_WH * inverse(shown.X_WH);
    EXPECT_LT(vectorFromRotation(moved.linear()).norm(), 0.06) << first;
    EXPECT_LT((answer->pose.X_WH.translation() - shown.X_WH.translation()).norm(), 0.007)
        << first;
    EXPECT_LT(meanDistance(*answer), 2.0) << first;
  }
}

// Two touches leave it free to turn about the line through both as well.
TEST_F(LiveFollowing, APinchIsHeldAsTheDemonstratorHoldsIt) {
  const hand::Hand hand = test::handOfLibrary("human20");
  session::Session opened(hand, grasp.ball, grasp.contacts, Pose::Identity(), {});
  const hand::HandPose shown = opened.solve({}, {}, Progress()).report.pose;
  demonstration::PosedHandTracker tracker(hand, grasp.ball, Progress());
  std::vector<manipulation::DetectedContact> pinch;
  for (const manipulation::DetectedContact& touch : tracker.see(shown, Pose::Identity())) {
    const bool is_known =
        std::any_of(pinch.begin(), pinch.end(), [&](const manipulation::DetectedContact& one) {
          return one.place.digit == touch.place.digit;
        });
    if ((touch.place.digit == "thumb" || touch.place.digit == "index") && !is_known)
      pinch.push_back(touch);
  }
  ASSERT_EQ(pinch.size(), 2u);
  LiveFollower follower(opened.document(), hand, grasp.ball, Progress());
  const auto at = [&](double time_s,
                      const std::vector<manipulation::DetectedContact>& touches) {
    return follower.follow(time_s, Pose::Identity(), touches,
                           tracker.postureOf(shown, Pose::Identity()), Progress());
  };
  EXPECT_FALSE(at(0.0, {}));
  std::optional<LiveFollower::Answer> answer;
  int frames = 0;
  while (!answer && frames < 60)
    answer = at(++frames / 100.0, pinch);
  ASSERT_TRUE(answer);
  EXPECT_NEAR(frames, 26, 1) << "a quarter of a second later, since fingers may follow";
  EXPECT_EQ(answer->parts.size(), 2u);
  EXPECT_LT(meanDistance(*answer), 2.0);
  const Pose moved = answer->pose.X_WH * inverse(shown.X_WH);
  EXPECT_LT(vectorFromRotation(moved.linear()).norm(), 0.1);
}

// Who lets go and draws back is followed: the hand is not left about the object.
TEST_F(LiveFollowing, GoesAwayAsTheDemonstratorDoes) {
  const auto live = follower();
  std::optional<LiveFollower::Answer> answer;
  int k = 0;
  const auto show = [&](double bend_rad, double away_m) {
    answer = live->follow(grip(k++ / 60.0, bend_rad, away_m), Progress());
  };
  const auto root_O = [&](double away_m) {
    return (grip(0.0, 0.0, away_m).X_WO.inverse() * answer->pose.X_WH).translation().eval();
  };
  for (int i = 0; i < 60; ++i)
    show(std::min(0.9, 0.03 * i), 0.0);
  ASSERT_TRUE(answer.has_value());
  const Eigen::Vector3d held = root_O(0.0);
  constexpr double kAway = 0.1;
  for (int i = 0; i < 60; ++i)
    show(std::max(0.2, 0.9 - 0.03 * i), kAway * std::min(1.0, i / 40.0));
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->touches, 0);
  // It touches yet for a part of the way.
  EXPECT_GT((root_O(kAway) - held).norm(), 0.6 * kAway);
  EXPECT_LT((root_O(kAway) - held).norm(), 1.3 * kAway);
  // And back to it.
  for (int i = 0; i < 90; ++i)
    show(std::min(0.9, 0.2 + 0.02 * i), kAway * std::max(0.0, 1.0 - i / 40.0));
  ASSERT_TRUE(answer.has_value());
  EXPECT_GT(answer->touches, 3);
  EXPECT_LT((root_O(0.0) - held).norm(), 0.02);
}

// Who lets go opens the hand before the last part leaves: it is not left as it held.
TEST_F(LiveFollowing, OpensAsTheDemonstratorDoes) {
  const auto live = follower();
  std::optional<LiveFollower::Answer> answer;
  int k = 0;
  for (; k < 60; ++k)
    answer = live->follow(grip(k / 60.0, std::min(0.9, 0.03 * k)), Progress());
  ASSERT_TRUE(answer.has_value());
  const Eigen::VectorXd held = answer->pose.q;
  for (int i = 0; i < 120; ++i, ++k)
    answer = live->follow(
        grip(k / 60.0, std::max(0.1, 0.9 - 0.03 * i), 0.1 * std::min(1.0, i / 40.0)),
        Progress());
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->touches, 0);
  EXPECT_GT((answer->pose.q - held).cwiseAbs().maxCoeff(), 0.4);
}

// As long as it is not known how the other hand moves.
TEST_F(LiveFollowing, StaysOverTheObjectWhereOnlyTouchesAreTold) {
  const auto live = follower();
  manipulation::ContactTracker tracker(*grasp.ball);
  std::optional<LiveFollower::Answer> answer;
  Pose held;
  for (int k = 0; k < 120; ++k) {
    const DemonstratedFrame frame = grip(k / 60.0, std::min(0.9, 0.03 * k));
    const auto touches =
        k < 60 ? tracker.see(frame) : std::vector<manipulation::DetectedContact>();
    answer = live->follow(frame.time_s, frame.X_WO, touches, manipulation::postureOf(frame),
                          Progress());
    if (k == 59) held = answer->pose.X_WH;
  }
  ASSERT_TRUE(answer.has_value());
  EXPECT_LT((answer->pose.X_WH.translation() - held.translation()).norm(), 0.02);
}

}  // namespace
}  // namespace handgraft::retargeting
