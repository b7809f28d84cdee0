#include <atomic>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/network.h"
#include "hardware/bridge/bridge.h"
#include "hardware/bridge/device_factory.h"
#include "hardware/bridge/duplicate_bridge_monitor.h"
#include "hardware/bridge/open_network.h"
#include "hardware/bridge/report_line.h"
#include "hardware/bridge/ros_node.h"
#include "hardware/bringup/check.h"
#include "hardware/bringup/jog.h"
#include "hardware/bringup/make_config.h"
#include "hardware/bringup/scan.h"
#include "hardware/bringup/terminal.h"
#include "hardware/config/calibration_file.h"
#include "hardware/config/device_section.h"
#include "hardware/config/hand_config_file.h"
#include "hardware/config/text_file.h"
#include "idl/security/identity.h"

namespace handgraft {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kWrongInput = 2 };

std::atomic<bool> stop_requested{false};
std::atomic<bool> estop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by signal handlers");

extern "C" void requestStop(int /*signal*/) {
  stop_requested = true;
}

extern "C" void requestEstop(int /*signal*/) {
  estop_requested = true;
}

/// Bringing up a hand, before there is a bridge: each on its own, alone with the device.
struct BringUp {
  enum class Step { kNone, kScan, kMakeConfig, kJog, kCheck } step = Step::kNone;
  std::string port, config, urdf, motor, out, report;
  double step_rad = 0;
  bringup::ConfigPlan plan;
};

struct Options {
  BringUp bring_up;
  Network network;
  bridge::BridgeOptions bridge;
  std::string session = "any";
  std::string config;
  std::optional<std::string> port;
  double rate_hz = 100;
  bool disarmed = false;
  bool open = false;
  bool json = false;
};

void declare(CLI::App& app, Options& options) {
  app.set_version_flag("--version", std::string("handgraft-bridge ") + HANDGRAFT_VERSION);
  app.add_option("--domain", options.network.domain, "DDS domain, 0 to 100")
      ->envname("HANDGRAFT_DOMAIN")
      ->capture_default_str();
  app.add_option("--interface", options.network.interface,
                 "network interface to meet on: name, address or auto")
      ->envname("HANDGRAFT_INTERFACE")
      ->capture_default_str();
  app.add_option("--peers", options.network.peers,
                 "hosts that are told of this bridge one by one, where multicast is dropped")
      ->envname("HANDGRAFT_PEERS")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--server", options.network.server,
                 "name of the server to follow, where a domain has several")
      ->envname("HANDGRAFT_SERVER");
  app.add_option("--identity", options.network.identity,
                 "folder of the identity, of role hand, by which to take part in a secured "
                 "domain, where operators alone command it (handgraft keys)")
      ->envname("HANDGRAFT_IDENTITY");
  app.add_option(
         "--session", options.session,
         "session to follow: its number, or 'any' for the one that began to stream last")
      ->capture_default_str();
  CLI::Option* config = app.add_option("--config", options.config,
                                       "the hand to drive, its device and its limits (YAML); "
                                       "without it a simulated hand follows "
                                       "whatever session streams");
  app.add_option("--port", options.port,
                 "the device's port, in place of the config's: a tty, or a CAN bus' network "
                 "interface")
      ->needs(config);
  app.add_option("--bridge-id", options.bridge.bridge_id,
                 "number of this bridge in commands and joint states")
      ->capture_default_str();
  app.add_option("--rate", options.rate_hz,
                 "periods a second of the simulated hand, 10 to 1000; a config says its own")
      ->capture_default_str()
      ->excludes(config);
  app.add_option("--max-velocity", options.bridge.bounds.revolute_velocity,
                 "highest speed of the simulated hand's revolute joints, rad/s, 0.001 to 100; "
                 "its model "
                 "may say less")
      ->capture_default_str()
      ->excludes(config);
  app.add_option("--ros-namespace", options.bridge.ros_namespace,
                 "of its ROS 2 topics and services, /hand for /hand/joint_states");
  app.add_flag("--intermediate", options.bridge.with_intermediate,
               "also follow poses of solves that still run");
  app.add_flag(
         "--disarmed", options.disarmed,
         "the simulated hand moves after an ARM alone, as a hand with a config always does")
      ->excludes(config);
  app.add_flag("--open", options.open,
               "drive motors off the loopback, where anybody may arm and move them")
      ->needs(config);
  app.add_flag("--json", options.json, "one line of JSON for each event, on standard output");
}

