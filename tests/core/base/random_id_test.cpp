#include "core/base/random_id.h"

#include <set>

#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(RandomId, HasSixteenDigitsAndSurvivesADouble) {
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t id = randomId();
    EXPECT_EQ(std::to_string(id).size(), 16u);
    EXPECT_EQ(static_cast<std::uint64_t>(static_cast<double>(id)), id);
  }
}

TEST(RandomId, NeverComesTwice) {
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 10'000; ++i)
    EXPECT_TRUE(seen.insert(randomId()).second);
}

}  // namespace
}  // namespace handgraft
