#include "hardware/bringup/terminal.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace handgraft::bringup {

namespace {

constexpr std::chrono::milliseconds kHeld(700);
constexpr std::chrono::seconds kFirstPress(30);  // to find the space bar

}  // namespace

struct Terminal::Saved {
  termios settings{};
};

Terminal::Terminal() : is_tty_(isatty(STDIN_FILENO) == 1) {
  if (!is_tty_) return;
  saved_ = new Saved;
  tcgetattr(STDIN_FILENO, &saved_->settings);
}

Terminal::~Terminal() {
  setRaw(false);
  delete saved_;
}

void Terminal::setRaw(bool is_raw) {
  if (!is_tty_ || is_raw == is_raw_) return;
  termios settings = saved_->settings;
  if (is_raw) settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  // What was typed ahead holds nothing.
  tcsetattr(STDIN_FILENO, TCSAFLUSH, &settings);
  is_raw_ = is_raw;
}

void Terminal::say(const std::string& line) const {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::optional<std::string> Terminal::readLine() {
  while (true) {
    const std::size_t end = rest_.find('\n');
    if (end != std::string::npos) {
      std::string line = rest_.substr(0, end);
      rest_.erase(0, end + 1);
      return line;
    }
    std::array<char, 256> chunk{};
    const ssize_t count = ::read(STDIN_FILENO, chunk.data(), chunk.size());
    if (count <= 0) {
      has_ended_ = true;
      return std::nullopt;
    }
    rest_.append(chunk.data(), static_cast<std::size_t>(count));
  }
}

std::optional<std::string> Terminal::ask(const std::string& question) {
  setRaw(false);
  is_script_holding_ = false;
  pressed_.reset();
  say(question);
  return readLine();
}

bool Terminal::isHeld() {
  if (!is_tty_) {
    if (!is_script_holding_) is_script_holding_ = readLine() == "hold";
    return is_script_holding_ && !has_ended_;
  }
  setRaw(true);
  const auto now = std::chrono::steady_clock::now();
  const auto wait =
      pressed_ ? std::chrono::milliseconds(0) : std::chrono::milliseconds(kFirstPress);
  pollfd input = {STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, static_cast<int>(wait.count())) > 0) {
    std::array<char, 64> keys{};
    const ssize_t count = ::read(STDIN_FILENO, keys.data(), keys.size());
    const auto* const end = keys.cbegin() + std::max<ssize_t>(count, 0);
    if (std::find(keys.cbegin(), end, ' ') != end) pressed_ = std::chrono::steady_clock::now();
    if (count == 0) has_ended_ = true;
  }
  return pressed_ && now - *pressed_ < kHeld;
}

}  // namespace handgraft::bringup
