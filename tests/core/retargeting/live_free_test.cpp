// What a live hand does where the demonstrator's touches nothing: it comes near, and lets go.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/angle.h"
#include "core/hand/grip_point.h"
#include "core/retargeting/live_follower.h"

#include "tests/core/retargeting/live_grip.h"
#include "tests/core/session/library_models.h"

namespace handgraft::retargeting {
namespace {

using manipulation::DemonstratedFrame;
using test::grip;
using test::handOfLibrary;
using test::LiveFollowing;

/// At more, a bone lies in the ball.
constexpr double kBend_rad = 0.75;

/// Comes from 0.3 m away with an open hand, and closes it about the ball.
DemonstratedFrame coming(int k) {
  const double way = std::clamp(k / 60.0, 0.0, 1.0);
  const double bend_rad = std::clamp((k - 60) / 40.0, 0.0, 1.0) * kBend_rad;
  return grip(k / 60.0, bend_rad, 0.3 * (1.0 - way));
}

/// From `k` on it draws back while it opens.
DemonstratedFrame leaving(int k, int i) {
  return grip((k + i) / 60.0, std::max(0.1, kBend_rad - 0.03 * i),
              0.3 * std::min(1.0, i / 60.0));
}

// From the first frame on, long before anything touches.
TEST_F(LiveFollowing, ComesNearAsTheDemonstratorDoes) {
  for (const char* name : {"human20", "tendon16", "barrett8"}) {
    const hand::Hand hand = handOfLibrary(name);
    const hand::GripPoint grip_point(hand);
    const auto live = followerOf(hand);
    for (int k = 0; k < 55; ++k) {
      const DemonstratedFrame frame = coming(k);
      const auto answer = live->follow(frame, Progress());
      ASSERT_TRUE(answer) << name << " " << k;
      EXPECT_TRUE(answer->parts.empty());
      const auto grip_W = grip_point.at(hand::forwardKinematics(*hand.model, answer->pose));
      ASSERT_TRUE(grip_W);
      EXPECT_LT((*grip_W - hand::gripPointOf(frame.joints_W)).norm(), 0.015) << name << k;
    }
  }
}

// It is turned as that hand: its palm looks where the other one's does.
TEST_F(LiveFollowing, ComesNearTurnedAsTheDemonstratorsHand) {
  const hand::Hand hand = handOfLibrary("human20");
  for (const double turn_rad : {0.0, 1.0, 2.5}) {
    const auto live = followerOf(hand);
    DemonstratedFrame frame = grip(0.0, 0.1, 0.3);
    const Eigen::Matrix3d R = rotationFromVector(Eigen::Vector3d(turn_rad, 0.0, 0.0));
    frame.joints_W = R * frame.joints_W;
    const auto answer = live->follow(frame, Progress());
    const auto straight = followerOf(hand)->follow(grip(0.0, 0.1, 0.3), Progress());
    ASSERT_TRUE(answer && straight);
    EXPECT_LT(vectorFromRotation(answer->pose.X_WH.linear().transpose() * R *
                                 straight->pose.X_WH.linear())
                  .norm(),
              0.05)
        << turn_rad;
  }
}

// Searches run beside the frames, which are answered as if there were none; nothing jumps.
TEST_F(LiveFollowing, BeginsAndEndsWithoutAJumpAndIsTheSameAgain) {
  const hand::Hand hand = handOfLibrary("human20");
  std::vector<Eigen::VectorXd> ways[2];
  for (std::vector<Eigen::VectorXd>& way : ways) {
    const auto live = followerOf(hand);
    std::optional<hand::HandPose> before_O;
    int held = 0;
    constexpr int kHeld = 150;
    for (int k = 0; k < 250; ++k) {
      const DemonstratedFrame frame = k < kHeld ? coming(k) : leaving(kHeld, k - kHeld);
      const auto answer = live->follow(frame, Progress());
      ASSERT_TRUE(answer) << k;
      const hand::HandPose now_O{inverse(frame.X_WO) * answer->pose.X_WH, answer->pose.q};
      if (before_O) {
        EXPECT_LT((now_O.q - before_O->q).lpNorm<Eigen::Infinity>(), 0.17) << "10 rad/s " << k;
        EXPECT_LT((now_O.X_WH.translation() - before_O->X_WH.translation()).norm(), 0.012) << k;
      }
      EXPECT_LT(answer->depths.object_m, 0.002) << k;
      before_O = now_O;
      way.push_back(answer->pose.q);
      held = std::max(held, answer->touches);
    }
    EXPECT_GT(held, 5);
  }
  EXPECT_EQ(ways[0], ways[1]);
}

// A touch is shown as it comes, not when all of them have.
TEST_F(LiveFollowing, ShowsWhatTouchesBeforeAllDoes) {
  const auto live = followerOf(handOfLibrary("human20"));
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 200 && (!answer || answer->touches < 2); ++k)
    answer = live->follow(coming(k), Progress());
  ASSERT_TRUE(answer);
  ASSERT_GE(answer->touches, 2);
  EXPECT_EQ(answer->parts.size(), static_cast<std::size_t>(answer->touches));
}

// Who lets go and draws back is followed: the hand is not left about the object.
TEST_F(LiveFollowing, GoesAwayAsTheDemonstratorDoes) {
  for (const char* name : {"", "human20", "tendon16"}) {
    const auto live = *name == '\0' ? follower() : followerOf(handOfLibrary(name));
    std::optional<LiveFollower::Answer> answer;
    int k = 0;
    const auto show = [&](double bend_rad, double away_m) {
      answer = live->follow(grip(k++ / 60.0, bend_rad, away_m), Progress());
    };
    const auto root_O = [&](double away_m) {
      return (grip(0.0, 0.0, away_m).X_WO.inverse() * answer->pose.X_WH).translation().eval();
    };
    for (int i = 0; i < 120; ++i)
      show(std::min(kBend_rad, 0.03 * i), 0.0);
    ASSERT_TRUE(answer.has_value());
    const Eigen::Vector3d held = root_O(0.0);
    constexpr double kAway = 0.1;
    for (int i = 0; i < 60; ++i)
      show(std::max(0.2, kBend_rad - 0.03 * i), kAway * std::min(1.0, i / 40.0));
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->touches, 0);
    // It touches yet for a part of the way.
    EXPECT_GT((root_O(kAway) - held).norm(), 0.6 * kAway) << name;
    EXPECT_LT((root_O(kAway) - held).norm(), 1.3 * kAway) << name;
    // And back to it.
    for (int i = 0; i < 150; ++i)
      show(std::min(kBend_rad, 0.2 + 0.02 * i), kAway * std::max(0.0, 1.0 - i / 40.0));
    ASSERT_TRUE(answer.has_value());
    EXPECT_GT(answer->touches, 3);
    EXPECT_LT((root_O(0.0) - held).norm(), 0.02) << name;
  }
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

// A finger that touches nothing while others hold stands as it is shown: closed here, for what
// is relaxed is a third of the way.
TEST_F(LiveFollowing, WhatTouchesNothingStandsAsItIsShown) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto live = followerOf(hand);
  manipulation::ContactTracker tracker(*grasp.ball);
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 200; ++k) {
    DemonstratedFrame frame = coming(k);
    std::vector<manipulation::DetectedContact> touches = tracker.see(frame);
    std::erase_if(touches, [](const manipulation::DetectedContact& touch) {
      return touch.place.digit == "little";
    });
    answer = live->follow(frame.time_s, frame.X_WO, touches, manipulation::shownBy(frame),
                          Progress());
  }
  ASSERT_TRUE(answer);
  ASSERT_GT(answer->touches, 3);
  const int tip = hand.model->dofIndex("little_pip_flex");
  EXPECT_NEAR(answer->pose.q[tip], kBend_rad, 0.2);
}

