// What waits for Fast DDS, by turns of who sent it.
#include "server/transport/fair_queue.h"

#include <algorithm>
#include <thread>

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

constexpr std::size_t kFlood = 1000;

FairQueue::Sender sender(std::uint8_t last, std::uint32_t port = 7411) {
  FairQueue::Sender one;
  one.address[15] = last;
  one.port = port;
  return one;
}

std::vector<std::uint8_t> datagram(std::uint8_t number, std::size_t size = 100) {
  std::vector<std::uint8_t> bytes(size);
  bytes[0] = number;
  return bytes;
}

TEST(FairQueue, KeepsTheOrderOfOneSender) {
  FairQueue queue;
  for (std::uint8_t i = 0; i < 10; ++i)
    EXPECT_TRUE(queue.push(sender(1), datagram(i)));
  for (std::uint8_t i = 0; i < 10; ++i)
    EXPECT_EQ(queue.pop()->bytes, datagram(i));
}

TEST(FairQueue, LetsNobodyWaitBehindAFlood) {
  FairQueue queue;
  for (std::size_t i = 0; i < kFlood; ++i) {
    queue.push(sender(1), datagram(0));
    queue.push(sender(1, 7413), datagram(0));  // the same host's other program
    queue.push(sender(2), datagram(0));
  }
  queue.push(sender(3), datagram(42));
  queue.push(sender(3), datagram(43));
  int before = 0;
  std::vector<std::uint8_t> calm;
  while (calm.size() < 2) {
    const auto next = queue.pop();
    if (next->sender == sender(3))
      calm.push_back(next->bytes[0]);
    else
      ++before;
  }
  EXPECT_EQ(calm, (std::vector<std::uint8_t>{42, 43}));
  EXPECT_LE(before, 2 * 3);
}

TEST(FairQueue, LeavesOutWhatIsBeyondASendersPart) {
  FairQueue queue(10'000, 100'000);
  std::size_t taken = 0;
  for (std::size_t i = 0; i < kFlood; ++i)
    taken += queue.push(sender(1), datagram(0)) ? 1 : 0;
  EXPECT_GT(taken, 10U);
  EXPECT_LT(taken, 100U);
  EXPECT_TRUE(queue.push(sender(2), datagram(1)));
  // Room comes back as they are taken.
  queue.pop();
  queue.pop();
  EXPECT_TRUE(queue.push(sender(1), datagram(2)));
}

