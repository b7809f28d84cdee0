#include "hardware/bridge/wake_event.h"

#include <thread>

#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using std::chrono::milliseconds;
constexpr std::chrono::hours kNever(1);  // a wait that nobody ends lasts longer than a test may

TEST(WakeEvent, IsHeardByWhoWaits) {
  WakeEvent bell;
  std::thread visitor([&bell] {
    std::this_thread::sleep_for(milliseconds(5));
    bell.ring();
  });
  bell.wait(kNever);
  visitor.join();
}

TEST(WakeEvent, WasRungBeforeAnybodyWaited) {
  WakeEvent bell;
  bell.ring();
  bell.wait(kNever);
}

TEST(WakeEvent, IsHeardOnceHoweverOftenItWasRung) {
  WakeEvent bell;
  for (int i = 0; i < 1000; ++i)
    bell.ring();
  bell.wait(kNever);
  const auto begin = std::chrono::steady_clock::now();
  bell.wait(milliseconds(20));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(20));
}

TEST(WakeEvent, LosesNoRingBesideItsWaiter) {
  constexpr int kRings = 20'000;
  WakeEvent bell;
  std::atomic<int> written{0};
  std::thread visitor([&] {
    for (int i = 0; i < kRings; ++i) {
      ++written;
      bell.ring();
    }
  });
  int seen = 0;
  while (seen < kRings) {
    bell.wait(kNever);
    seen = written;
  }
  visitor.join();
}

}  // namespace
}  // namespace handgraft::bridge
