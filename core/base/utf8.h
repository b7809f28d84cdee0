#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace handgraft {

/// One character of a text that should be UTF-8.
struct Character {
  std::string_view bytes;
  char32_t code = 0;  ///< U+FFFD for a byte that belongs to no character
};

/// Takes the character that `rest`, which is not empty, begins with: a byte alone where it is
/// no valid UTF-8.
Character takeCharacter(std::string_view& rest);

/// Without the mark that some programs (spreadsheets) begin a text with.
std::string_view withoutByteOrderMark(std::string_view text);

/// Of C0, C1 and DEL, and what breaks lines or turns their direction.
bool isControl(char32_t code);

/// How many columns of a terminal a text takes: two for East Asian wide characters, none for
/// accents that combine with the letter before.
std::size_t columnsOf(std::string_view text);

/// `text` on one line: control characters, and bytes that are no UTF-8, are shown as `?`. One
/// of more than `most` characters is cut behind them and ends in `...`.
std::string onOneLine(std::string_view text, std::size_t most = std::string_view::npos);

}  // namespace handgraft
