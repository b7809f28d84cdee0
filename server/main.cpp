#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <malloc.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/network.h"
#include "server/admission/service.h"
#include "server/store/model_library.h"
#include "server/transport/bus.h"

namespace {

using namespace handgraft;

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongInput = 2;
// A client repeats what it waits for at least every 2 s (idl/TOPICS.md).
constexpr std::chrono::seconds kForsaken{10};
constexpr std::size_t kReserves = 16;

struct Options {
  Network network;
  std::string models;
  unsigned workers = std::max(2u, std::thread::hardware_concurrency());
  std::string log_level = "info";
  std::string make_skins;  ///< folder; then it serves nothing
  server::ReaderLimits reader;
  unsigned session_idle_minutes = 720;
  unsigned sessions = 256;
  unsigned solve_seconds = 600;
};

/// Blocks SIGTERM and SIGINT in this thread and all that it starts; returns the set to wait
/// for.
sigset_t blockStopSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  return set;
}

/// Waits for a signal. Meanwhile what malloc keeps in holes between longer-lived pieces goes
/// back to the system: the passing pieces of many sessions' edits would else add up to several
/// times what the sessions hold.
int waitFor(const sigset_t& signals) {
  constexpr timespec kPeriod{5, 0};
  while (true) {
    const int signal = sigtimedwait(&signals, nullptr, &kPeriod);
    if (signal > 0) return signal;
#ifdef __GLIBC__
    malloc_trim(0);
#endif
  }
}

/// Serves until a signal: nothing that the bus says ends it.
void serve(const Options& options, const sigset_t& stop_signals) {
  validate(options.network);
  server::ModelStore models;
  int left_out = server::readLibrary(server::builtInLibrary(), models);
  if (!options.models.empty()) left_out += server::readLibrary(options.models, models);

  const std::unique_ptr<server::Bus> bus = server::openFastBus(options.network);
  server::ServiceOptions service_options;
  service_options.name = options.network.server;
  service_options.workers = options.workers;
  service_options.reader_limits = options.reader;
  service_options.session_idle = std::chrono::minutes(options.session_idle_minutes);
  service_options.most_sessions = options.sessions;
  service_options.budget = std::chrono::seconds(options.solve_seconds);
  service_options.forsaken = kForsaken;
  service_options.reserves = kReserves;
  server::Service service(*bus, models, service_options);
  service.start();
  spdlog::info(
      "event=ready version={}{} domain={} interface={} models={} left_out={} workers={}",
      HANDGRAFT_VERSION,
      options.network.server.empty() ? "" : " name=" + options.network.server,
      options.network.domain, options.network.interface, models.size(), left_out,
      options.workers);

  const int signal = waitFor(stop_signals);
  spdlog::info("event=stopping signal={}", signal);
  service.stop();
  spdlog::info("event=stopped");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("handgraft-server: keeps models and sessions, answers on DDS",
               "handgraft-server");
  app.set_version_flag("--version", std::string("handgraft-server ") + HANDGRAFT_VERSION);
  app.add_option("--domain", options.network.domain, "DDS domain, 0-100")
      ->check(CLI::Range(0, kHighestDomain))
      ->envname("HANDGRAFT_DOMAIN")
      ->capture_default_str();
  app.add_option("--interface", options.network.interface,
                 "network interface to serve on: name, address or auto")
      ->envname("HANDGRAFT_INTERFACE")
      ->capture_default_str();
  app.add_option("--peers", options.network.peers,
                 "hosts that are told of this server one by one, where multicast is dropped")
      ->envname("HANDGRAFT_PEERS")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option(
         "--name", options.network.server,
         "name by which clients choose this server (--server), where a domain has several")
      ->envname("HANDGRAFT_SERVER");
  app.add_option(
      "--models", options.models,
      "folder with more hands, objects and contacts; replaces those of the same name");
  app.add_option("--workers", options.workers, "threads for sessions' work, 1-256")
      ->check(CLI::Range(1u, 256u))
      ->capture_default_str();
  app.add_option("--reader-memory", options.reader.memory_mb,
                 "MB that reading one upload may take, 64-1048576")
      ->check(CLI::Range(64u, 1u << 20))
      ->capture_default_str();
  unsigned reader_seconds = static_cast<unsigned>(options.reader.time.count());
  app.add_option("--reader-seconds", reader_seconds,
                 "seconds that reading one upload may take, 1-86400")
      ->check(CLI::Range(1u, 86'400u))
      ->capture_default_str();
  app.add_option("--session-idle-minutes", options.session_idle_minutes,
                 "minutes after which a session that nobody uses is closed, 1-525600")
      ->check(CLI::Range(1u, 525'600u))
      ->capture_default_str();
  app.add_option("--solve-seconds", options.solve_seconds,
                 "seconds that one request or solve may compute, 1-86400")
      ->check(CLI::Range(1u, 86'400u))
      ->capture_default_str();
  app.add_option("--sessions", options.sessions, "sessions that may be open, 1-4096")
      ->check(CLI::Range(1u, 4096u))
      ->capture_default_str();
  app.add_option(
      "--make-skins", options.make_skins,
      "make the built-in hands' skins in this folder and end; done when it is built");
  app.add_option("--log-level", options.log_level, "trace, debug, info, warning, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      return app.exit(error);
    }
    std::fprintf(stderr, "handgraft-server: %s\n", error.what());
    return kWrongInput;
  }

  options.reader.time = std::chrono::seconds(reader_seconds);
  const sigset_t stop_signals = blockStopSignals();
  spdlog::set_default_logger(spdlog::stderr_logger_mt("handgraft"));
  spdlog::set_pattern("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc);
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  try {
    if (!options.make_skins.empty()) {
      server::makeSkins(options.make_skins);
    } else {
      serve(options, stop_signals);
    }
    return kDone;
  } catch (const InvalidInput& error) {
    std::fprintf(stderr, "handgraft-server: %s\n", error.what());
    return kWrongInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-server: %s\n", error.what());
    return kFailed;
  }
}
