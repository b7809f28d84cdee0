#include "core/hand/content_hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace handgraft::hand {

namespace {

/// The first 32 bits of the fractional parts of the cube roots of the first 64 primes.
std::array<std::uint32_t, 64> makeRoundConstants() {
  std::array<std::uint32_t, 64> constants{};
  std::size_t count = 0;
  for (std::uint32_t candidate = 2; count < constants.size(); ++candidate) {
    bool is_prime = true;
    for (std::uint32_t d = 2; d * d <= candidate; ++d)
      is_prime = is_prime && candidate % d != 0;
    if (!is_prime) continue;
    // The largest x with x^3 <= p * 2^96, by bisection in whole numbers; its lower half is
    // wanted.
    __extension__ using Wide = unsigned __int128;
    const Wide target = static_cast<Wide>(candidate) << 96U;
    std::uint64_t low = 0;
    std::uint64_t high = 1ULL << 35U;
    while (low + 1 < high) {
      const std::uint64_t middle = (low + high) / 2;
      const Wide cube = static_cast<Wide>(middle) * middle * middle;
      (cube <= target ? low : high) = middle;
    }
    constants[count++] = static_cast<std::uint32_t>(low);
  }
  return constants;
}

}  // namespace

void ContentHash::compress(const unsigned char* block) {
  static const std::array<std::uint32_t, 64> kRound = makeRoundConstants();
  std::array<std::uint32_t, 64> w{};
  for (std::size_t i = 0; i < 16; ++i)
    w[i] = static_cast<std::uint32_t>(block[4 * i]) << 24U |
           static_cast<std::uint32_t>(block[4 * i + 1]) << 16U |
           static_cast<std::uint32_t>(block[4 * i + 2]) << 8U |
           static_cast<std::uint32_t>(block[4 * i + 3]);
  for (std::size_t i = 16; i < 64; ++i) {
    const std::uint32_t s0 =
        std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3U);
    const std::uint32_t s1 =
        std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10U);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state_;
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + kRound[i] + w[i];
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g;
    g = f;
    f = e;
    e = d + t1;
    d = c;
    c = b;
    b = a;
    a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> mixed{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i)
    state_[i] += mixed[i];
}

void ContentHash::add(std::string_view bytes) {
  while (!bytes.empty()) {
    const auto used = static_cast<std::size_t>(length_ % 64);
    const std::size_t taken = std::min(bytes.size(), 64 - used);
    std::memcpy(block_.data() + used, bytes.data(), taken);
    length_ += taken;
    bytes.remove_prefix(taken);
    if (length_ % 64 == 0) compress(block_.data());
  }
}

std::string ContentHash::finish() {
  const std::uint64_t bits = 8 * length_;
  std::string tail(1, '\x80');
  tail.append((119 - length_ % 64) % 64, '\0');
  for (unsigned byte = 8; byte-- > 0;)
    tail.push_back(static_cast<char>(bits >> (8 * byte) & 0xFFU));
  add(tail);
  std::string digits;
  for (const std::uint32_t word : state_)
    digits += fmt::format("{:08x}", word);
  return digits;
}

}  // namespace handgraft::hand
