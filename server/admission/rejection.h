#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "idl/common.h"

namespace handgraft::server {

/// A request that is sound but cannot be met: an unknown name, a conflict, too much at once.
/// Wrong input is InvalidInput, as everywhere.
class Rejection : public std::runtime_error {
 public:
  Rejection(v1::ErrorCode code, const std::string& message)
      : std::runtime_error(message), code_(code) {}

  [[nodiscard]] v1::ErrorCode code() const { return code_; }

 private:
  v1::ErrorCode code_;
};

/// Throws a Rejection with a formatted message.
template <class... Args>
[[noreturn]] void reject(v1::ErrorCode code,
                         fmt::format_string<Args...> format,
                         Args&&... args) {
  throw Rejection(code, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace handgraft::server
