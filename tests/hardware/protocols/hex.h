#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "hardware/protocols/bytes.h"

namespace handgraft::test {

using ByteVector = std::vector<std::uint8_t>;

/// Bytes of pairs of hexadecimal digits; blanks between them do not matter.
inline ByteVector fromHex(const std::string& text) {
  std::string digits;
  for (const char c : text) {
    if (c != ' ' && c != '\n') digits += c;
  }
  if (digits.size() % 2 != 0) throw std::invalid_argument("odd number of digits: " + text);
  ByteVector bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  return bytes;
}

inline std::string toHex(protocols::Bytes bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

inline ByteVector vectorOf(protocols::Bytes bytes) {
  return {bytes.begin(), bytes.end()};
}

inline ByteVector bytesOf(const std::string& text) {
  return {text.begin(), text.end()};
}

}  // namespace handgraft::test
