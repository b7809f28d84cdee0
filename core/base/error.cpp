#include "core/base/error.h"

#include "core/base/utf8.h"

namespace handgraft {

std::string quoted(const std::string& text) {
  constexpr std::size_t kLongest = 200;
  return "'" + onOneLine(text, kLongest) + "'";
}

namespace detail {

void breakContract(const char* condition, const char* file, int line) {
  throw BrokenContract(fmt::format("{}:{}: broken contract: {}", file, line, condition));
}

}  // namespace detail

}  // namespace handgraft