// Half a second later it stands as if it had never held anything.
TEST_F(LiveFollowing, ForgetsHowItHeld) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto live = followerOf(hand);
  int k = 0;
  for (; k < 140; ++k)
    (void)live->follow(coming(k), Progress());
  std::optional<LiveFollower::Answer> answer;
  for (int i = 0; i < 120; ++i)
    answer = live->follow(leaving(k, i), Progress());
  const auto fresh = followerOf(hand)->follow(leaving(k, 120), Progress());
  ASSERT_TRUE(answer && fresh);
  // Postures that follow each other leave joints a little aside of those that are looked for.
  EXPECT_LT((answer->pose.q - fresh->pose.q).lpNorm<Eigen::Infinity>(), 0.15);
  EXPECT_LT((answer->pose.X_WH.translation() - fresh->pose.X_WH.translation()).norm(), 0.003);
}

// One part that touches for a moment holds the hand back a little; it catches up without a
// step.
TEST_F(LiveFollowing, WhatGrazesIsLeftWithoutAStep) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto live = followerOf(hand);
  manipulation::ContactTracker tracker(*grasp.ball);
  const std::vector<manipulation::DetectedContact> all = tracker.see(coming(160));
  const auto tip = std::find_if(all.begin(), all.end(), [](const auto& touch) {
    return touch.place.digit == "middle";
  });
  ASSERT_NE(tip, all.end());
  std::optional<hand::HandPose> before_O;
  for (int k = 0; k < 90; ++k) {
    // Past the ball, 6 mm a frame.
    DemonstratedFrame frame = grip(k / 60.0, kBend_rad, 0.0);
    frame.X_WO.translation().x() += 0.006 * (45 - k);
    std::vector<manipulation::DetectedContact> touches;
    if (k > 40 && k < 48) touches.push_back(*tip);
    const auto answer = live->follow(frame.time_s, frame.X_WO, touches,
                                     manipulation::shownBy(frame), Progress());
    ASSERT_TRUE(answer);
    const hand::HandPose now_O{inverse(frame.X_WO) * answer->pose.X_WH, answer->pose.q};
    if (before_O && k > 2) {
      EXPECT_LT((now_O.X_WH.translation() - before_O->X_WH.translation()).norm(), 0.014) << k;
    }
    before_O = now_O;
  }
}

