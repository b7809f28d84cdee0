#include "core/demonstration/posed_hand_tracker.h"

#include <cmath>
#include <map>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/demonstration/small_hand_about_a_box.h"

namespace handgraft::demonstration {
namespace {

using manipulation::DetectedContact;

class TrackedSmallHand : public SmallHandAboutABox {
 protected:
  [[nodiscard]] PosedHandTracker tracker() const {
    return {hand(), std::make_shared<const geometry::TriangleMesh>(box_O_), Progress()};
  }

  /// The hand moved along the object's axis at which fingers and thumb stand, away from it
  /// with the palm below it.
  [[nodiscard]] hand::HandPose lowered(double by_m) const {
    hand::HandPose moved = pose;
    moved.X_WH = X_WO_ * Eigen::Translation3d(0.0, 0.0, -0.06 - by_m);
    return moved;
  }
};

TEST_F(TrackedSmallHand, TouchesWithItsFingersWhereTheyAre) {
  PosedHandTracker tracker = this->tracker();
  const std::vector<DetectedContact> touches = tracker.see(pose, X_WO_);
  std::map<std::string, Eigen::Vector3d> sum_O;
  int last = -1;
  for (const DetectedContact& touch : touches) {
    EXPECT_GT(touch.part, last);
    last = touch.part;
    const Eigen::Vector3d p_O = positionOf(box_O_, touch.point_O);
    // Fingers close in to the box's sides at x and -x, half way round no side.
    EXPECT_NEAR(p_O.x(), touch.place.digit == "thumb" ? -0.031 : 0.031, 1e-9);
    EXPECT_NEAR(touch.place.around_rad, 0.0, 0.3) << touch.place.digit;
    if (touch.place.segment == "distal") sum_O.try_emplace(touch.place.digit, p_O);
  }
  ASSERT_EQ(sum_O.size(), 3u);
  EXPECT_NEAR(sum_O.at("thumb").y(), 0.0, 0.004);
  EXPECT_NEAR(sum_O.at("index").y(), 0.015, 0.004);
  EXPECT_NEAR(sum_O.at("middle").y(), -0.015, 0.004);
}

TEST_F(TrackedSmallHand, LetsGoLaterThanItTouches) {
  // Between the two distances: not touched by who comes, not let go by who has touched.
  constexpr double kBetween = 0.5 * (PosedHandTracker::kBegin + PosedHandTracker::kEnd);
  hand::HandPose beside = pose;
  // The thumb goes off as the fingers go in: the thumb's side alone is looked at.
  beside.X_WH = X_WO_ * Eigen::Translation3d(-kBetween - 0.001, 0.0, -0.06);
  const auto touches_with_thumb = [](const std::vector<DetectedContact>& touches) {
    for (const DetectedContact& touch : touches)
      if (touch.place.digit == "thumb" && touch.place.segment == "distal") return true;
    return false;
  };
  PosedHandTracker coming = tracker();
  EXPECT_FALSE(touches_with_thumb(coming.see(beside, X_WO_)));
  EXPECT_TRUE(touches_with_thumb(coming.see(pose, X_WO_)));
  EXPECT_TRUE(touches_with_thumb(coming.see(beside, X_WO_)));
  EXPECT_TRUE(coming.see(lowered(0.5), X_WO_).empty());
  EXPECT_FALSE(touches_with_thumb(coming.see(beside, X_WO_)));
}

TEST_F(TrackedSmallHand, DoesNotJumpWhileItSlides) {
  PosedHandTracker tracker = this->tracker();
  std::map<int, Eigen::Vector3d> last_O;
  for (int k = 0; k <= 40; ++k) {
    for (const DetectedContact& touch : tracker.see(lowered(0.0005 * k), X_WO_)) {
      const Eigen::Vector3d p_O = positionOf(box_O_, touch.point_O);
      const auto before = last_O.find(touch.part);
      if (before != last_O.end()) {
        EXPECT_LT((p_O - before->second).norm(), 0.003) << k << " " << touch.place.digit;
      }
      last_O[touch.part] = p_O;
    }
  }
  EXPECT_GE(last_O.size(), 3u);
}

TEST_F(TrackedSmallHand, WhatIsNotFiniteChangesNothing) {
  PosedHandTracker tracker = this->tracker();
  const std::size_t count = tracker.see(pose, X_WO_).size();
  hand::HandPose wrong = pose;
  wrong.q[0] = std::nan("");
  EXPECT_THROW(tracker.see(wrong, X_WO_), InvalidInput);
  Pose nowhere = X_WO_;
  nowhere.translation().x() = std::nan("");
  EXPECT_THROW(tracker.see(pose, nowhere), InvalidInput);
  EXPECT_EQ(tracker.see(pose, X_WO_).size(), count);
}

}  // namespace
}  // namespace handgraft::demonstration
