#pragma once

#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace handgraft {

/// The input is wrong: a file, a name, a number. The message names the thing, its value and the
/// permitted range, on one line; it is shown to the user as it is.
class InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Our own mistake: a precondition that a caller inside the project did not keep.
class BrokenContract : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// The wire failed: DDS entity not created, no server, a lost peer.
class TransportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A motor, a bus or a hand failed.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The user or a newer edit asked to stop; thrown by `Progress::checkpoint`.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

/// Throws InvalidInput with a formatted message.
template <class... Args>
[[noreturn]] void rejectInput(fmt::format_string<Args...> format, Args&&... args) {
  throw InvalidInput(fmt::format(format, std::forward<Args>(args)...));
}

/// `text` as onOneLine (utf8.h) has it, of 200 characters at most: what comes from a file or
/// the wire may be anything, and error messages quote it.
std::string quoted(const std::string& text);

namespace detail {
[[noreturn]] void breakContract(const char* condition, const char* file, int line);
}  // namespace detail

}  // namespace handgraft

/// Always on: a broken contract must not become a wrong pose on a motor.
#define HANDGRAFT_REQUIRE(condition) \
  (static_cast<bool>(condition)      \
       ? static_cast<void>(0)        \
       : ::handgraft::detail::breakContract(#condition, __FILE__, __LINE__))
