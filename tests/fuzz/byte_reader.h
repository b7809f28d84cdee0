#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace handgraft::fuzz {

/// Takes numbers from the front of an input; zeros after its end.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  [[nodiscard]] std::size_t left() const { return size_ - cursor_; }

  template <class T>
  T take() {
    T value{};
    const std::size_t count = std::min(sizeof(T), left());
    std::memcpy(&value, bytes_ + cursor_, count);
    cursor_ += count;
    return value;
  }

  /// At most `most` of what is left.
  std::string_view takeText(std::size_t most = static_cast<std::size_t>(-1)) {
    const std::size_t count = std::min(most, left());
    const std::string_view text(reinterpret_cast<const char*>(bytes_ + cursor_), count);
    cursor_ += count;
    return text;
  }

 private:
  const std::uint8_t* bytes_;
  std::size_t size_;
  std::size_t cursor_ = 0;
};

}  // namespace handgraft::fuzz
