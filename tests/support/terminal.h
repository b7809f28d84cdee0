#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <sys/types.h>

namespace handgraft::test {

/// A program at a terminal of its own, 100 columns wide; killed when this goes out of scope.
class Terminal {
 public:
  /// `environment` is added to this process' own. Throws std::runtime_error if the program
  /// cannot be started.
  Terminal(const std::filesystem::path& program,
           const std::vector<std::string>& arguments,
           const std::map<std::string, std::string>& environment = {});
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// As if typed: `\t`, `\r`, `\x03` for Ctrl-C, `\x04` for Ctrl-D, `\x1b[A` for the arrow up.
  void type(const std::string& keys) const;

  /// Waits until the program has written `text` since the last call that found something; false
  /// after `timeout` or at the program's end. Escape sequences count as nothing.
  bool waitFor(const std::string& text,
               std::chrono::seconds timeout = std::chrono::seconds(60));

  /// All that it has written so far, without escape sequences.
  [[nodiscard]] std::string text() const;

  /// Waits for the end and returns the exit code (128 + signal when killed); -1 after
  /// `timeout`.
  int wait(std::chrono::seconds timeout = std::chrono::seconds(60));

 private:
  void receive();
  bool ended();

  pid_t pid_ = -1;
  int master_ = -1;
  int exit_code_ = -1;
  bool ended_ = false;
  std::string written_;
  std::size_t searched_ = 0;  ///< of the text without escape sequences
};

}  // namespace handgraft::test
