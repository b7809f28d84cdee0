#include "hardware/protocols/dynamixel_packet.h"

#include <numeric>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols::dynamixel {
namespace {

using test::ByteVector;
using test::framesIn;
using test::toHex;
using test::vectorOf;

// === A second implementation, bit by bit and by searching text

std::uint16_t divideBits(const ByteVector& bytes) {
  // The remainder of the message, times x^16, over x^16 + x^15 + x^2 + 1.
  std::vector<int> bits;
  for (const std::uint8_t byte : bytes) {
    for (int bit = 7; bit >= 0; --bit)
      bits.push_back(byte >> bit & 1);
  }
  bits.resize(bits.size() + 16, 0);
  for (std::size_t i = 0; i + 16 < bits.size(); ++i) {
    if (bits[i] == 0) continue;
    for (const std::size_t power : {16u, 15u, 2u, 0u})
      bits[i + 16 - power] ^= 1;
  }
  unsigned rest = 0;
  for (std::size_t i = bits.size() - 16; i < bits.size(); ++i)
    rest = rest << 1 | static_cast<unsigned>(bits[i]);
  return static_cast<std::uint16_t>(rest);
}

ByteVector wireOf(std::uint8_t id, std::uint8_t instruction, const ByteVector& parameters) {
  const std::string header = "\xFF\xFF\xFD";
  std::string body(1, static_cast<char>(instruction));
  body.append(parameters.begin(), parameters.end());
  for (std::size_t at = body.find(header); at != std::string::npos;
       at = body.find(header, at + 4)) {
    body.insert(at + 3, "\xFD");
  }
  const std::size_t length = body.size() + 2;
  ByteVector wire = {0xFF, 0xFF, 0xFD, 0x00, id};
  wire.push_back(static_cast<std::uint8_t>(length & 0xFF));
  wire.push_back(static_cast<std::uint8_t>(length >> 8));
  wire.insert(wire.end(), body.begin(), body.end());
  const std::uint16_t crc = divideBits(wire);
  wire.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  wire.push_back(static_cast<std::uint8_t>(crc >> 8));
  return wire;
}

ByteVector encoded(std::uint8_t id, std::uint8_t instruction, const ByteVector& parameters) {
  ByteBuffer out;
  encode({id, instruction, parameters}, out);
  return vectorOf(out.bytes());
}

/// Parameters full of what stuffing is about.
ByteVector randomParameters(std::mt19937& random) {
  const std::uint8_t some[] = {0xFF, 0xFD, 0x00, 0x7E};
  ByteVector parameters(random() % 40);
  for (std::uint8_t& byte : parameters)
    byte = random() % 8 == 0 ? static_cast<std::uint8_t>(random()) : some[random() % 4];
  return parameters;
}

// === CRC

TEST(DynamixelPacket, CrcHasThePublishedCheckValue) {
  EXPECT_EQ(crc16(test::bytesOf("123456789")), 0xFEE8);
}

TEST(DynamixelPacket, CrcIsTheRemainderOfALongDivision) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    ByteVector bytes(random() % 50);
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    ASSERT_EQ(crc16(bytes), divideBits(bytes)) << toHex(bytes);
  }
}

// === Encoding

TEST(DynamixelPacket, EncodesAsASecondImplementationDoes) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const auto id = static_cast<std::uint8_t>(random() % (kHighestId + 1));
    const auto instruction = static_cast<std::uint8_t>(random());
    const ByteVector parameters = randomParameters(random);
    ASSERT_EQ(encoded(id, instruction, parameters), wireOf(id, instruction, parameters))
        << toHex(parameters);
  }
}

TEST(DynamixelPacket, SyncWriteToEveryIdFitsWithAllItsStuffing) {
  ByteVector ids(kHighestId + 1);
  std::iota(ids.begin(), ids.end(), std::uint8_t{0});
  ByteVector data;
  for (std::size_t i = 0; i < ids.size(); ++i)
    data.insert(data.end(), {0xFF, 0xFF, 0xFD, 0xFF});
  ByteBuffer out;
  encodeSyncWrite(116, 4, ids, data, out);
  EXPECT_EQ(out.size(), 7u + 1 + 4 + 253 * 6 + 2);
  const auto found = framesIn<Framing>({vectorOf(out.bytes())});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].substr(0, 24), "fe837400040000fffffdff01");
}

TEST(DynamixelPacket, TooMuchIsABrokenContract) {
  const ByteVector data(ByteBuffer::kCapacity, 0);
  ByteBuffer out;
  EXPECT_THROW(encodeWrite(1, 116, data, out), BrokenContract);
  EXPECT_THROW(encodeSyncWrite(116, 4, ByteVector{1, 2}, ByteVector(4), out), BrokenContract);
}

// === Decoding

