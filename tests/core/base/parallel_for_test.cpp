#include "core/base/parallel_for.h"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(SideBySide, CallsEachOnce) {
  for (const int count : {0, 1, 2, 3, 1000}) {
    for (const int threads : {0, 1, 2, 7}) {
      std::vector<int> calls(static_cast<std::size_t>(count), 0);
      parallelFor(
          count,
          [&](int i) {
            ++calls.at(static_cast<std::size_t>(i));
          },
          threads);
      EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(count), 1));
    }
  }
}

TEST(SideBySide, ThrowsWhatTheFirstOneThrew) {
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> calls = 0;
    try {
      parallelFor(200, [&](int i) {
        ++calls;
        if (i >= 17) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "17");
    }
    EXPECT_GE(calls, 18);
    EXPECT_LT(calls, 200);
  }
}

}  // namespace
}  // namespace handgraft
