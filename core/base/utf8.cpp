#include "core/base/utf8.h"

#include <algorithm>
#include <array>
#include <utility>

namespace handgraft {

namespace {

constexpr char32_t kNone = 0xFFFD;

using Range = std::pair<char32_t, char32_t>;

// As std::format has it (C++20, [format.string.std]).
constexpr std::array<Range, 14> kWide{{{0x1100, 0x115F},
                                       {0x2329, 0x232A},
                                       {0x2E80, 0x303E},
                                       {0x3040, 0xA4CF},
                                       {0xAC00, 0xD7A3},
                                       {0xF900, 0xFAFF},
                                       {0xFE10, 0xFE19},
                                       {0xFE30, 0xFE6F},
                                       {0xFF00, 0xFF60},
                                       {0xFFE0, 0xFFE6},
                                       {0x1F300, 0x1F64F},
                                       {0x1F900, 0x1F9FF},
                                       {0x20000, 0x2FFFD},
                                       {0x30000, 0x3FFFD}}};
// File names of some systems have their accents apart.
constexpr std::array<Range, 1> kCombining{{{0x0300, 0x036F}}};
constexpr std::array<Range, 4> kControl{
    {{0x00, 0x1F}, {0x7F, 0x9F}, {0x2028, 0x202E}, {0x2066, 0x2069}}};

template <std::size_t count>
bool isIn(const std::array<Range, count>& ranges, char32_t code) {
  return std::any_of(ranges.begin(), ranges.end(), [code](const Range& range) {
    return code >= range.first && code <= range.second;
  });
}

}  // namespace

Character takeCharacter(std::string_view& rest) {
  const auto byte_at = [&](std::size_t k) {
    return static_cast<unsigned char>(rest[k]);
  };
  const unsigned char first = byte_at(0);
  std::size_t size = 1;
  char32_t least = 0;  // a code written longer than it need be is none
  char32_t code = first;
  if (first >= 0xF0 && first < 0xF8) {
    size = 4;
    least = 0x10000;
    code = first & 0x07U;
  } else if (first >= 0xE0 && first < 0xF0) {
    size = 3;
    least = 0x800;
    code = first & 0x0FU;
  } else if (first >= 0xC0 && first < 0xE0) {
    size = 2;
    least = 0x80;
    code = first & 0x1FU;
  } else if (first >= 0x80) {
    code = kNone;
  }
  bool is_valid = code != kNone && size <= rest.size();
  for (std::size_t k = 1; is_valid && k < size; ++k) {
    is_valid = (byte_at(k) & 0xC0U) == 0x80;
    code = code << 6U | (byte_at(k) & 0x3FU);
  }
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (!is_valid || code < least || code > 0x10FFFF || is_surrogate) {
    size = 1;
    code = kNone;
  }
  const Character taken{rest.substr(0, size), code};
  rest.remove_prefix(size);
  return taken;
}

std::string_view withoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

bool isControl(char32_t code) {
  return isIn(kControl, code);
}

std::size_t columnsOf(std::string_view text) {
  std::size_t columns = 0;
  while (!text.empty()) {
    const char32_t code = takeCharacter(text).code;
    if (!isIn(kCombining, code)) columns += isIn(kWide, code) ? 2 : 1;
  }
  return columns;
}

std::string onOneLine(std::string_view text, std::size_t most) {
  std::string line;
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == most) return line + "...";
    const Character next = takeCharacter(text);
    const bool is_shown =
        !isControl(next.code) && (next.code != kNone || next.bytes.size() > 1);
    line += is_shown ? next.bytes : std::string_view("?");
  }
  return line;
}

}  // namespace handgraft
