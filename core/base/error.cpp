#include "core/base/error.h"

namespace handgraft {

std::string quoted(const std::string& text) {
  constexpr std::size_t kLongest = 200;
  std::string line = text.substr(0, kLongest);
  for (char& c : line) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = '?';
  }
  if (text.size() > kLongest) line += "...";
  return "'" + line + "'";
}

namespace detail {

void breakContract(const char* condition, const char* file, int line) {
  throw BrokenContract(fmt::format("{}:{}: broken contract: {}", file, line, condition));
}

}  // namespace detail

}  // namespace handgraft