void declareBringUp(CLI::App& app, BringUp& told) {
  using Step = BringUp::Step;
  app.require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* help, Step step) {
    CLI::App* command = app.add_subcommand(name, help);
    command->callback([&told, step] {
      told.step = step;
    });
    return command;
  };
  CLI::App* scan = add("scan", "What answers on a port; nothing moves", Step::kScan);
  scan->add_option("port", told.port, "a tty, or a CAN bus' network interface")->required();

  CLI::App* make =
      add("make-config", "A config to fill in, from a hand's URDF", Step::kMakeConfig);
  make->add_option("urdf", told.urdf, "the hand's model")->required();
  std::vector<std::string> kinds;
  for (const config::DeviceTraits& traits : config::deviceKinds())
    kinds.emplace_back(traits.name);
  make->add_option("--kind", told.plan.kind, "of the device")
      ->check(CLI::IsMember(kinds))
      ->capture_default_str();
  make->add_option("--port", told.plan.port, "a tty, or a CAN bus' network interface")
      ->capture_default_str();
  make->add_option("--can-bitrate", told.plan.can_bitrate,
                   "of a CAN bus; default: the kind's usual one");
  make->add_option("--baud", told.plan.baud, "of the tty; default: the kind's usual one");
  make->add_option(
          "--ids", told.plan.ids,
          "of the motors, in the order of the joints; of a hand that comes as a whole, "
          "their places in it")
      ->delimiter(',')
      ->allow_extra_args(false);
  make->add_option("--out", told.out, "the file; default: standard output");

  const auto add_config = [&](CLI::App* command) {
    command->add_option("--config", told.config, "the hand's (YAML)")->required();
    command->add_option("--port", told.port, "the device's port, in place of the config's");
  };
  CLI::App* jog = add("jog", "Turn one motor slowly while the space bar is held", Step::kJog);
  jog->add_option("motor", told.motor, "its name in the config")->required();
  jog->add_option("step", told.step_rad, "rad")
      ->required()
      ->check(CLI::Range(-bringup::kLargestJog, bringup::kLargestJog));
  add_config(jog);

  CLI::App* check =
      add("check", "A guided walk: directions, zeros, ranges, watchdog, stop", Step::kCheck);
  add_config(check);
  check->add_option("--report", told.report, "a file to keep");
}

std::optional<std::uint64_t> parseSession(const std::string& text) {
  if (text == "any") return std::nullopt;
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size() || id == 0) {
    rejectInput("--session {} is neither 'any' nor a number from 1 to 18446744073709551615",
                quoted(text));
  }
  return id;
}

// NaN is outside every range.
void requireRange(const char* option, double value, double lowest, double highest) {
  if (value >= lowest && value <= highest) return;
  rejectInput("{} {} is outside {} to {}", option, value, lowest, highest);
}

config::HandConfig readAndRemark(const std::string& path) {
  config::HandConfig config = config::readHandConfig(path);
  for (const std::string& remark : config::remarksOn(config))
    fmt::print(stderr, "handgraft-bridge: {}: {}\n", quoted(path), remark);
  return config;
}

void readConfig(const Options& options, bridge::BridgeOptions& told) {
  if (options.config.empty()) return;
  told.config = readAndRemark(options.config);
  told.config_name = options.config;
  if (options.port) config::usePort(told.config->device, *options.port);
}

void print(const bridge::BridgeReport& report, bool json) {
  fmt::print(stderr, "{}\n", textLine(report));
  if (!json) return;
  fmt::print(stdout, "{}\n", jsonLine(report));
  std::fflush(stdout);
}

config::HandConfig configOf(const BringUp& told) {
  config::HandConfig config = readAndRemark(told.config);
  if (config.device.kind == config::DeviceKind::kSimulated)
    rejectInput("{}: a simulated hand needs no bringing up", quoted(told.config));
  if (!told.port.empty()) config::usePort(config.device, told.port);
  return config;
}

bridge::DeviceStack makeOnItsPort(const config::HandConfig& config) {
  return bridge::makeDevice(config, std::chrono::steady_clock::now);
}

std::string placeText(const bringup::Jogger::Place& place) {
  return fmt::format("{:.4f} rad (its encoder tells {:.4f} rad)", place.motor_rad,
                     place.encoder_rad);
}

int jog(const BringUp& told) {
  bringup::Jogger jogger(configOf(told), told.motor, makeOnItsPort,
                         std::chrono::steady_clock::now, [](devices::TimePoint time) {
                           std::this_thread::sleep_until(time);
                         });
  bringup::Terminal terminal;
  terminal.say(fmt::format("motor {} (id {}) is at {}; hold the space bar: it turns by {} rad",
                           quoted(told.motor), jogger.motor().id, placeText(jogger.look()),
                           told.step_rad));
  const auto turn = jogger.turn(told.step_rad, [&] {
    return !stop_requested && terminal.isHeld();
  });
  terminal.say(fmt::format("motor {} went from {} to {}{}; its motors are off",
                           quoted(told.motor), placeText(turn.from), placeText(turn.to),
                           turn.was_let_go ? ", let go" : ""));
  return turn.was_let_go ? kFailed : kDone;
}

