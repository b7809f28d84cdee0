#include "hardware/protocols/slcan.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "hardware/protocols/socket_can_frame.h"

#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols {
namespace {

using slcan::Framing;
using slcan::Line;
using test::bytesOf;
using test::ByteVector;
using test::framesIn;

std::string textOf(const CanFrame& frame) {
  ByteBuffer out;
  slcan::encode(frame, out);
  return {out.bytes().begin(), out.bytes().end()};
}

Line lineOf(const std::string& text) {
  return slcan::lineOf(bytesOf(text));
}

CanFrame randomFrame(std::mt19937& random) {
  CanFrame frame;
  frame.is_extended = random() % 2 == 0;
  frame.is_remote = random() % 3 == 0;
  frame.id = static_cast<std::uint32_t>(
      random() % ((frame.is_extended ? kHighestExtendedId : kHighestStandardId) + 1));
  frame.size = static_cast<std::uint8_t>(random() % 9);
  for (std::size_t i = 0; i < frame.bytes().size(); ++i)
    frame.data[i] = static_cast<std::uint8_t>(random());
  return frame;
}

TEST(Slcan, WritesLettersDigitsAndReturn) {
  CanFrame frame = makeCanFrame(0x2C, ByteVector{0xAB, 0x01});
  EXPECT_EQ(textOf(frame), "t02C2AB01\r");
  frame.is_extended = true;
  EXPECT_EQ(textOf(frame), "T0000002C2AB01\r");
  frame.is_remote = true;
  EXPECT_EQ(textOf(frame), "R0000002C2\r");
  frame.is_extended = false;
  EXPECT_EQ(textOf(frame), "r02C2\r");
}

TEST(Slcan, ReadsBackWhatItWrote) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const CanFrame frame = randomFrame(random);
    const Line line = lineOf(textOf(frame));
    ASSERT_EQ(line.kind, Line::Kind::kFrame);
    ASSERT_EQ(line.frame, frame) << textOf(frame);
  }
}

TEST(Slcan, TakesDigitsOfEitherCaseAndReadsOverTimeStamps) {
  const CanFrame frame = makeCanFrame(0x2C, ByteVector{0xAB, 0x01});
  EXPECT_EQ(lineOf("t02c2ab01\r").frame, frame);
  EXPECT_EQ(lineOf("t02C2AB011F3a\r").frame, frame);
  EXPECT_EQ(lineOf("t02C2AB01xyzw\r").kind, Line::Kind::kOther);
}

TEST(Slcan, KnowsAnswers) {
  EXPECT_EQ(lineOf("\r").kind, Line::Kind::kDone);
  EXPECT_EQ(lineOf("z\r").kind, Line::Kind::kDone);
  EXPECT_EQ(lineOf("Z\r").kind, Line::Kind::kDone);
  EXPECT_EQ(lineOf("\a").kind, Line::Kind::kError);
  EXPECT_EQ(lineOf("V1013\r").kind, Line::Kind::kOther);
}

TEST(Slcan, RefusesWhatIsNoFrame) {
  for (const char* text :
       {"t\r", "t02\r", "t02C\r", "t02C9\r", "t02C2AB\r", "t02C2AB0\r", "t02C2AB0G\r",
        "t02C2AB0102\r", "t8001AA\r", "tG2C0\r", "T200000001AA\r", "r02C2AB0\r",
        "d123A30313233343536373839303132333435\r", "t02C2AB01"}) {
    EXPECT_EQ(lineOf(text).kind, Line::Kind::kOther) << text;
  }
}

TEST(Slcan, LinesAreFoundAtEverySplitAndAfterGarbage) {
  test::checkSplits<Framing>(bytesOf("t02C2AB01\r\r\az\rr0298\r"));
  test::checkGarbageBefore<Framing>(bytesOf("t02C2AB01\r"),
                                    {bytesOf("\r"), bytesOf("\a"), bytesOf("t02C2A\a"),
                                     bytesOf("t0\r"), bytesOf(std::string(500, 'x') + "\r")});
}

