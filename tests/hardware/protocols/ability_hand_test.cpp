#include "hardware/protocols/ability_hand.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols::ability_hand {
namespace {

using test::ByteVector;
using test::framesIn;
using test::toHex;
using test::vectorOf;

// A second implementation, by replacing text.
ByteVector wireOf(const ByteVector& content) {
  unsigned sum = 0;
  for (const std::uint8_t byte : content)
    sum += byte;
  ByteVector plain = content;
  plain.push_back(static_cast<std::uint8_t>((256 - sum % 256) % 256));
  ByteVector wire = {0x7E};
  for (const std::uint8_t byte : plain) {
    if (byte == 0x7E) {
      wire.insert(wire.end(), {0x7D, 0x5E});
    } else if (byte == 0x7D) {
      wire.insert(wire.end(), {0x7D, 0x5D});
    } else {
      wire.push_back(byte);
    }
  }
  wire.push_back(0x7E);
  return wire;
}

ByteVector framed(const ByteVector& content) {
  ByteBuffer out;
  encodeFrame(content, out);
  return vectorOf(out.bytes());
}

ByteVector randomContent(std::mt19937& random) {
  const std::uint8_t some[] = {0x7E, 0x7D, 0x5E, 0x5D};
  ByteVector content(2 + random() % 80);
  for (std::uint8_t& byte : content)
    byte = random() % 2 == 0 ? static_cast<std::uint8_t>(random()) : some[random() % 4];
  return content;
}

State randomState(std::mt19937& random, Reply reply) {
  const auto count = [&] {
    return static_cast<std::int16_t>(random());
  };
  State state;
  state.reply = reply;
  state.header = static_cast<std::uint8_t>(0x10 | static_cast<int>(reply));
  for (std::size_t i = 0; i < kMotorCount; ++i) {
    state.position[i] = count();
    if (reply != Reply::kTouchVelocity) state.current[i] = count();
    if (reply != Reply::kTouchCurrent) state.velocity[i] = count();
  }
  if (reply != Reply::kMotors) {
    for (std::uint16_t& reading : state.touch)
      reading = random() & 0xFFF;
  }
  state.limited = random() & 0x3F;
  return state;
}

State readState(const ByteVector& wire) {
  StreamReader<Framing> reader;
  std::optional<State> state;
  reader.feed(wire, [&](Bytes content) {
    state = stateOf(content);
  });
  if (!state) throw std::runtime_error("no state in " + toHex(wire));
  return *state;
}

TEST(AbilityHand, FramesAsASecondImplementationDoes) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const ByteVector content = randomContent(random);
    ASSERT_EQ(framed(content), wireOf(content));
    ASSERT_EQ(framesIn<Framing>({framed(content)}), std::vector<std::string>{toHex(content)});
  }
}

TEST(AbilityHand, NothingButEscapesFits) {
  const ByteVector content(100, 0x7E);
  EXPECT_GE(framed(content).size(), 202u);
  EXPECT_EQ(framesIn<Framing>({framed(content)}), std::vector<std::string>{toHex(content)});
}

TEST(AbilityHand, AnEscapedChecksumIsReadBack) {
  const ByteVector content = {0x50, 0x82 - 0x50};  // sums up to 0x82: the checksum is 0x7E
  EXPECT_EQ(toHex(framed(content)), "7e50327d5e7e");
  EXPECT_EQ(framesIn<Framing>({framed(content)}), std::vector<std::string>{toHex(content)});
}

TEST(AbilityHand, IsFoundAtEverySplitAndAfterGarbage) {
  const std::vector<ByteVector> garbage = {{0x00},
                                           {0x7E},
                                           {0x7D},
                                           {0x7E, 0x00, 0x00},
                                           {0x7E, 0x7D},
                                           {0x7E, 0x50, 0x10, 0x22, 0x33},
                                           {0x12, 0x34, 0x56, 0x78},
                                           {0x7E, 0x7E, 0x7E}};
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const ByteVector wire = framed(randomContent(random));
    test::checkSplits<Framing>(wire);
    test::checkGarbageBefore<Framing>(wire, garbage);
  }
}

