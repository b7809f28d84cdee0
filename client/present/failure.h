#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace handgraft::client {

/// How a command ends that did not do what it should.
struct Failure {
  int exit_code = 1;  ///< 1 failed, 2 wrong input
  std::string message;
};

/// A failure as an exception, where one command runs others.
class CommandFailed : public std::runtime_error {
 public:
  explicit CommandFailed(const Failure& failure)
      : std::runtime_error(failure.message), exit_code_(failure.exit_code) {}

  [[nodiscard]] int exitCode() const { return exit_code_; }

 private:
  int exit_code_;
};

/// The server's refusals that the user can do something about are wrong input, too, told in the
/// words that are typed.
Failure failureOf(const std::exception& error);

}  // namespace handgraft::client
