#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "core/base/error.h"

namespace handgraft::protocols {

using Bytes = std::span<const std::uint8_t>;

/// Bytes of one frame, in a fixed store: building and reading frames never allocates.
/// Errors: BrokenContract if more than `kCapacity` bytes are put in.
class ByteBuffer {
 public:
  /// A Dynamixel sync write of a position to all 253 ids, with all the stuffing it can need,
  /// is 1,532 bytes.
  static constexpr std::size_t kCapacity = 2048;

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] bool empty() const { return size_ == 0; }

  [[nodiscard]] Bytes bytes() const { return {bytes_.data(), size_}; }

  [[nodiscard]] std::uint8_t operator[](std::size_t i) const { return bytes_[i]; }

  void clear() { size_ = 0; }

  void push(std::uint8_t byte) {
    HANDGRAFT_REQUIRE(size_ < kCapacity);
    bytes_[size_++] = byte;
  }

  /// Errors: BrokenContract if it is empty.
  void pop() {
    HANDGRAFT_REQUIRE(size_ > 0);
    --size_;
  }

  void append(Bytes bytes) {
    HANDGRAFT_REQUIRE(bytes.size() <= kCapacity - size_);
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += bytes.size();
  }

  /// Appends a number, low byte first; floats as IEEE 754.
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    append(raw);
  }

 private:
  std::array<std::uint8_t, kCapacity> bytes_{};  // only [0, size_) is ever read
  std::size_t size_ = 0;
};

/// The number at `offset`, low byte first. Errors: BrokenContract beyond the end.
template <class T>
[[nodiscard]] T numberAt(Bytes bytes, std::size_t offset) {
  static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
  HANDGRAFT_REQUIRE(offset <= bytes.size() && sizeof(T) <= bytes.size() - offset);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

}  // namespace handgraft::protocols
