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

#include "tests/core/retargeting/live_grip.h"
#include "tests/core/session/library_models.h"

namespace handgraft::retargeting {
namespace {

using manipulation::DemonstratedFrame;
using test::grip;
using test::LiveFollowing;
using test::meanDistance;

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
    first = follower->follow(frame.time_s, frame.X_WO, touches,
                             {manipulation::postureOf(frame)}, Progress());
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
    if (k == 30) glitch.joints_W.row(2).array() += 1.0;  // all of it elsewhere
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
                            {manipulation::postureOf(frame)}, Progress());
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
                                         {manipulation::postureOf(frame)}, Progress());
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
                                         {manipulation::postureOf(frame)}, Progress());
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

// What touches changes while the hand is led elsewhere: at the end of its way it is let go bit
// by bit (11 mm in a frame if at once).
TEST_F(LiveFollowing, AtTheEndOfItsWayAHandIsNotTornAway) {
  const auto follower = this->follower();
  const auto turned = [](int k, double turn_rad) {
    DemonstratedFrame frame = grip(k / 60.0, 0.8, k < 20 ? 0.02 : 0.0);
    frame.X_WO.linear() = rotationFromVector(Eigen::Vector3d(turn_rad, 0.0, 0.0));
    return frame;
  };
  std::optional<LiveFollower::Answer> answer;
  std::optional<Pose> before_OH;
  double turn_rad = 0.0;
  int ends = 0;
  bool was_led = false;
  for (int k = 0; k < 150; ++k) {
    if (k == 20) turn_rad = 1.0;
    if (answer && answer->is_on_its_way) turn_rad = -0.4;
    const DemonstratedFrame frame = turned(k, turn_rad);
    answer = follower->follow(frame, Progress());
    ASSERT_TRUE(answer);
    const Pose X_OH = inverse(frame.X_WO) * answer->pose.X_WH;
    if (before_OH && was_led && !answer->is_on_its_way) {
      ++ends;
      EXPECT_LT((X_OH.translation() - before_OH->translation()).norm(), 0.006) << k;
    }
    was_led = answer->is_on_its_way;
    before_OH = X_OH;
  }
  EXPECT_GT(ends, 0);
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
                              {tracker.postureOf(shown, Pose::Identity())}, Progress());
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
                              {tracker.postureOf(pose, X_WO)}, Progress());
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
    const auto answer =
        follower.follow(0.0, Pose::Identity(), threeOf(all, first),
                        {tracker.postureOf(shown, Pose::Identity())}, Progress());
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
                           {tracker.postureOf(shown, Pose::Identity())}, Progress());
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

}  // namespace
}  // namespace handgraft::retargeting
