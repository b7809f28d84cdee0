#include "core/geometry/bucket_queue.h"

#include <algorithm>
#include <random>
#include <unordered_map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/index_map.h"

namespace handgraft::geometry {
namespace {

/// Takes everything; each thing taken puts another one up to two steps farther, `more` times.
std::vector<double> drain(BucketQueue& queue, int more, std::mt19937& random) {
  std::uniform_real_distribution<double> farther(0.0, 0.2);
  std::vector<double> taken;
  while (queue.advance()) {
    BucketQueue::Entry entry;
    while (queue.take(entry)) {
      EXPECT_LE(entry.distance, queue.nearEnd() * (1.0 + 1e-12));
      taken.push_back(entry.distance);
      if (more-- > 0) queue.put(entry.distance + farther(random), entry.number);
    }
  }
  return taken;
}

TEST(BucketQueue, TakesEverythingInOrderButForOneStep) {
  constexpr double kStep = 0.1;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> distance(0.0, 50.0);  // far beyond its buckets
  BucketQueue queue(kStep);
  for (int i = 0; i < 500; ++i)
    queue.put(distance(random), i);
  const std::vector<double> taken = drain(queue, 1000, random);
  ASSERT_EQ(taken.size(), 1500U);
  double farthest = 0.0;
  for (const double d : taken) {
    EXPECT_GT(d, farthest - 1.000001 * kStep);
    farthest = std::max(farthest, d);
  }
}

TEST(BucketQueue, IsOneStackWithoutAStep) {
  BucketQueue queue(0.0);
  for (const double d : {3.0, 1e30, 0.0})
    queue.put(d, static_cast<int>(queue.nearEnd()));
  std::mt19937 random(3);
  EXPECT_EQ(drain(queue, 0, random), (std::vector<double>{0.0, 1e30, 3.0}));
}

// Whose inverse overflows: 0 times that is no number, and fits no bucket.
TEST(BucketQueue, TakesEverythingWithAStepNextToNothing) {
  BucketQueue queue(1e-310);
  for (const double d : {3.0, 1e30, 0.0})
    queue.put(d, 0);
  std::mt19937 random(3);
  EXPECT_EQ(drain(queue, 0, random).size(), 3U);
}

// Rounding, or a source far below the size of its mesh, may put things nearer than the step at
// hand, by more steps than an int counts.
TEST(BucketQueue, TakesWhatIsFarNearerThanTheStepAtHand) {
  BucketQueue queue(1e-15);
  queue.put(1.0, 0);
  ASSERT_TRUE(queue.advance());
  queue.put(0.0, 1);
  BucketQueue::Entry entry{};
  ASSERT_TRUE(queue.take(entry));
  EXPECT_EQ(entry.number, 1);
  ASSERT_TRUE(queue.take(entry));
  EXPECT_EQ(entry.number, 0);
}

TEST(IndexMap, AgreesWithAMap) {
  std::mt19937 random(5);
  IndexMap numbering(1);
  std::unordered_map<int, int> truth;
  for (int i = 0; i < 5000; ++i) {
    // Neighbours, and keys all over the range of int.
    const int key = static_cast<int>(i % 2 == 0 ? random() % 3000 : random() >> 1);
    const auto known = truth.emplace(key, static_cast<int>(truth.size()));
    EXPECT_EQ(numbering.find(key), known.second ? -1 : known.first->second);
    EXPECT_EQ(numbering.add(key), std::pair(known.first->second, known.second));
    EXPECT_EQ(numbering.keyOf(known.first->second), key);
  }
  EXPECT_EQ(numbering.size(), static_cast<int>(truth.size()));
}

}  // namespace
}  // namespace handgraft::geometry
