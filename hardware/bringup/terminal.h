#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace handgraft::bringup {

/// Who sits at standard input: answers lines, and holds the space bar as a dead-man's switch.
/// Where it is no terminal but a script, the line "hold" holds until the next question; another
/// line lets go.
class Terminal {
 public:
  Terminal();
  /// The terminal is as it was.
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void say(const std::string& line) const;

  /// Nothing at the end of the input.
  std::optional<std::string> ask(const std::string& question);

  /// The space bar was pressed within the last 0.7 s: as long as keyboards take until they
  /// repeat.
  bool isHeld();

  /// The input came to its end.
  [[nodiscard]] bool hasEnded() const { return has_ended_; }

 private:
  void setRaw(bool is_raw);
  std::optional<std::string> readLine();

  bool is_tty_;
  bool is_raw_ = false;
  bool is_script_holding_ = false;
  bool has_ended_ = false;
  std::optional<std::chrono::steady_clock::time_point> pressed_;
  std::string rest_;  // read, not yet asked for
  struct Saved;
  Saved* saved_ = nullptr;
};

}  // namespace handgraft::bringup
