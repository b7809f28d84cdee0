#include <chrono>
#include <cstdio>
#include <exception>
#include <string>

#include <fmt/format.h>

#include "client/cli/command_line.h"
#include "client/present/failure.h"
#include "client/present/interruption.h"
#include "core/base/error.h"

namespace handgraft {
namespace {

constexpr int kFailed = 1;

int fail(int code, const std::string& message) {
  const std::string line = quoted(message);
  const bool whole = line.size() == message.size() + 2;  // not cut: paths may be long
  fmt::print(stderr, "handgraft: {}\n", whole ? line.substr(1, message.size()) : message);
  return code;
}

int runCommandLine(int argc, const char* const* argv) {
  const auto parsed = client::parseCommandLine(argc, argv);
  if (const auto* printout = std::get_if<client::Printout>(&parsed)) {
    fmt::print("{}", printout->text);
    return 0;
  }
  const auto& invocation = std::get<client::Invocation>(parsed);
  client::Interruption interruption;
  interruption.endAfter(std::chrono::duration<double>(
      invocation.common.timeout_s.value_or(client::longestOf(invocation.command))));
  return std::visit(
      [&](const auto& options) {
        return client::run(options, invocation.common, interruption);
      },
      invocation.command);
}

// Exit codes: 0 done, 1 failed, 2 wrong input. Errors become one line each, here alone.
int run(int argc, const char* const* argv) {
  try {
    const int code = runCommandLine(argc, argv);
    if (std::fflush(stdout) != 0) return fail(kFailed, "standard output cannot be written");
    return code;
  } catch (const std::exception& error) {
    const client::Failure failure = client::failureOf(error);
    return fail(failure.exit_code, failure.message);
  }
}

}  // namespace
}  // namespace handgraft

int main(int argc, char** argv) {
  return handgraft::run(argc, argv);
}
