#pragma once

#include <cstdint>
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

/// A request or an edit that was asked for before those that are remembered.
[[noreturn]] inline void rejectForgotten(const char* what, std::uint64_t id) {
  reject(v1::ERROR_OUTCOME_UNKNOWN,
         "{} {} was asked for long ago; what came of it is not remembered", what, id);
}

}  // namespace handgraft::server
