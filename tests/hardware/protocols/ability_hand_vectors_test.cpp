// Frames of the vendor's own client, and streams recorded from hands, both ways.

#include <array>
#include <string>

#include "hardware/protocols/ability_hand.h"

#include "tests/hardware/protocols/shared_vectors.h"
#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols::ability_hand {
namespace {

using test::ByteVector;
using test::framesIn;
using test::toHex;

/// Every frame of the file, stuffed: commands, and the recorded replies.
std::vector<ByteVector> allFrames() {
  const auto vectors = test::sharedVectors().at("ah");
  std::vector<ByteVector> frames;
  for (const auto& entry : vectors.at("commands")) {
    for (const ByteVector& wire : test::bytesOfAll(entry.at("stuffed")))
      frames.push_back(wire);
  }
  for (const auto& entry : vectors.at("decode")) {
    const ByteVector whole = test::fromHex(entry.at("unstuffed"));
    ByteBuffer wire;
    encodeFrame(Bytes(whole).first(whole.size() - 1), wire);
    frames.push_back(test::vectorOf(wire.bytes()));
  }
  return frames;
}

TEST(AbilityHandVectors, CommandsAreEncodedFromTheirMeaning) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  constexpr std::uint8_t kAt = kDefaultAddress;
  constexpr double kDegree = 150.0 / 32767.0;
  const auto motors = [](Mode mode, Reply reply, std::array<double, 6> values, double unit,
                         std::int16_t largest = kLargestCount) {
    Counts counts;
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] = countsOf(values[i], unit, largest);
    ByteBuffer out;
    encodeCommand(kAt, mode, reply, counts, out);
    return toHex(out.bytes());
  };
  const auto position = [&](Reply reply, std::array<double, 6> values) {
    return motors(Mode::kPosition, reply, values, kDegree);
  };
  const auto other = [](auto encode_into) {
    ByteBuffer out;
    encode_into(out);
    return toHex(out.bytes());
  };
  constexpr Reply kOne = Reply::kTouchCurrent, kTwo = Reply::kTouchVelocity,
                  kThree = Reply::kMotors;
  const auto read_only = [&](Reply reply) {
    return other([=](ByteBuffer& out) {
      encodeReadOnly(kAt, reply, out);
    });
  };
  const auto simple = [&](Simple command) {
    return other([=](ByteBuffer& out) {
      encodeSimple(kAt, command, out);
    });
  };
  ByteBuffer raw;
  encodeCommand(kAt, Mode::kPosition, kOne, {0x7E7D, 0x007D, 0x007E, 0, 0, 0}, raw);

  const std::vector<std::vector<std::string>> expected = {
      {position(kOne, {0, 0, 0, 0, 0, 0})},
      {position(kOne, {30, 30, 30, 30, 30, -30})},
      {position(kThree, {15, 15, 15, 15, 15, -15})},
      {position(kTwo, {10, 20, 30, 40, 50, -60})},
      {position(kOne, {200, -200, 150, -150, 0.5, -0.5})},
      {toHex(raw.bytes())},
      {motors(Mode::kVelocity, kThree, {100, 100, 100, 100, 100, -100}, 3000.0 / 32767.0)},
      {motors(Mode::kTorque, kThree, {0.5, 0.5, 0.5, 0.5, 0.5, -0.5}, kAmperePerCount)},
      {motors(Mode::kVoltage, kOne, {50, 50, 50, 50, 50, -50}, 100.0 / kLargestVoltage)},
      {motors(Mode::kVoltage, kOne, {150, -150, 0, 0, 0, 0}, 100.0 / kLargestVoltage,
              kLargestVoltage)},
      {simple(Simple::kExitApi)},
      {simple(Simple::kUpsampleThumbOn)},
      {read_only(kOne), read_only(kTwo), read_only(kThree)},
      {other([](ByteBuffer& out) {
         encodeGrip(kAt, 0x01, 0xFF, out);
       }),
       other([](ByteBuffer& out) {
         encodeGrip(kAt, 0x00, 0x40, out);
       })},
      {other([](ByteBuffer& out) {
         encodeReadRegister(kAt, 0x3D, out);
       }),
       other([](ByteBuffer& out) {
         encodeWriteRegister(kAt, 1, 1000, out);
       })},
  };
  const auto commands = test::sharedVectors().at("ah").at("commands");
  ASSERT_EQ(commands.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(commands[i].at("stuffed").get<std::vector<std::string>>(), expected[i])
        << commands[i].at("case");
  }
}