TEST(DynamixelPacket, ReadsBackWhatItWrote) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const auto id = static_cast<std::uint8_t>(random() % (kHighestId + 1));
    const auto instruction = static_cast<std::uint8_t>(random());
    const ByteVector parameters = randomParameters(random);
    const auto found = framesIn<Framing>({encoded(id, instruction, parameters)});
    ByteVector content = {id, instruction};
    content.insert(content.end(), parameters.begin(), parameters.end());
    ASSERT_EQ(found, std::vector<std::string>{toHex(content)});
  }
}

TEST(DynamixelPacket, IsFoundAtEverySplitAfterGarbageAndNeverWithAWrongBit) {
  const std::vector<ByteVector> garbage = {
      {0x00},
      {0xFF},
      {0xFF, 0xFF},
      {0xFF, 0xFF, 0xFD},
      {0xFF, 0xFF, 0xFD, 0x00},                          // a header alone
      {0xFF, 0xFF, 0xFD, 0x00, 0x01},                    // a header and an id
      {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x20, 0x00},        // a length that reaches into the next
      {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0xE0, 0x07, 0x55},  // a length that reaches beyond it
      {0xFF, 0xFF, 0xFD, 0xFD, 0x00}};
  for (const ByteVector& parameters :
       {ByteVector{}, ByteVector{0, 1, 2, 3}, ByteVector{0xFF, 0xFF, 0xFD},
        ByteVector{0, 0xFF, 0xFF, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD, 0x00, 0x01}}) {
    const ByteVector wire = encoded(7, 0x55, parameters);
    test::checkSplits<Framing>(wire);
    test::checkGarbageBefore<Framing>(wire, garbage);
    test::checkFlips<Framing>(wire);
  }
}

TEST(DynamixelPacket, BackToBackPacketsAreAllFound) {
  ByteVector stream;
  for (std::uint8_t id = 0; id < 20; ++id) {
    const ByteVector wire = encoded(id, 0x55, ByteVector(id, 0xFF));
    stream.insert(stream.end(), wire.begin(), wire.end());
  }
  EXPECT_EQ(framesIn<Framing>({stream}).size(), 20u);
  test::checkSplits<Framing>(stream);
}

TEST(DynamixelPacket, WithoutItsStuffingIsRefused) {
  // Right but for the missing FD, CRC included.
  ByteVector wire = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x55, 0x00, 0xFF, 0xFF, 0xFD};
  const std::uint16_t crc = divideBits(wire);
  wire.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  wire.push_back(static_cast<std::uint8_t>(crc >> 8));
  EXPECT_TRUE(framesIn<Framing>({wire}).empty());
}

TEST(DynamixelPacket, ImpossibleIdsAndLengthsAreRefused) {
  for (const std::uint8_t id : {std::uint8_t{0xFD}, std::uint8_t{0xFF}})
    EXPECT_TRUE(framesIn<Framing>({wireOf(id, 0x55, {0})}).empty()) << int{id};
  EXPECT_EQ(framesIn<Framing>({wireOf(kBroadcastId, 0x01, {})}).size(), 1u);

  StreamReader<Framing> reader;
  const ByteVector far = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0xFF, 0xFF, 0x55};
  reader.feed(far, [](Bytes) {
    FAIL();
  });
  EXPECT_EQ(reader.pending(), 0u) << "waits for 65,535 bytes";
}

// === Status packets

TEST(DynamixelPacket, StatusTellsAlertErrorAndData) {
  const ByteVector parameters = {0x84, 0x10, 0x20};
  const auto status = statusOf({9, 0x55, parameters});
  ASSERT_TRUE(status);
  EXPECT_EQ(status->id, 9);
  EXPECT_TRUE(status->alert);
  EXPECT_EQ(status->error, Error::kDataRange);
  EXPECT_EQ(vectorOf(status->data), (ByteVector{0x10, 0x20}));
}

TEST(DynamixelPacket, StatusRoundTrips) {
  const ByteVector data = {0xFF, 0xFF, 0xFD, 0x01};
  ByteBuffer out;
  encodeStatus({3, true, Error::kAccess, data}, out);
  StreamReader<Framing> reader;
  int count = 0;
  reader.feed(out.bytes(), [&](Bytes frame) {
    const auto status = statusOf(packetOf(frame));
    ASSERT_TRUE(status);
    EXPECT_TRUE(status->alert);
    EXPECT_EQ(status->error, Error::kAccess);
    EXPECT_EQ(vectorOf(status->data), data);
    ++count;
  });
  EXPECT_EQ(count, 1);
}

TEST(DynamixelPacket, InstructionsAndBroadcastsAreNoStatus) {
  const ByteVector parameters = {0x00};
  EXPECT_FALSE(statusOf({1, 0x01, parameters}));
  EXPECT_FALSE(statusOf({kBroadcastId, 0x55, parameters}));
  EXPECT_FALSE(statusOf({1, 0x55, {}}));
}

}  // namespace
}  // namespace handgraft::protocols::dynamixel