TEST(AbilityHand, AWrongBitIsNeverAcceptedAsAReply) {
  std::mt19937 random(3);
  for (const Reply reply : {Reply::kTouchCurrent, Reply::kTouchVelocity, Reply::kMotors}) {
    for (int i = 0; i < 20; ++i) {
      ByteBuffer wire;
      encodeState(randomState(random, reply), wire);
      for (std::size_t at = 0; at < wire.size(); ++at) {
        for (int bit = 0; bit < 8; ++bit) {
          ByteVector wrong = vectorOf(wire.bytes());
          wrong[at] = static_cast<std::uint8_t>(wrong[at] ^ 1 << bit);
          StreamReader<Framing> reader;
          const auto refuse = [&](Bytes content) {
            EXPECT_FALSE(stateOf(content))
                << "bit " << bit << " of byte " << at << " of " << toHex(wire.bytes());
          };
          reader.feed(wrong, refuse);
          reader.settle(refuse);
        }
      }
    }
  }
}

TEST(AbilityHand, OneFlagMayEndOneFrameAndBeginTheNext) {
  ByteVector stream = framed({0x50, 0x7C});
  stream.pop_back();
  const ByteVector next = framed({0x50, 0xA2});
  stream.insert(stream.end(), next.begin(), next.end());
  EXPECT_EQ(framesIn<Framing>({stream}), (std::vector<std::string>{"507c", "50a2"}));
}

TEST(AbilityHand, AnEscapeCutOffByAFlagDoesNotReachIntoTheNextFrame) {
  ByteVector stream = {0x7E, 0x12, 0x34, 0x56, 0x7D};
  const ByteVector next = framed({0x50, 0xA2});
  stream.insert(stream.end(), next.begin(), next.end());
  EXPECT_EQ(framesIn<Framing>({stream}), std::vector<std::string>{"50a2"});
}

TEST(AbilityHand, NulsBetweenFramesAreNoDamage) {
  ByteVector stream = {0x00};
  for (int i = 0; i < 5; ++i) {
    const ByteVector wire = framed({0x50, 0xA2});
    stream.insert(stream.end(), wire.begin(), wire.end());
    stream.insert(stream.end(), {0x00, 0x00});
  }
  StreamReader<Framing> reader;
  int count = 0;
  reader.feed(stream, [&](Bytes) {
    ++count;
  });
  EXPECT_EQ(count, 5);
  EXPECT_EQ(reader.counters().damaged, 0u);
}

TEST(AbilityHand, CommandsAreReadBack) {
  std::mt19937 random(4);
  for (const Mode mode : {Mode::kPosition, Mode::kVelocity, Mode::kTorque, Mode::kVoltage}) {
    for (const Reply reply : {Reply::kTouchCurrent, Reply::kTouchVelocity, Reply::kMotors}) {
      Counts counts;
      for (std::int16_t& count : counts)
        count = static_cast<std::int16_t>(static_cast<int>(random() % 65535) - 32767);
      ByteBuffer wire;
      encodeCommand(0x51, mode, reply, counts, wire);
      StreamReader<Framing> reader;
      int found = 0;
      reader.feed(wire.bytes(), [&](Bytes content) {
        const auto command = commandOf(content);
        ASSERT_TRUE(command);
        EXPECT_EQ(command->address, 0x51);
        EXPECT_EQ(command->mode(), mode);
        EXPECT_EQ(command->reply(), reply);
        EXPECT_EQ(command->counts, counts);
        ++found;
      });
      EXPECT_EQ(found, 1);
    }
  }
}

TEST(AbilityHand, TheMostNegativeCountIsNeverSent) {
  ByteBuffer out;
  const Counts counts = {0, 0, std::numeric_limits<std::int16_t>::min(), 0, 0, 0};
  EXPECT_THROW(encodeCommand(0x50, Mode::kPosition, Reply::kMotors, counts, out),
               BrokenContract);
  EXPECT_THROW(encodeCommand(0x50, Mode::kReadOnly, Reply::kMotors, Counts{}, out),
               BrokenContract);
}