TEST(AbilityHandVectors, FramesAreReadAndWrittenBack) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  for (const ByteVector& wire : allFrames()) {
    const auto found = framesIn<Framing>({wire});
    ASSERT_EQ(found.size(), 1u) << toHex(wire);
    const ByteVector content = test::fromHex(found[0]);
    ByteBuffer again;
    encodeFrame(content, again);
    EXPECT_EQ(toHex(again.bytes()), toHex(wire));
    const auto command = commandOf(content);
    if (!command || !command->counts) continue;
    encodeCommand(command->address, command->mode(), command->reply(), *command->counts, again);
    EXPECT_EQ(toHex(again.bytes()), toHex(wire));
  }
}

TEST(AbilityHandVectors, AreFoundAtEverySplitAndAfterGarbage) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  const std::vector<ByteVector> garbage = {
      {0x00}, {0x00, 0x00, 0x00}, {0x7E}, {0x7D}, {0x7E, 0x50, 0x10, 0x7D}, {0x12, 0x34, 0x56}};
  for (const ByteVector& wire : allFrames()) {
    test::checkSplits<Framing>(wire);
    test::checkGarbageBefore<Framing>(wire, garbage);
  }
}

TEST(AbilityHandVectors, AWrongBitIsNeverAccepted) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  for (const ByteVector& wire : allFrames())
    test::checkFlips<Framing>(wire);
}

TEST(AbilityHandVectors, RecordedRepliesDecodeToWhatTheHandMeant) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  const auto vectors = test::sharedVectors();
  for (const auto& entry : vectors.at("ah").at("decode")) {
    const ByteVector whole = test::fromHex(entry.at("unstuffed"));
    const auto state = stateOf(Bytes(whole).first(whole.size() - 1));
    ASSERT_TRUE(state);
    EXPECT_EQ(static_cast<int>(state->reply) + 1, entry.at("variant").get<int>());
    EXPECT_EQ(state->position, entry.at("pos").get<Counts>());
    EXPECT_EQ(state->velocity, entry.at("vel").get<Counts>());
    if (entry.contains("cur")) {
      EXPECT_EQ(state->current, entry.at("cur").get<Counts>());
    }
    if (entry.contains("touch")) {
      EXPECT_EQ(state->touch, (entry.at("touch").get<std::array<std::uint16_t, 30>>()));
    }
    EXPECT_EQ(state->limited, entry.at("hot").get<int>());

    ByteBuffer again, expected;
    encodeState(*state, again);
    encodeFrame(Bytes(whole).first(whole.size() - 1), expected);
    EXPECT_EQ(toHex(again.bytes()), toHex(expected.bytes()));
  }
}

/// Valid replies after each read of a recorded stream.
void checkStream(const char* name) {
  const auto stream = test::sharedVectors().at("ah").at(name);
  StreamReader<Framing> reader;
  int count = 0;
  std::vector<int> counts;
  ByteVector whole;
  for (const ByteVector& piece : test::bytesOfAll(stream.at("reads"))) {
    reader.feed(piece, [&](Bytes content) {
      count += stateOf(content).has_value() ? 1 : 0;
    });
    counts.push_back(count);
    whole.insert(whole.end(), piece.begin(), piece.end());
  }
  EXPECT_EQ(counts, stream.at("cumulative_valid").get<std::vector<int>>());
  test::checkSplits<Framing>(whole);
}

TEST(AbilityHandVectors, RecordedUartStreamIsFoundReadByRead) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  checkStream("stream_uart");
}

TEST(AbilityHandVectors, RecordedRs485StreamLosesItsDamagedFrameAlone) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  checkStream("stream_rs485");
}

}  // namespace
}  // namespace handgraft::protocols::ability_hand
