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
#include "hardware/bridge/simulated_hand.h"

namespace {

using namespace handgraft;

enum ExitCode { kDone = 0, kFailed = 1, kWrongInput = 2 };

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

extern "C" void requestStop(int /*signal*/) {
  stop_requested = true;
}

struct Options {
  Network network;
  bridge::BridgeOptions bridge;
  std::string session = "any";
  std::string hand = "simulated";
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
  app.add_option("--hand", options.hand, "the hand to drive")
      ->check(CLI::IsMember({"simulated"}))
      ->capture_default_str();
  app.add_option("--bridge-id", options.bridge.bridge_id,
                 "number of this bridge in commands and joint states")
      ->capture_default_str();
  app.add_option("--rate", options.rate_hz, "periods a second, 10 to 1000")
      ->capture_default_str();
  app.add_option(
         "--max-velocity", options.bridge.bounds.revolute_velocity,
         "highest speed of a revolute joint, rad/s, 0.001 to 100; its model may say less")
      ->capture_default_str();
  app.add_flag("--intermediate", options.bridge.with_intermediate,
               "also follow poses of solves that still run");
  app.add_flag(
      "--disarmed", options.disarmed,
      "start with the motors off: moving takes an ARM, also after the server was lost");
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

std::unique_ptr<bridge::HandDriver> makeSimulatedHand(const bridge::HandPlan& plan) {
  std::vector<bridge::SimulatedJoint> joints;
  for (std::size_t i = 0; i < plan.jointCount(); ++i) {
    const safety::JointLimits& limits = plan.limits[i];
    joints.push_back({limits.lower, limits.upper, limits.velocity, plan.rest[i]});
  }
  return std::make_unique<bridge::SimulatedHand>(std::move(joints));
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
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  std::signal(SIGPIPE, SIG_IGN);  // who watches may go away; the hand stays

  const idl::cyclone::Participant participant(options.network);
  bridge::Bridge hand_bridge(participant, options.bridge, makeSimulatedHand,
                             [&](const bridge::BridgeReport& report) {
                               print(report, options.json);
                             });
  fmt::print(stderr, "handgraft-bridge: {} hand, bridge {}, {}, {} Hz\n", options.hand,
             options.bridge.bridge_id, describe(options.network), options.rate_hz);
  hand_bridge.run(stop_requested);
  fmt::print(stderr, "handgraft-bridge: stopped, {} periods missed\n",
             hand_bridge.missedPeriods());
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