TEST(AbilityHand, RepliesAreReadBack) {
  std::mt19937 random(5);
  for (const Reply reply : {Reply::kTouchCurrent, Reply::kTouchVelocity, Reply::kMotors}) {
    for (int i = 0; i < 200; ++i) {
      const State sent = randomState(random, reply);
      ByteBuffer wire;
      encodeState(sent, wire);
      const State got = readState(vectorOf(wire.bytes()));
      EXPECT_EQ(got.header, sent.header);
      EXPECT_EQ(got.position, sent.position);
      EXPECT_EQ(got.current, sent.current);
      EXPECT_EQ(got.velocity, sent.velocity);
      EXPECT_EQ(got.touch, sent.touch);
      EXPECT_EQ(got.limited, sent.limited);
    }
  }
}

TEST(AbilityHand, TouchReadingsArePackedAsOneNumberLowBitsFirst) {
  // Reading i is 1 << (i % 12): bit 12 i + i % 12 of the 360-bit number, and no other.
  State state;
  state.reply = Reply::kTouchCurrent;
  ByteVector expected(45, 0);
  for (std::size_t i = 0; i < kTouchCount; ++i) {
    state.touch[i] = static_cast<std::uint16_t>(1 << i % 12);
    const std::size_t bit = 12 * i + i % 12;
    expected[bit / 8] = static_cast<std::uint8_t>(expected[bit / 8] | 1 << bit % 8);
  }
  ByteBuffer wire;
  encodeState(state, wire);
  const std::string content = framesIn<Framing>({vectorOf(wire.bytes())}).at(0);
  EXPECT_EQ(content.substr(2 * 25, 90), toHex(expected));
}

TEST(AbilityHand, OtherLengthsAndHeadersAreNoReply) {
  EXPECT_FALSE(stateOf(ByteVector{}));
  EXPECT_FALSE(stateOf(ByteVector(2, 0)));   // NULs of an RS-485 adapter have a right checksum
  EXPECT_FALSE(stateOf(ByteVector(38, 0)));  // header 0
  EXPECT_FALSE(stateOf(ByteVector(37, 0x12)));
  EXPECT_FALSE(stateOf(ByteVector(71, 0x12)));  // the length of another variant
  EXPECT_FALSE(stateOf(ByteVector(38, 0x13)));
  EXPECT_TRUE(stateOf(ByteVector(38, 0x12)));
  EXPECT_TRUE(stateOf(ByteVector(71, 0x11)));
}

TEST(AbilityHand, CountsAreCutTowardsZeroAndClamped) {
  constexpr double kDegree = 150.0 / 32767.0;
  EXPECT_EQ(countsOf(150.0, kDegree), 32767);
  EXPECT_EQ(countsOf(0.5, kDegree), 109);  // 109.22
  EXPECT_EQ(countsOf(-0.5, kDegree), -109);
  EXPECT_EQ(countsOf(1e9, kDegree), 32767);
  EXPECT_EQ(countsOf(-1e9, kDegree), -32767);
  EXPECT_EQ(countsOf(-150.0, 100.0 / kLargestVoltage, kLargestVoltage), -3546);
  EXPECT_THROW(countsOf(std::nan(""), kDegree), BrokenContract);
}

TEST(AbilityHand, TouchForceIsZeroUntouchedAndGrowsWithPressure) {
  EXPECT_EQ(touchForce(0), 0.0);
  // At full scale 3.3 V fall off: 33000 / 3.3 + 10000 = 20 kOhm.
  EXPECT_NEAR(touchForce(4095), 121591.0 / 20000.0 + 0.878894, 2e-3);
  for (std::uint16_t reading = 1; reading < 4095; ++reading)
    ASSERT_LT(touchForce(reading), touchForce(static_cast<std::uint16_t>(reading + 1)));
}

}  // namespace
}  // namespace handgraft::protocols::ability_hand
