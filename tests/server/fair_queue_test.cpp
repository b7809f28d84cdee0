// What waits for Fast DDS, by turns of who sent it.
#include "server/transport/fair_queue.h"

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

}  // namespace
}  // namespace handgraft::server
