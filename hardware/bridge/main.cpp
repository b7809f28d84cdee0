#include <atomic>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/network.h"
#include "hardware/bridge/bridge.h"
#include "hardware/bridge/report_line.h"
#include "hardware/bridge/rival_watch.h"
#include "hardware/config/hand_config_file.h"

namespace {

using namespace handgraft;

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

struct Options {
  Network network;
  bridge::BridgeOptions bridge;
  std::string session = "any";
  std::string config;
  std::optional<std::string> port;
  double rate_hz = 100;
  bool disarmed = false;
  bool json = false;
};

void declare(CLI::App& app, Options& options) {
  app.set_version_flag("--version", std::string("handgraft-bridge ") + HANDGRAFT_VERSION);
  app.add_option("--domain", options.network.domain, "DDS domain, 0 to 100")
      ->capture_default_str();
  app.add_option("--interface", options.network.interface, "network interface to meet on")
      ->capture_default_str();
  app.add_option(
         "--session", options.session,
         "session to follow: its number, or 'any' for the one that began to stream last")
      ->capture_default_str();
  CLI::Option* config = app.add_option("--config", options.config,
                                       "the hand to drive, its device and its limits (YAML); "
                                       "without it a simulated hand follows "
                                       "whatever session streams");
  app.add_option("--port", options.port, "the device's port, in place of the config's")
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
  app.add_flag("--intermediate", options.bridge.with_intermediate,
               "also follow poses of solves that still run");
  app.add_flag(
         "--disarmed", options.disarmed,
         "the simulated hand moves after an ARM alone, as a hand with a config always does")
      ->excludes(config);
  app.add_flag("--json", options.json, "one line of JSON for each event, on standard output");
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

void readConfig(const Options& options, bridge::BridgeOptions& told) {
  if (options.config.empty()) return;
  told.config = config::readHandConfig(options.config);
  told.config_name = options.config;
  if (!options.port) return;
  if (options.port->empty()) rejectInput("--port '': it names no port");
  if (told.config->device.kind == config::DeviceKind::kSimulated)
    rejectInput("--port {}: a simulated hand has none", quoted(*options.port));
  told.config->device.port = *options.port;
}

void print(const bridge::BridgeReport& report, bool json) {
  fmt::print(stderr, "{}\n", textLine(report));
  if (!json) return;
  fmt::print(stdout, "{}\n", jsonLine(report));
  std::fflush(stdout);
}

int run(Options& options) {
  options.bridge.session = parseSession(options.session);
  requireRange("--rate", options.rate_hz, 10, 1000);
  requireRange("--max-velocity", options.bridge.bounds.revolute_velocity, 0.001, 100);
  options.bridge.period_s = 1 / options.rate_hz;
  options.bridge.arms_itself = !options.disarmed;
  readConfig(options, options.bridge);
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

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Moves a hand to the poses that handgraft-server streams, and publishes what it "
      "measures.",
      "handgraft-bridge");
  Options options;
  try {
    declare(app, options);
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kWrongInput;
  } catch (const handgraft::InvalidInput& error) {
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kWrongInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "handgraft-bridge: {}\n", error.what());
    return kFailed;
  }
}
