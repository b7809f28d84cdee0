#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace handgraft::test {

/// A child process whose output is kept; killed when this goes out of scope, and when the test
/// program dies.
class Process {
 public:
  /// Starts `program` with its arguments. Throws std::runtime_error if it cannot be started.
  Process(const std::filesystem::path& program, const std::vector<std::string>& arguments);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] bool running();

  /// Waits for the end and returns the exit code (128 + signal when killed). Throws
  /// std::runtime_error, with what the process wrote, after `timeout`.
  int wait(std::chrono::seconds timeout = std::chrono::seconds(120));

  /// Waits until standard output and error together hold `text`; false after `timeout` or at
  /// the process' end.
  bool waitForText(const std::string& text,
                   std::chrono::seconds timeout = std::chrono::seconds(60));

  void send(int signal) const;

  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;

 private:
  bool reap(bool block);

  pid_t pid_ = -1;
  int exit_code_ = -1;
  bool ended_ = false;
  std::filesystem::path out_;
  std::filesystem::path err_;
};

/// What a program printed and how it ended.
struct Finished {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs a program to its end.
Finished run(const std::filesystem::path& program,
             const std::vector<std::string>& arguments,
             std::chrono::seconds timeout = std::chrono::seconds(120));

}  // namespace handgraft::test
