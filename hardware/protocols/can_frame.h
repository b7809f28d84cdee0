#pragma once

#include <array>
#include <cstdint>

#include "hardware/protocols/bytes.h"

namespace handgraft::protocols {

/// One frame of classic CAN. Bytes from `size` on are 0, so that frames compare as they are.
struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 if `is_extended`
  bool is_extended = false;
  bool is_remote = false;  ///< asks for a frame of this id; carries no data
  std::uint8_t size = 0;   ///< 0..8; of a remote frame: how many bytes it asks for
  std::array<std::uint8_t, 8> data{};

  [[nodiscard]] Bytes bytes() const {
    return {data.data(), is_remote ? std::size_t{0} : std::size_t{size}};
  }

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

inline constexpr std::uint32_t kHighestStandardId = 0x7FF;
inline constexpr std::uint32_t kHighestExtendedId = 0x1FFFFFFF;

/// Errors: BrokenContract for more than 8 bytes.
inline CanFrame makeCanFrame(std::uint32_t id, Bytes bytes) {
  HANDGRAFT_REQUIRE(bytes.size() <= 8);
  CanFrame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

}  // namespace handgraft::protocols
