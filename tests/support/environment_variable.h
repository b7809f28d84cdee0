#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace handgraft::test {

/// Sets a variable of the environment for as long as it lives; none: there is none of that
/// name. For tests alone, which set it while no other thread reads.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::optional<std::string>& value) : name_(name) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): as said above.
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }

  ~EnvironmentVariable() { set(before_); }

  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  void set(const std::optional<std::string>& value) {
    if (value) {
      ::setenv(name_, value->c_str(), 1);  // NOLINT(concurrency-mt-unsafe): as said above.
    } else {
      ::unsetenv(name_);  // NOLINT(concurrency-mt-unsafe): as said above.
    }
  }

  const char* name_;
  std::optional<std::string> before_;
};

}  // namespace handgraft::test
