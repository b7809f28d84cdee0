// Whom a server asks for acknowledgements, and how often.
#include "server/transport/heartbeat_throttle.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kServer = 1;
constexpr std::uint8_t kClient = 2;
constexpr std::uint8_t kWriter = 0x03;

Bytes prefix(std::uint8_t who) {
  return Bytes(12, who);
}

Bytes header(std::uint8_t source) {
  Bytes bytes{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  const Bytes from = prefix(source);
  bytes.insert(bytes.end(), from.begin(), from.end());
  return bytes;
}

void add(Bytes& bytes, std::uint8_t kind, const Bytes& body) {
  bytes.insert(bytes.end(), {kind, 1, static_cast<std::uint8_t>(body.size()), 0});
  bytes.insert(bytes.end(), body.begin(), body.end());
}

/// As Fast DDS sends them: for one reader's participant, with its own statistics behind.
Bytes heartbeat(std::uint8_t whom, std::uint8_t writer = kWriter, std::uint8_t kind = 0x03) {
  Bytes bytes = header(kServer);
  add(bytes, 0x0e, prefix(whom));
  Bytes body(28);
  body[4] = 0;
  body[6] = writer;
  body[7] = kind;
  add(bytes, 0x07, body);
  add(bytes, 0x80, Bytes(56));
  return bytes;
}

Bytes withSample(std::uint8_t whom) {
  Bytes bytes = header(kServer);
  add(bytes, 0x0e, prefix(whom));
  add(bytes, 0x15, Bytes(32));
  add(bytes, 0x07, Bytes(28));
  return bytes;
}

class HeartbeatThrottleTest : public testing::Test {
 protected:
  /// Heartbeats that go out in so long, one tried every 10 ms.
  int sent(milliseconds time, const Bytes& datagram) {
    int count = 0;
    for (const auto end = now + time; now < end; now += milliseconds(10))
      count += peers.maySend(datagram, now) ? 1 : 0;
    return count;
  }

  HeartbeatThrottle peers;
  HeartbeatThrottle::Clock::time_point now{std::chrono::hours(1)};
};

TEST_F(HeartbeatThrottleTest, WhoAnswersIsAskedAsOftenAsTheWriterWants) {
  peers.hear(header(kClient), now);
  EXPECT_EQ(sent(milliseconds(400), heartbeat(kClient)), 40);
  peers.hear(header(kClient), now);
  EXPECT_EQ(sent(milliseconds(400), heartbeat(kClient)), 40);
}

TEST_F(HeartbeatThrottleTest, WhoIsSilentIsAskedEverMoreSeldomByEachWriter) {
  peers.hear(header(kClient), now);
  now += std::chrono::seconds(1);
  // At once, after 1, 3 and 7 s, and every 4 s from then on.
  EXPECT_EQ(sent(std::chrono::seconds(20), heartbeat(kClient)), 7);
  EXPECT_EQ(sent(std::chrono::seconds(4), heartbeat(kClient, 0x04)), 3);
  peers.hear(header(kClient), now);
  EXPECT_EQ(sent(milliseconds(100), heartbeat(kClient)), 10);
}

TEST_F(HeartbeatThrottleTest, AHundredWhoAnswerShareWhatTenAreAsked) {
  constexpr std::uint8_t kMany = 100;
  const auto all_speak = [&] {
    for (std::uint8_t who = 0; who < kMany; ++who)
      peers.hear(header(static_cast<std::uint8_t>(kClient + who)), now);
  };
  all_speak();
  now += std::chrono::seconds(1);
  all_speak();
  EXPECT_EQ(sent(milliseconds(400), heartbeat(kClient)), 4);
  EXPECT_EQ(sent(milliseconds(400), withSample(kClient)), 40);
  all_speak();
  // Discovery's writers ask seldom of themselves.
  EXPECT_EQ(sent(milliseconds(400), heartbeat(kClient, kWriter, 0xc2)), 40);
}

TEST_F(HeartbeatThrottleTest, WhoHasJustComeIsAskedAsOftenAsTheWriterWants) {
  for (std::uint8_t who = 0; who < 100; ++who)
    peers.hear(header(static_cast<std::uint8_t>(100 + who)), now);
  now += std::chrono::seconds(1);
  for (std::uint8_t who = 0; who < 100; ++who)
    peers.hear(header(static_cast<std::uint8_t>(100 + who)), now);
  peers.hear(header(kClient), now);
  EXPECT_EQ(sent(milliseconds(300), heartbeat(kClient)), 30);
  // From then on once in 100 ms, as of a hundred who are asked like ten.
  EXPECT_EQ(sent(milliseconds(200), heartbeat(kClient)), 2);
}

TEST_F(HeartbeatThrottleTest, HoldsNothingElseBack) {
  peers.hear(header(kClient), now);
  now += std::chrono::seconds(1);
  EXPECT_EQ(sent(std::chrono::seconds(1), withSample(kClient)), 100);
  EXPECT_EQ(sent(std::chrono::seconds(1), header(kServer)), 100);
  EXPECT_EQ(sent(std::chrono::seconds(1), Bytes{1, 2, 3}), 100);
}

TEST_F(HeartbeatThrottleTest, WhomItHasNotHeardYetIsAskedAsOftenAsTheWriterWants) {
  EXPECT_EQ(sent(std::chrono::seconds(1), heartbeat(kClient)), 100);
}

/// Without INFO_DST: of a writer of discovery, for everybody.
Bytes heartbeatForAll(std::uint8_t newest) {
  Bytes bytes = header(kServer);
  Bytes body(28);
  body[6] = 0x03;
  body[7] = 0xc2;
  body[20] = newest;
  add(bytes, 0x07, body);
  add(bytes, 0x80, Bytes(56));
  return bytes;
}

TEST_F(HeartbeatThrottleTest, ManyAreToldTogetherOnceATurnUnlessThereIsNews) {
  EXPECT_EQ(sent(milliseconds(1000), heartbeatForAll(7)), 100) << "few may be told at will";
  for (std::uint8_t who = 10; who < 110; ++who)
    peers.hear(header(who), now);
  now += milliseconds(1100);
  peers.hear(header(10), now);  // counts who lives
  EXPECT_LE(sent(milliseconds(1000), heartbeatForAll(7)), 11);
  for (std::uint8_t newest = 8; newest < 28; ++newest)
    EXPECT_TRUE(peers.maySend(heartbeatForAll(newest), now));
}

}  // namespace
}  // namespace handgraft::server
