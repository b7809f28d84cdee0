// handgraft-device-emulator CONFIG: the device that a hand's config tells, emulated on a tty,
// to try a config without hardware. Says the tty's name, then what the motors do, until it is
// interrupted. A line "MOTOR RAD" turns a motor that is off by hand.

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "hardware/config/device_section.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/emulators/hand_rig.h"

namespace {

using namespace handgraft;

constexpr const char* kHelp =
    "usage: handgraft-device-emulator CONFIG\n\n"
    "Emulates the device that CONFIG, a hand's YAML file, tells of, on a tty of its own, so "
    "that "
    "the\nconfig can be tried without hardware. Prints the tty's name with the "
    "handgraft-bridge "
    "command that\ndrives it, then which motors turn, until it is interrupted (Ctrl-C). A "
    "line MOTOR RAD,\nas in `thumb 0.5`, turns a motor by hand while all are off. What is on "
    "the other end of `port`\nin CONFIG is not touched.\n";

std::atomic<bool> stop_requested{false};

extern "C" void requestStop(int /*signal*/) {
  stop_requested = true;
}

/// What changed since it was told last, in words: whether motors are on, and who turned.
class Teller {
 public:
  std::optional<std::string> tell(test::HandRig& rig, const config::HandConfig& config) {
    const bool is_on = rig.isPowered();
    std::string turned;
    told_rad_.resize(config.motors.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < told_rad_.size(); ++i) {
      const double angle_rad = rig.angle(i);
      if (std::abs(angle_rad - told_rad_[i]) < 5e-4) continue;
      told_rad_[i] = angle_rad;
      turned += fmt::format("{}{} {:.3f}", turned.empty() ? "" : ", ", config.motors[i].name,
                            angle_rad);
    }
    if (turned.empty() && is_on_ == is_on) return std::nullopt;
    is_on_ = is_on;
    return fmt::format("motors {}{}{}{}", is_on ? "on" : "off", turned.empty() ? "" : ": ",
                       turned, turned.empty() ? "" : " rad");
  }

 private:
  std::optional<bool> is_on_;
  std::vector<double> told_rad_;
};

/// Lines of standard input, as they come; none once it has ended.
class Lines {
 public:
  std::optional<std::string> take() {
    pollfd input = {STDIN_FILENO, POLLIN, 0};
    while (!has_ended_ && poll(&input, 1, 0) > 0) {
      std::array<char, 256> chunk{};
      const ssize_t count = ::read(STDIN_FILENO, chunk.data(), chunk.size());
      has_ended_ = count <= 0;
      if (!has_ended_) text_.append(chunk.data(), static_cast<std::size_t>(count));
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }

 private:
  std::string text_;
  bool has_ended_ = false;
};

/// "MOTOR RAD": somebody's hand.
void turnByHand(const std::string& line, const config::HandConfig& config, test::HandRig& rig) {
  std::istringstream words(line);
  std::string name;
  double angle_rad = 0;
  if (!(words >> name >> angle_rad) || !std::isfinite(angle_rad)) {
    fmt::print("{}: not MOTOR RAD\n", handgraft::quoted(line));
    return;
  }
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    if (config.motors[i].name == name) return rig.put(i, angle_rad);
  }
  fmt::print("{}: no motor of that name\n", handgraft::quoted(name));
}

int emulate(const char* path) {
  config::HandConfig config = config::readHandConfig(path);
  if (config.device.kind == config::DeviceKind::kSimulated)
    rejectInput("{}: a simulated hand has no wire to be emulated", quoted(path));
  config::usePort(config.device, "/dev/pts");  // a tty, also where the config tells of can0
  const auto rig = test::makeHandRig(config, true);
  if (config.device.kind == config::DeviceKind::kODrive && !config.homing.empty())
    test::slackenLines(*rig, config);
  fmt::print(
      "{} of hand {} on {}\nhandgraft-bridge --config {} --port {}\n",
      config.motors.size() == 1 ? "a motor" : fmt::format("{} motors", config.motors.size()),
      handgraft::quoted(config.hand), test::portOf(rig->wire()), path,
      test::portOf(rig->wire()));
  Teller teller;
  Lines lines;
  while (!stop_requested) {
    while (const std::optional<std::string> line = lines.take())
      turnByHand(*line, config, *rig);
    if (const auto news = teller.tell(*rig, config)) fmt::print("{}\n", *news);
    std::fflush(stdout);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view told = argc == 2 ? argv[1] : "";
  if (told == "--help" || told == "-h") {
    fmt::print("{}", kHelp);
    return 0;
  }
  if (told.empty() || told.front() == '-') {
    fmt::print(stderr, "usage: handgraft-device-emulator CONFIG; --help says more\n");
    return 2;
  }
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  try {
    return emulate(argv[1]);
  } catch (const InvalidInput& error) {
    fmt::print(stderr, "handgraft-device-emulator: {}\n", error.what());
    return 2;
  }
}