// Who was not seen for a while is half a metre elsewhere then: the hand goes there in half a
// second. Of frames that are all so far apart each is answered as it is.
TEST_F(LiveFollowing, CatchesUpBehindAPauseWithoutAStep) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto live = followerOf(hand);
  const auto away = [](double time_s, double away_m) {
    return grip(time_s, 0.1, away_m);
  };
  std::optional<LiveFollower::Answer> answer;
  for (int k = 0; k < 30; ++k)
    answer = live->follow(away(k / 60.0, 0.2), Progress());
  ASSERT_TRUE(answer);
  const auto root_O = [&] {
    return (answer->pose.X_WH.translation() - away(0.0, 0.7).X_WO.translation()).eval();
  };
  Eigen::Vector3d before = answer->pose.X_WH.translation() - away(0.0, 0.2).X_WO.translation();
  for (int k = 0; k < 45; ++k) {
    answer = live->follow(away(100.0 + k / 60.0, 0.7), Progress());
    ASSERT_TRUE(answer);
    EXPECT_LT((root_O() - before).norm(), 0.04) << k;
    before = root_O();
  }
  const auto fresh = followerOf(hand)->follow(away(0.0, 0.7), Progress());
  ASSERT_TRUE(fresh);
  EXPECT_LT((answer->pose.X_WH.translation() - fresh->pose.X_WH.translation()).norm(), 0.003);

  for (int k = 1; k < 6; ++k) {
    answer = live->follow(away(200.0 + k, 0.15 * k), Progress());
    const auto alone = followerOf(hand)->follow(away(0.0, 0.15 * k), Progress());
    ASSERT_TRUE(answer && alone);
    if (k < 3) continue;  // two gaps in a row may be gaps
    EXPECT_LT((answer->pose.X_WH.translation() - alone->pose.X_WH.translation()).norm(), 0.003)
        << k;
  }
}

