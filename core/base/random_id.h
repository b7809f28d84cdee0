#pragma once

#include <cstdint>

namespace handgraft {

/// The smallest and the largest that `randomId` gives: all have 16 digits, so that none is
/// mistaken for a count, and all are below 2^53, so that they survive JSON in a browser, where
/// numbers are doubles.
inline constexpr std::uint64_t kSmallestId = 1'000'000'000'000'000;
inline constexpr std::uint64_t kLargestId = (std::uint64_t{1} << 53) - 1;

/// An id that nobody guesses and that never comes twice: one of 8e15, from the system's own
/// source of randomness. Threads: any.
std::uint64_t randomId();

}  // namespace handgraft
