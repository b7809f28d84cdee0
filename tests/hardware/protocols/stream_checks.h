#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hardware/protocols/stream_reader.h"

#include "tests/hardware/protocols/hex.h"

namespace handgraft::test {

/// What a reader finds in `pieces`, fed one after the other; then nothing more comes.
template <class F>
std::vector<std::string> framesIn(const std::vector<ByteVector>& pieces) {
  protocols::StreamReader<F> reader;
  std::vector<std::string> found;
  const auto keep = [&](protocols::Bytes frame) {
    found.push_back(toHex(frame));
  };
  for (const ByteVector& piece : pieces)
    reader.feed(piece, keep);
  reader.settle(keep);
  return found;
}

/// The stream gives the same frames wherever it is split in two, and byte by byte.
template <class F>
void checkSplits(const ByteVector& stream) {
  const std::vector<std::string> whole = framesIn<F>({stream});
  ASSERT_FALSE(whole.empty()) << toHex(stream);
  std::vector<ByteVector> crumbs;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const auto middle = stream.begin() + static_cast<std::ptrdiff_t>(i);
    const std::vector<ByteVector> halves = {{stream.begin(), middle}, {middle, stream.end()}};
    EXPECT_EQ(framesIn<F>(halves), whole) << "split at " << i << " of " << toHex(stream);
    crumbs.push_back({stream[i]});
  }
  EXPECT_EQ(framesIn<F>(crumbs), whole) << toHex(stream);
}

/// The last frame found is that of `wire` whatever of `garbage` comes before.
template <class F>
void checkGarbageBefore(const ByteVector& wire, const std::vector<ByteVector>& garbage) {
  const std::vector<std::string> clean = framesIn<F>({wire});
  ASSERT_EQ(clean.size(), 1u) << toHex(wire);
  for (const ByteVector& before : garbage) {
    const std::vector<std::string> found = framesIn<F>({before, wire});
    ASSERT_FALSE(found.empty()) << toHex(before) << " before " << toHex(wire);
    EXPECT_EQ(found.back(), clean[0]) << toHex(before) << " before " << toHex(wire);
  }
}

/// No frame is found if any one bit of `wire` is wrong.
template <class F>
void checkFlips(const ByteVector& wire) {
  for (std::size_t i = 0; i < wire.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      ByteVector wrong = wire;
      wrong[i] = static_cast<std::uint8_t>(wrong[i] ^ 1 << bit);
      EXPECT_EQ(framesIn<F>({wrong}), std::vector<std::string>())
          << "bit " << bit << " of byte " << i << " of " << toHex(wire);
    }
  }
}

}  // namespace handgraft::test
