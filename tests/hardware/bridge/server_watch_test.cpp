#include "hardware/bridge/server_watch.h"

#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using namespace std::chrono_literals;

constexpr ServerWatch::Time kStart{1h};

v1::ServerStatus statusOf(std::uint64_t server, bool stopping = false) {
  v1::ServerStatus status;
  status.server_id(server);
  status.stopping(stopping);
  return status;
}

TEST(ServerWatch, SeesNoServerBeforeOneSpeaks) {
  EXPECT_FALSE(ServerWatch().isThere(kStart));
}

TEST(ServerWatch, TrustsAServerForThreeSeconds) {
  ServerWatch watch;
  watch.see(statusOf(7), kStart);
  EXPECT_TRUE(watch.isThere(kStart + 3s));
  EXPECT_FALSE(watch.isThere(kStart + 3001ms));
  watch.see(statusOf(7), kStart + 10s);
  EXPECT_TRUE(watch.isThere(kStart + 10s));
}

TEST(ServerWatch, TakesAServersGoodbyeAtOnce) {
  ServerWatch watch;
  watch.see(statusOf(7), kStart);
  watch.see(statusOf(7, true), kStart + 10ms);
  EXPECT_FALSE(watch.isThere(kStart + 10ms));
}

TEST(ServerWatch, KeepsASecondServerThroughTheGoodbyeOfTheFirst) {
  ServerWatch watch;
  watch.see(statusOf(7), kStart);
  watch.see(statusOf(8), kStart);
  watch.see(statusOf(7, true), kStart + 1s);
  EXPECT_TRUE(watch.isThere(kStart + 1s));
}

}  // namespace
}  // namespace handgraft::bridge