// There is no checksum: a wrong digit gives another frame, but never the one that was sent.
TEST(Slcan, AWrongBitNeverGivesTheFrameThatWasSent) {
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    const CanFrame frame = randomFrame(random);
    const ByteVector wire = bytesOf(textOf(frame));
    for (std::size_t at = 0; at < wire.size(); ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        ByteVector wrong = wire;
        wrong[at] = static_cast<std::uint8_t>(wrong[at] ^ 1 << bit);
        const bool is_other_case =
            (wire[at] ^ wrong[at]) == 0x20 && wire[at] >= 'A' && wire[at] <= 'F' && at > 0;
        if (is_other_case) continue;  // the same digit
        for (const std::string& found : framesIn<Framing>({wrong})) {
          const Line line = slcan::lineOf(test::fromHex(found));
          EXPECT_FALSE(line.kind == Line::Kind::kFrame && line.frame == frame)
              << std::string(wrong.begin(), wrong.end());
        }
      }
    }
  }
}

TEST(Slcan, EndlessLinesAreDropped) {
  StreamReader<Framing> reader;
  int count = 0;
  for (int i = 0; i < 10000; ++i) {
    reader.feed(bytesOf("t"), [&](Bytes) {
      ++count;
    });
    ASSERT_LT(reader.pending(), Framing::kLongest);
  }
  EXPECT_EQ(count, 0);
  reader.feed(bytesOf("\rt02C0\r"), [&](Bytes) {
    ++count;
  });
  EXPECT_GE(count, 1);
}

// Whoever forgets the front of a line that is too long must not take its end for a frame.
TEST(Slcan, TheEndOfAnEndlessLineIsNoFrame) {
  for (std::size_t length = 20; length < 200; ++length) {
    const ByteVector line = bytesOf(std::string(length, 'x') + "t02C0\r");
    test::checkSplits<Framing>(line);
    for (const std::string& found : framesIn<Framing>({line}))
      EXPECT_EQ(slcan::lineOf(test::fromHex(found)).kind, Line::Kind::kOther) << length;
  }
}

TEST(Slcan, KnowsTheBitRates) {
  EXPECT_EQ(slcan::bitRateDigit(10000), 0);
  EXPECT_EQ(slcan::bitRateDigit(500000), 6);
  EXPECT_EQ(slcan::bitRateDigit(1000000), 8);
  EXPECT_EQ(slcan::bitRateDigit(123456), -1);
}

TEST(CanFrame, EncodingRefusesWhatCanCannotCarry) {
  ByteBuffer out;
  CanFrame frame;
  frame.id = 0x800;
  EXPECT_THROW(slcan::encode(frame, out), BrokenContract);
  EXPECT_THROW(toSocketCan(frame), BrokenContract);
  EXPECT_THROW(makeCanFrame(1, ByteVector(9)), BrokenContract);
}

// === The other carrier

TEST(SocketCanFrame, RoundTrips) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const CanFrame frame = randomFrame(random);
    const SocketCanMessage message = fromSocketCan(toSocketCan(frame));
    ASSERT_FALSE(message.is_error);
    ASSERT_EQ(message.frame, frame);
  }
}

TEST(SocketCanFrame, HasTheKernelsFlags) {
  CanFrame frame = makeCanFrame(0x123, ByteVector{1, 2, 3});
  struct can_frame raw = toSocketCan(frame);
  EXPECT_EQ(raw.can_id, 0x123u);
  EXPECT_EQ(raw.can_dlc, 3);
  EXPECT_EQ(raw.data[2], 3);
  frame.is_extended = frame.is_remote = true;
  raw = toSocketCan(frame);
  EXPECT_EQ(raw.can_id, 0x123u | 0x80000000u | 0x40000000u);
}

TEST(SocketCanFrame, TellsTroubleOnTheBus) {
  struct can_frame raw {};

  raw.can_id = 0x20000000u | 0x40u;  // CAN_ERR_FLAG, CAN_ERR_BUSOFF
  const SocketCanMessage message = fromSocketCan(raw);
  EXPECT_TRUE(message.is_error);
  EXPECT_EQ(message.error, 0x40u);
}

TEST(SocketCanFrame, TakesLengthsBeyondEightForEight) {
  struct can_frame raw {};

  raw.can_dlc = 15;
  EXPECT_EQ(fromSocketCan(raw).frame.size, 8);
}

}  // namespace
}  // namespace handgraft::protocols
