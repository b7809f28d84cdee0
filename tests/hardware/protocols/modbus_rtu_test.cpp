// Modbus RTU, and the registers of an Inspire hand, held against frames computed elsewhere:
// those of the protocol's own documents, and the ones of ../shared/hardware.

#include "hardware/protocols/modbus_rtu.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "hardware/protocols/inspire_table.h"

#include "tests/hardware/protocols/hex.h"
#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols::modbus {
namespace {

using handgraft::test::ByteVector;
using handgraft::test::fromHex;
using handgraft::test::toHex;
using handgraft::test::vectorOf;

/// What the reader finds in `bytes`, fed in pieces of `size`.
template <class F>
std::vector<ByteVector> framesIn(const ByteVector& bytes, std::size_t size) {
  StreamReader<F> reader;
  std::vector<ByteVector> frames;
  const auto use = [&](Bytes frame) {
    frames.push_back(vectorOf(frame));
  };
  for (std::size_t at = 0; at < bytes.size(); at += size)
    reader.feed(Bytes(bytes).subspan(at, std::min(size, bytes.size() - at)), use);
  reader.settle(use);
  return frames;
}

TEST(ModbusRtu, TheCrcIsThatOfTheSpecification) {
  // MODBUS over serial line V1.02, 6.2.2: device 2, function 7 has the CRC 0x1241, sent 41 12.
  EXPECT_EQ(crcOf(fromHex("02 07")), 0x1241);
  const ByteVector text = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crcOf(text), 0x4B37) << "CRC-16/MODBUS of the usual check text";
}

TEST(ModbusRtu, WritesAnInspireHandsAnglesAsOthersDo) {
  const std::array<std::uint16_t, 6> open = {1000, 1000, 1000, 1000, 1000, 1000};
  ByteBuffer out;
  encodeWrite(1, inspire::kAngleSet, open, out);
  EXPECT_EQ(toHex(vectorOf(out.bytes())),
            toHex(fromHex("01 10 05 CE 00 06 0C 03 E8 03 E8 03 E8 03 E8 03 E8 03 E8 22 EF")));
  const auto frames = framesIn<ReplyFraming>(fromHex("01 10 05 CE 00 06 21 38"), 3);
  ASSERT_EQ(frames.size(), 1u);
  const auto reply = replyOf(frames[0]);
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(reply->function, kWriteRegisters);
  EXPECT_EQ(reply->address, inspire::kAngleSet);
}

TEST(ModbusRtu, WhatIsEncodedComesBackAtEverySplitAndAfterGarbage) {
  std::mt19937 random(5);
  for (int k = 0; k < 200; ++k) {
    std::vector<std::uint16_t> values(1 + random() % kMostRegisters);
    for (std::uint16_t& value : values)
      value = static_cast<std::uint16_t>(random());
    ByteBuffer out;
    encodeReadReply(7, values, out);
    ByteVector wire = fromHex("00 FF 55");
    const ByteVector frame = vectorOf(out.bytes());
    wire.insert(wire.end(), frame.begin(), frame.end());
    for (const std::size_t size : {std::size_t{1}, std::size_t{5}, wire.size()}) {
      bool is_found = false;
      for (const ByteVector& content : framesIn<ReplyFraming>(wire, size)) {
        const auto reply = replyOf(content);
        if (!reply || reply->device != 7 || reply->values.size() != 2 * values.size()) continue;
        is_found = true;
        for (std::size_t i = 0; i < values.size(); ++i)
          EXPECT_EQ(registerAt(reply->values, i), values[i]);
      }
      EXPECT_TRUE(is_found);
    }
    encodeWrite(9, 1486, values, out);
    const auto requests = framesIn<RequestFraming>(vectorOf(out.bytes()), 4);
    ASSERT_EQ(requests.size(), 1u);
    const auto request = requestOf(requests[0]);
    ASSERT_TRUE(request.has_value());
    EXPECT_EQ(request->count, values.size());
    EXPECT_EQ(registerAt(request->values, values.size() - 1), values.back());
  }
}

TEST(ModbusRtu, AnyWrongBitIsFound) {
  ByteBuffer out;
  encodeReadReply(1, std::array<std::uint16_t, 6>{0, 200, 400, 600, 800, 1000}, out);
  const ByteVector frame = vectorOf(out.bytes());
  for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
    ByteVector wrong = frame;
    wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ 1U << bit % 8);
    for (const ByteVector& found : framesIn<ReplyFraming>(wrong, wrong.size()))
      EXPECT_NE(found.size(), frame.size() - 2) << "bit " << bit;
  }
}

TEST(ModbusRtu, AnExceptionIsAReply) {
  ByteVector wire = fromHex("01 83 02");
  const std::uint16_t crc = crcOf(wire);
  wire.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  wire.push_back(static_cast<std::uint8_t>(crc >> 8));
  const auto frames = framesIn<ReplyFraming>(wire, 2);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(replyOf(frames[0])->exception, 2);
}

TEST(ModbusRtu, SurvivesAMillionRandomBytes) {
  std::mt19937 random(11);
  StreamReader<ReplyFraming> replies;
  StreamReader<RequestFraming> requests;
  long found = 0;
  for (int k = 0; k < 2000; ++k) {
    ByteVector noise(500);
    for (std::uint8_t& byte : noise)
      byte = static_cast<std::uint8_t>(random());
    replies.feed(noise, [&](Bytes frame) {
      static_cast<void>(replyOf(frame));
      ++found;
    });
    requests.feed(noise, [&](Bytes frame) {
      static_cast<void>(requestOf(frame));
    });
  }
  EXPECT_LT(found, 20) << "one in 65536 of what looks like a frame passes its CRC";
}

}  // namespace
}  // namespace handgraft::protocols::modbus
