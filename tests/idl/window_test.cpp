// How many edits a client has under way beside others.
#include "idl/cyclone/window.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::idl::cyclone {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMost = 384;
constexpr milliseconds kInterval{50};

TEST(Window, GrowsToItsMostWhileAllIsAnswered) {
  Window window(kMost);
  for (std::size_t i = 0; i < 2 * kMost; ++i)
    window.answered();
  EXPECT_EQ(window.size(), kMost);
}

TEST(Window, IsHalvedOnceForWhatIsLostTogether) {
  Window window(kMost);
  const Window::Clock::time_point now{std::chrono::hours(1)};
  for (int i = 0; i < 20; ++i)
    window.repeated(now + milliseconds(i), kInterval);
  EXPECT_EQ(window.size(), Window::kFirst / 2);
  window.repeated(now + kInterval, kInterval);
  EXPECT_EQ(window.size(), Window::kFirst / 4);
}

TEST(Window, NeverClosesForGood) {
  Window window(kMost);
  Window::Clock::time_point now{std::chrono::hours(1)};
  for (int i = 0; i < 100; ++i)
    window.repeated(now += kInterval, kInterval);
  EXPECT_EQ(window.size(), Window::kLeast);
}

TEST(Window, ComesBackByOneForEachWholeWindowThatIsAnswered) {
  Window window(kMost);
  window.repeated(Window::Clock::time_point{std::chrono::hours(1)}, kInterval);
  const std::size_t halved = window.size();
  for (std::size_t i = 0; i < halved; ++i)
    window.answered();
  EXPECT_LE(window.size(), halved + 1);
  for (std::size_t i = 0; i < halved; ++i)
    window.answered();
  EXPECT_EQ(window.size(), halved + 1);
}

/// Several clients on a server that answers so many a turn: what is beyond comes too late.
TEST(Window, SharesAServerWithOthers) {
  constexpr std::size_t kAnswered = 200;
  std::vector<Window> windows(5, Window(kMost));
  Window::Clock::time_point now{std::chrono::hours(1)};
  std::size_t asked_late = 0;
  constexpr int kTurns = 400;
  for (int turn = 0; turn < kTurns; ++turn) {
    now += kInterval;
    std::size_t asked = 0;
    for (const Window& one : windows)
      asked += one.size();
    if (turn >= kTurns / 2) asked_late += asked;
    for (Window& one : windows) {
      const std::size_t answered = std::min(one.size(), one.size() * kAnswered / asked);
      if (answered < one.size()) one.repeated(now, kInterval);
      for (std::size_t i = 0; i < answered; ++i)
        one.answered();
    }
  }
  const double mean = static_cast<double>(asked_late) / (kTurns / 2);
  EXPECT_LT(mean, 1.2 * kAnswered);
  EXPECT_GT(mean, 0.5 * kAnswered);
}

}  // namespace
}  // namespace handgraft::idl::cyclone
