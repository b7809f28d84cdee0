#include "core/placement/solids.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/ball_hand.h"

namespace handgraft::placement {
namespace {

/// A palm and a jaw, each a ball.
hand::Hand clamp() {
  std::vector<hand::Link> links(2);
  links[0].name = "palm";
  links[1].name = "jaw";
  hand::Joint hinge;
  hinge.name = "hinge";
  hinge.type = hand::JointType::kRevolute;
  hinge.parent_link = "palm";
  hinge.child_link = "jaw";
  hinge.X_PJ.translation() = Eigen::Vector3d(0.05, 0, 0);
  hinge.axis_J = Eigen::Vector3d::UnitZ();
  const test::BallHand made = test::withBalls(hand::HandModel("clamp", links, {hinge}), 0.02);
  hand::Hand hand;
  hand.model = made.model;
  hand.skin = made.skin;
  return hand;
}

std::shared_ptr<const geometry::TriangleMesh> ball() {
  return std::make_shared<const geometry::TriangleMesh>(geometry::makeSphere(0.03, 4));
}

TEST(Solids, AreMadeOnceForAllWhoAskAtOnce) {
  const hand::Hand hand = clamp();
  const auto object_O = ball();
  constexpr std::size_t kAsking = 6;
  std::vector<std::shared_ptr<const hand::HandSolid>> hands(kAsking);
  std::vector<std::shared_ptr<const geometry::Solid>> objects(kAsking);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kAsking; ++i) {
    threads.emplace_back([&, i] {
      if (i % 2 == 0) makeSolids(hand, object_O, Progress());
      objects[i] = solidOf(object_O, Progress());
      hands[i] = solidOf(hand.model, hand.skin, Progress());
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  for (std::size_t i = 0; i < kAsking; ++i) {
    ASSERT_NE(hands[i], nullptr);
    EXPECT_EQ(hands[i], hands[0]);
    EXPECT_EQ(objects[i], objects[0]);
  }
  EXPECT_NE(solidOf(ball(), Progress()), objects[0]) << "another mesh of the same shape";
}

TEST(Solids, AreLeftToTheNextByThoseWhoAreCancelled) {
  const hand::Hand hand = clamp();
  const auto object_O = ball();
  constexpr int kAsking = 6;
  std::atomic<int> cancelled{0};
  std::atomic<int> made{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < kAsking; ++i) {
    threads.emplace_back([&, i] {
      Progress progress;
      if (i % 2 == 0) progress.cancel();
      try {
        makeSolids(hand, object_O, progress);
        ++made;
      } catch (const Cancelled&) {
        ++cancelled;
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  // Those who find them made have nothing to be cancelled of.
  EXPECT_GE(made, kAsking / 2);
  EXPECT_EQ(made + cancelled, kAsking);

  Progress progress;
  progress.cancel();
  EXPECT_THROW(makeSolids(clamp(), ball(), progress), Cancelled);
  EXPECT_NO_THROW(makeSolids(hand, object_O, progress)) << "they are there";
}

}  // namespace
}  // namespace handgraft::placement