TEST(FairQueue, TakesOneThatIsLargerThanASendersPart) {
  FairQueue queue(1'000, 100'000);
  EXPECT_TRUE(queue.push(sender(1), datagram(0, 60'000)));
  EXPECT_FALSE(queue.push(sender(1), datagram(0)));
  EXPECT_EQ(queue.pop()->bytes.size(), 60'000U);
}

TEST(FairQueue, TakesRoomFromWhoHasMostWhereThereIsNone) {
  constexpr std::size_t kMost = 100'000;
  FairQueue queue(50'000, kMost);
  for (std::uint8_t who = 1; who <= 3; ++who) {
    for (std::size_t i = 0; i < kFlood; ++i)
      queue.push(sender(who), datagram(0));
  }
  // Both are among the first of five turns.
  EXPECT_TRUE(queue.push(sender(4), datagram(42)));
  EXPECT_TRUE(queue.push(sender(5), datagram(43)));
  int calm = 0;
  for (int i = 0; i < 5; ++i)
    calm += queue.pop()->bytes[0] >= 42 ? 1 : 0;
  EXPECT_EQ(calm, 2);
  EXPECT_LE(queue.bytes(), kMost);
}

TEST(FairQueue, EndsWhoWaitsWhenItIsShut) {
  FairQueue queue;
  std::thread waits([&] {
    EXPECT_FALSE(queue.pop());
  });
  queue.shut();
  waits.join();
  EXPECT_FALSE(queue.push(sender(1), datagram(0)));
}

// === What tells where a sender stands, and nothing else

void add(std::vector<std::uint8_t>& bytes,
         std::uint8_t kind,
         const std::vector<std::uint8_t>& body,
         std::uint8_t flags = 1) {
  bytes.insert(bytes.end(), {kind, flags, static_cast<std::uint8_t>(body.size()), 0});
  bytes.insert(bytes.end(), body.begin(), body.end());
}

std::vector<std::uint8_t> message() {
  std::vector<std::uint8_t> bytes{'R', 'T', 'P', 'S', 2, 1, 1, 16};
  bytes.resize(20, 9);
  return bytes;
}

std::vector<std::uint8_t> heartbeat(std::uint8_t writer,
                                    std::uint8_t newest,
                                    std::uint8_t flags = 1) {
  std::vector<std::uint8_t> bytes = message();
  std::vector<std::uint8_t> body(28);
  body[6] = writer;
  body[20] = newest;
  add(bytes, 0x07, body, flags);
  return bytes;
}

std::vector<std::uint8_t> sample(std::uint8_t number) {
  std::vector<std::uint8_t> bytes = message();
  std::vector<std::uint8_t> body(32);
  body[20] = number;
  add(bytes, 0x15, body);
  const auto told = heartbeat(2, number);
  bytes.insert(bytes.end(), told.begin() + 20, told.end());
  return bytes;
}

/// As Cyclone DDS says 50 times a second that it waits for an answer.
TEST(FairQueue, SamplesDoNotWaitBehindWhatIsSaidAgain) {
  FairQueue queue;
  std::size_t waiting = 0;
  for (std::uint8_t i = 0; i < 20; ++i) {
    queue.push(sender(1), sample(i));
    for (int k = 0; k < 50; ++k) {
      queue.push(sender(1), heartbeat(2, i));
      queue.push(sender(1), heartbeat(3, 0));
    }
    waiting += 1;
  }
  std::vector<std::vector<std::uint8_t>> heard;
  for (std::size_t i = 0; i < waiting + 2; ++i)
    heard.push_back(queue.pop()->bytes);
  EXPECT_EQ(queue.bytes(), 0u);
  for (const auto& newest : {heartbeat(2, 19), heartbeat(3, 0)})
    EXPECT_EQ(std::erase(heard, newest), 1u);
  for (std::uint8_t i = 0; i < waiting; ++i)
    EXPECT_EQ(heard[i], sample(i));
}

/// A quarter of the turns, and all where nothing else waits.
TEST(FairQueue, HeartbeatsDoNotHoldUpOthersSamplesNorStarve) {
  FairQueue queue;
  for (std::uint8_t k = 0; k < 40; ++k)
    queue.push(sender(k), heartbeat(2, 1));
  for (std::uint8_t k = 100; k < 112; ++k)
    queue.push(sender(k), sample(1));
  int samples = 0;
  int heartbeats = 0;
  while (samples < 12) {
    const bool is_sample = queue.pop()->bytes == sample(1);
    samples += is_sample ? 1 : 0;
    heartbeats += is_sample ? 0 : 1;
  }
  EXPECT_GE(heartbeats, 3);
  EXPECT_LE(heartbeats, 4);
  for (; heartbeats < 40; ++heartbeats)
    EXPECT_EQ(queue.pop()->bytes, heartbeat(2, 1));
  EXPECT_EQ(queue.bytes(), 0u);
}

TEST(FairQueue, KeepsWhatDiffersOrIsAskedForOtherwise) {
  FairQueue queue;
  std::vector<std::uint8_t> cut = heartbeat(2, 1);
  cut.resize(cut.size() - 5);
  const std::vector<std::vector<std::uint8_t>> others = {sample(1), sample(1), cut, cut};
  const std::vector<std::vector<std::uint8_t>> heartbeats = {heartbeat(2, 1), heartbeat(3, 1),
                                                             heartbeat(2, 1, 3)};
  for (const auto* some : {&heartbeats, &others})
    for (const auto& one : *some)
      queue.push(sender(1), one);
  std::vector<std::vector<std::uint8_t>> all;
  for (std::size_t i = 0; i < others.size() + heartbeats.size(); ++i)
    all.push_back(queue.pop()->bytes);
  for (const auto& one : heartbeats)
    EXPECT_EQ(std::count(all.begin(), all.end(), one), 1);
  for (const auto& one : others)
    EXPECT_EQ(std::count(all.begin(), all.end(), one), 2);
  EXPECT_EQ(queue.bytes(), 0u);
}

}  // namespace
}  // namespace handgraft::server