// Two gaps with a frame between them are no slow frames.
TEST_F(LiveFollowing, CatchesUpBehindTwoGapsInARow) {
  const auto live = followerOf(handOfLibrary("human20"));
  std::optional<Eigen::Vector3d> before_O;
  const auto step_to = [&](double time_s, double away_m) {
    const DemonstratedFrame frame = grip(time_s, 0.1, away_m);
    const auto answer = live->follow(frame, Progress());
    EXPECT_TRUE(answer);
    if (!answer) return 0.0;
    const Eigen::Vector3d now_O = (inverse(frame.X_WO) * answer->pose.X_WH).translation();
    const double step = before_O ? (now_O - *before_O).norm() : 0.0;
    before_O = now_O;
    return step;
  };
  for (int k = 0; k < 30; ++k)
    step_to(k / 60.0, 0.2);
  EXPECT_LT(step_to(0.8, 0.7), 0.04);
  for (int k = 0; k < 45; ++k)
    EXPECT_LT(step_to(1.1 + k / 60.0, 0.7), 0.04) << k;
}

// What it held behind a pause is let go from where that was, not from before the pause.
TEST_F(LiveFollowing, LetsGoOfWhatItTookBehindAPause) {
  const auto live = followerOf(handOfLibrary("human20"));
  for (int k = 0; k < 30; ++k)
    (void)live->follow(grip(k / 60.0, 0.1, 0.3), Progress());
  std::optional<Eigen::Vector3d> before_O;
  for (int k = 0; k < 60; ++k) {
    const DemonstratedFrame frame =
        k < 12
            ? grip(2.0 + k / 60.0, kBend_rad)
            : grip(2.0 + k / 60.0, std::max(0.1, kBend_rad - 0.2 * (k - 11)), 0.005 * (k - 11));
    const auto answer = live->follow(frame, Progress());
    ASSERT_TRUE(answer) << k;
    const Eigen::Vector3d now_O = (inverse(frame.X_WO) * answer->pose.X_WH).translation();
    if (before_O) {
      EXPECT_LT((now_O - *before_O).norm(), 0.03) << k;
    }
    before_O = now_O;
  }
}

// A clock that begins anew while the hand lets go does not hold it back.
TEST_F(LiveFollowing, LetsGoThoughTheClockBeginsAnew) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto live = followerOf(hand);
  for (int k = 0; k < 140; ++k)
    (void)live->follow(coming(k), Progress());
  std::optional<LiveFollower::Answer> answer;
  DemonstratedFrame frame;
  for (int i = 0; i < 60; ++i) {
    frame = leaving(0, i + 40);
    frame.time_s = i / 60.0;
    answer = live->follow(frame, Progress());
  }
  ASSERT_TRUE(answer);
  frame.time_s = 0.0;
  const auto fresh = followerOf(hand)->follow(frame, Progress());
  ASSERT_TRUE(fresh);
  EXPECT_LT((answer->pose.X_WH.translation() - fresh->pose.X_WH.translation()).norm(), 0.005);
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
    answer = live->follow(frame.time_s, frame.X_WO, touches, {manipulation::postureOf(frame)},
                          Progress());
    if (k == 59) held = answer->pose.X_WH;
  }
  ASSERT_TRUE(answer.has_value());
  EXPECT_LT((answer->pose.X_WH.translation() - held.translation()).norm(), 0.02);
}

}  // namespace
}  // namespace handgraft::retargeting
