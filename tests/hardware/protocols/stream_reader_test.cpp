#include "hardware/protocols/stream_reader.h"

#include <random>

#include <gtest/gtest.h>

#include "hardware/protocols/ability_hand.h"
#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/slcan.h"

#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols {
namespace {

using test::ByteVector;

/// Bytes as hostile as they come: random, or of those that mean something.
class Hostile {
 public:
  Hostile(unsigned seed, ByteVector special) : random_(seed), special_(std::move(special)) {}

  ByteVector next() {
    ByteVector bytes(1 + random_() % 700);
    for (std::uint8_t& byte : bytes) {
      byte = random_() % 2 == 0 ? static_cast<std::uint8_t>(random_())
                                : special_[random_() % special_.size()];
    }
    return bytes;
  }

 private:
  std::mt19937 random_;
  ByteVector special_;
};

/// Feeds a million bytes, with a frame now and then; every one of those that ends before the
/// next nonsense begins is found once the reader is told that nothing follows.
template <class F, class Use>
void feedAMillion(ByteVector special, const ByteVector& wire, Use use) {
  const std::string content = test::framesIn<F>({wire}).back();
  Hostile hostile(7, std::move(special));
  StreamReader<F> reader;
  std::size_t fed = 0;
  int lost = 0;
  for (int round = 0; fed < 1000000; ++round) {
    const ByteVector bytes = hostile.next();
    fed += bytes.size();
    reader.feed(bytes, use);
    ASSERT_LT(reader.pending(), F::kLongest);
    bool found = false;
    const auto look = [&](Bytes frame) {
      found = found || test::toHex(frame) == content;
      use(frame);
    };
    reader.feed(wire, look);
    reader.settle(look);
    lost += found ? 0 : 1;
  }
  EXPECT_EQ(lost, 0);
  EXPECT_GT(reader.counters().garbage_bytes, fed / 10);
}

TEST(StreamReader, DynamixelSurvivesAMillionBytes) {
  ByteBuffer wire;
  dynamixel::encodePing(3, wire);
  feedAMillion<dynamixel::Framing>(
      {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x55}, test::vectorOf(wire.bytes()), [](Bytes frame) {
        // What is accepted is what encoding gives, bit for bit.
        ByteBuffer again;
        dynamixel::encode(dynamixel::packetOf(frame), again);
        EXPECT_EQ(test::framesIn<dynamixel::Framing>({test::vectorOf(again.bytes())}),
                  std::vector<std::string>{test::toHex(frame)});
      });
}

TEST(StreamReader, AbilityHandSurvivesAMillionBytes) {
  ByteBuffer wire;
  ability_hand::encodeState({}, wire);
  feedAMillion<ability_hand::Framing>({0x7E, 0x7D, 0x00, 0x12}, test::vectorOf(wire.bytes()),
                                      [](Bytes content) {
                                        static_cast<void>(ability_hand::stateOf(content));
                                        static_cast<void>(ability_hand::commandOf(content));
                                      });
}

TEST(StreamReader, SlcanSurvivesAMillionBytes) {
  // A line is found only after the end of the one before: hence the CR in front.
  feedAMillion<slcan::Framing>(test::bytesOf("tTrR0123456789ABCDEFabcdef\r\a"),
                               test::bytesOf("\at02C2AB01\r"), [](Bytes content) {
                                 static_cast<void>(slcan::lineOf(content));
                               });
}

TEST(StreamReader, CountsWhatItFound) {
  ByteBuffer wire;
  dynamixel::encodePing(3, wire);
  ByteVector stream = {1, 2, 3};
  const ByteVector good = test::vectorOf(wire.bytes());
  ByteVector bad = good;
  bad.at(bad.size() - 1) ^= 1;
  for (const ByteVector& part : {good, bad, good})
    stream.insert(stream.end(), part.begin(), part.end());
  StreamReader<dynamixel::Framing> reader;
  reader.feed(stream, [](Bytes) {});
  EXPECT_EQ(reader.counters().frames, 2u);
  EXPECT_EQ(reader.counters().damaged, 1u);
  EXPECT_EQ(reader.counters().garbage_bytes, 3 + bad.size());
}

TEST(StreamReader, SettlingFindsWhatAFalseStartHid) {
  ByteBuffer wire;
  dynamixel::encodePing(3, wire);
  ByteVector stream = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x00, 0x04, 0x55};  // wants 1,024 bytes
  stream.insert(stream.end(), wire.bytes().begin(), wire.bytes().end());
  StreamReader<dynamixel::Framing> reader;
  int count = 0;
  const auto use = [&](Bytes) {
    ++count;
  };
  reader.feed(stream, use);
  EXPECT_EQ(count, 0);
  EXPECT_EQ(reader.pending(), stream.size());
  reader.settle(use);
  EXPECT_EQ(count, 1);
  EXPECT_EQ(reader.pending(), 0u);
}

TEST(StreamReader, ClearingForgetsABegunFrame) {
  ByteBuffer wire;
  dynamixel::encodePing(3, wire);
  StreamReader<dynamixel::Framing> reader;
  int count = 0;
  const auto use = [&](Bytes) {
    ++count;
  };
  reader.feed(wire.bytes().first(5), use);
  reader.clear();
  reader.feed(wire.bytes().subspan(5), use);
  reader.settle(use);
  EXPECT_EQ(count, 0);
}

}  // namespace
}  // namespace handgraft::protocols
