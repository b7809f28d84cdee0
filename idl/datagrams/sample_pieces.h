#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <vector>

namespace handgraft::idl {

/// Puts small samples together again that come in fragments, so that they can be looked at
/// whole.
///
/// Memory: kMostAtOnce of kLargest; the one that grew longest ago gives way. Threads: one.
class SamplePieces {
 public:
  static constexpr std::size_t kLargest = 32UL * 1024;  ///< bytes of a sample
  static constexpr std::size_t kMostAtOnce = 64;
  static constexpr std::chrono::seconds kLongest{10};  ///< between its pieces

  struct Piece {
    std::array<std::uint8_t, 12> source{};  ///< participant
    std::int64_t number = 0;                ///< of the sample
    std::uint32_t first = 0;                ///< of its fragments, from 1
    std::uint32_t size = 0;                 ///< of a fragment but the last, bytes
    std::uint32_t whole = 0;                ///< bytes of the sample
    std::span<const std::uint8_t> bytes;    ///< of one fragment or several in a row
  };

  /// The sample once it is complete. What does not fit what came before of it is left out.
  std::optional<std::vector<std::uint8_t>> add(const Piece& piece);

 private:
  using Clock = std::chrono::steady_clock;

  struct Begun {
    std::array<std::uint8_t, 12> source{};
    std::int64_t number = 0;
    std::uint32_t size = 0;
    std::vector<std::uint8_t> bytes;
    std::vector<bool> is_there;  ///< of each fragment
    Clock::time_point grown;
  };

  std::list<Begun> begun_;  ///< grown longest ago first
};

}  // namespace handgraft::idl