int check(const BringUp& told) {
  config::HandConfig config = configOf(told);
  bringup::Terminal terminal;
  bringup::Operator person;
  person.say = [&](const std::string& line) {
    terminal.say(line);
  };
  person.ask = [&](const std::string& question) {
    return terminal.ask(question);
  };
  person.is_held = [&] {
    return !stop_requested && terminal.isHeld();
  };
  person.has_left = [&] {
    return stop_requested || terminal.hasEnded();
  };
  const bringup::Findings findings = bringup::check(
      config, makeOnItsPort, std::chrono::steady_clock::now,
      [](devices::TimePoint time) {
        std::this_thread::sleep_until(time);
      },
      person);
  const std::string report = bringup::reportText(config, findings);
  fmt::print("{}", report);
  if (!told.report.empty()) config::writeText(told.report, report);
  // With a calibration the hand may be armed: none for one that is not fine.
  if (!findings.isFine()) {
    fmt::print("no calibration is written: see to what is not fine, and walk again\n");
  } else if (!config.calibration.empty()) {
    config::writeCalibration(config.calibration, config);
    fmt::print("zeros and directions are in {}\n", config.calibration.string());
  } else {
    fmt::print(
        "put each motor's direction and zero_rad into the config, or name a calibration "
        "file there\n");
  }
  return findings.isFine() ? kDone : kFailed;
}

int bringUp(const BringUp& told) {
  switch (told.step) {
    case BringUp::Step::kNone:
      break;
    case BringUp::Step::kScan: {
      const std::vector<bringup::Found> found = bringup::scan(told.port);
      fmt::print("{}", bringup::scanText(told.port, found));
      return found.empty() ? kFailed : kDone;
    }
    case BringUp::Step::kMakeConfig: {
      // What was filled in by hand is not to be made anew.
      std::error_code error;
      if (!told.out.empty() && std::filesystem::exists(told.out, error))
        rejectInput("--out {}: it is there already; name another file, or take it away",
                    quoted(told.out));
      const std::string text = bringup::makeConfig(told.urdf, told.plan);
      for (const config::DeviceTraits& traits : config::deviceKinds()) {
        if (traits.name != told.plan.kind || traits.has_watchdog) continue;
        fmt::print(
            stderr,
            "{} has no watchdog: should the bridge die, its motors go on turning as they "
            "were told last. Write `no_watchdog: accepted` into the config if you "
            "accept that; until then it is refused.\n",
            told.plan.kind);
      }
      if (told.out.empty()) {
        fmt::print("{}", text);
      } else {
        config::writeText(told.out, text);
        if (told.plan.kind == "simulated") {
          fmt::print("{}: it moves a simulated hand: handgraft-bridge --config {}\n", told.out,
                     told.out);
        } else {
          fmt::print("{}: fill it in, then: handgraft bridge jog MOTOR 0.1 --config {}\n",
                     told.out, told.out);
        }
      }
      return kDone;
    }
    case BringUp::Step::kJog:
      return jog(told);
    case BringUp::Step::kCheck:
      return check(told);
  }
  return kDone;
}

int run(Options& options) {
  if (options.bring_up.step != BringUp::Step::kNone) {
    struct sigaction ends {};  // without SA_RESTART: a question that is open ends, too

    ends.sa_handler = requestStop;
    sigaction(SIGINT, &ends, nullptr);
    sigaction(SIGTERM, &ends, nullptr);
    return bringUp(options.bring_up);
  }
  options.bridge.session = parseSession(options.session);
  requireRange("--rate", options.rate_hz, 10, 1000);
  requireRange("--max-velocity", options.bridge.bounds.revolute_velocity, 0.001, 100);
  options.bridge.period_s = 1 / options.rate_hz;
  options.bridge.arms_itself = !options.disarmed;
  readConfig(options, options.bridge);
  const bool is_secured = !options.network.identity.empty();
  if (is_secured)
    idl::security::readIdentity(options.network.identity, {idl::security::Role::kHand});
  bridge::requireClosedNetwork(validate(options.network), options.bridge.config,
                               options.open || is_secured);
  options.bridge.ros_namespace = bridge::rosNamespace(options.bridge.ros_namespace);
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  std::signal(SIGUSR1, requestEstop);
  std::signal(SIGPIPE, SIG_IGN);  // who watches may go away; the hand stays

  const idl::cyclone::Participant participant(options.network);
  bridge::requireNoRival(participant, options.bridge.bridge_id, stop_requested);
  bridge::Bridge hand_bridge(participant, options.bridge, estop_requested,
                             [&](const bridge::BridgeReport& report) {
                               print(report, options.json);
                             });
  const auto& config = options.bridge.config;
  fmt::print(stderr, "handgraft-bridge: {}, bridge {}, {}, {:.4g} Hz\n",
             config ? fmt::format("hand {} from {}", quoted(config->hand), options.config)
                    : "simulated hand",
             options.bridge.bridge_id, describe(options.network),
             config ? 1 / config->governor.period_s : options.rate_hz);
  hand_bridge.run(stop_requested);
  fmt::print(stderr, "handgraft-bridge: stopped, {} periods began late\n",
             hand_bridge.overruns());
  return kDone;
}

int run(int argc, const char* const* argv) {
  CLI::App app(
      "Moves a hand to the poses that handgraft-server streams, and publishes what it "
      "measures.",
      "handgraft-bridge");
  Options options;
  try {
    declare(app, options);
    declareBringUp(app, options.bring_up);
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kWrongInput;
  } catch (const InvalidInput& error) {
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kWrongInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace handgraft

int main(int argc, char** argv) {
  try {
    return handgraft::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-bridge: %s\n", error.what());
    return handgraft::kFailed;
  }
}
