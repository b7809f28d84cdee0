// Which server is asked, and whether it lives, on a clock of its own.
#include "idl/cyclone/known_server.h"

#include <gtest/gtest.h>

namespace handgraft::idl::cyclone {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class KnownServerTest : public testing::Test {
 protected:
  void hear(std::uint64_t id, bool is_stopping = false, const std::string& name = "lab") {
    v1::ServerStatus status;
    status.server_id(id);
    status.name(name);
    status.stopping(is_stopping);
    status.protocol_version(v1::PROTOCOL_VERSION);
    server.hear(status);
  }

  [[nodiscard]] std::uint64_t known() const {
    return server.status() ? server.status()->server_id() : 0;
  }

  KnownServer::Clock::time_point now{std::chrono::hours(1)};
  KnownServer server{"lab", [this] {
                       return now;
                     }};
};

TEST_F(KnownServerTest, IsNoneBeforeItIsHeard) {
  EXPECT_FALSE(server.isAlive());
  EXPECT_EQ(known(), 0u);
  hear(7, false, "another");
  EXPECT_EQ(known(), 0u);
}

TEST_F(KnownServerTest, LivesWhileItIsHeard) {
  hear(7);
  now += milliseconds(2999);
  EXPECT_TRUE(server.isAlive());
  server.hearAnswer();
  now += milliseconds(2999);
  EXPECT_TRUE(server.isAlive());
  now += milliseconds(1);
  EXPECT_FALSE(server.isAlive());
}

TEST_F(KnownServerTest, IsGoneAtOnceWhereItSaysSo) {
  hear(7);
  hear(7, true);
  EXPECT_FALSE(server.isAlive());
}

TEST_F(KnownServerTest, StaysTheOneWhoeverElseSaysThatHeIsOne) {
  hear(7);
  hear(8);
  EXPECT_EQ(known(), 7u);
  EXPECT_TRUE(server.isIt(7));
  EXPECT_FALSE(server.isIt(8));
}

TEST_F(KnownServerTest, IsFollowedByTheOtherOnceItIsGone) {
  hear(7);
  now += seconds(2);
  hear(8);
  now += seconds(1);
  server.succeed();
  EXPECT_EQ(known(), 8u);
  EXPECT_TRUE(server.isAlive());
}

TEST_F(KnownServerTest, IsNotFollowedByOneThatIsSilentItself) {
  hear(7);
  hear(8);
  now += seconds(4);
  server.succeed();
  EXPECT_EQ(known(), 7u);
}

TEST_F(KnownServerTest, IsNotBlamedForWhatWeDidNotHear) {
  hear(7);
  now += seconds(10);
  server.forgive(seconds(9));
  EXPECT_TRUE(server.isAlive());
  server.forgive(seconds(60));  // never later than now
  now += seconds(3);
  EXPECT_FALSE(server.isAlive());
}

TEST_F(KnownServerTest, IsSilentSinceItWasAskedAtMost) {
  hear(7);
  now += seconds(10);
  EXPECT_EQ(server.silenceSince(now - seconds(4)), seconds(4));
  EXPECT_EQ(server.silenceSince(now - seconds(40)), seconds(10));
}

TEST_F(KnownServerTest, HasToSpeakOurProtocol) {
  EXPECT_NO_THROW(server.requireSameVersion());
  v1::ServerStatus status;
  status.server_id(7);
  status.name("lab");
  status.protocol_version(v1::PROTOCOL_VERSION + 1);
  server.hear(status);
  EXPECT_THROW(server.requireSameVersion(), Refused);
}

TEST_F(KnownServerTest, CountsItsStarts) {
  EXPECT_EQ(server.start(), 0u);
  const auto say = [this](double uptime_s) {
    v1::ServerStatus status;
    status.server_id(5);
    status.name("lab");
    status.uptime_s(uptime_s);
    status.protocol_version(v1::PROTOCOL_VERSION);
    server.hear(status);
  };
  say(10.0);
  say(11.0);
  EXPECT_EQ(server.start(), 1u);
  say(0.2);  // on its store it is the same one
  EXPECT_EQ(server.start(), 2u);
  say(1.2);
  EXPECT_EQ(server.start(), 2u);
}

}  // namespace
}  // namespace handgraft::idl::cyclone
