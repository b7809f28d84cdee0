// handgraft-device-emulator CONFIG: the device that a hand's config tells, emulated on a tty,
// to try a config without hardware. Says the tty's name, then what the motors do, until it is
// interrupted.

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <string_view>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
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
    "command that\ndrives it, then what the motors do, until it is interrupted (Ctrl-C). What "
    "is on the other end\nof `port` in CONFIG is not touched.\n";

std::atomic<bool> stop_requested{false};

extern "C" void requestStop(int /*signal*/) {
  stop_requested = true;
}

std::string describe(test::HandRig& rig, std::size_t motors) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < motors; ++i)
    angles.push_back(rig.angle(i));
  return fmt::format("motors {}, rad: {:.3f}", rig.isPowered() ? "on" : "off",
                     fmt::join(angles, " "));
}

int emulate(const char* path) {
  const config::HandConfig config = config::readHandConfig(path);
  if (config.device.kind == config::DeviceKind::kSimulated)
    rejectInput("{}: a simulated hand has no wire to be emulated", quoted(path));
  const auto rig = test::makeHandRig(config, true);
  if (config.device.kind == config::DeviceKind::kODrive && !config.homing.empty())
    test::slackenLines(*rig, config);
  fmt::print(
      "{} of hand {} on {}\nhandgraft-bridge --config {} --port {}\n",
      config.motors.size() == 1 ? "a motor" : fmt::format("{} motors", config.motors.size()),
      quoted(config.hand), test::portOf(rig->wire()), path, test::portOf(rig->wire()));
  std::string told;
  while (!stop_requested) {
    const std::string now = describe(*rig, config.motors.size());
    if (now != told) fmt::print("{}\n", now);
    std::fflush(stdout);
    told = now;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
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
