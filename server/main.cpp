#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/network.h"
#include "idl/security/identity.h"
#include "server/admission/service.h"
#include "server/lockdown.h"
#include "server/log/log.h"
#include "server/reading/sandbox.h"
#include "server/store/model_library.h"
#include "server/store/state_file.h"
#include "server/store/state_store.h"
#include "server/supervisor/supervisor.h"
#include "server/transport/bus.h"
#include "server/transport/server_probe.h"

namespace handgraft {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongInput = 2;
// A client repeats what it waits for at least every 2 s (idl/TOPICS.md).
constexpr std::chrono::seconds kForsaken{10};
constexpr std::size_t kReserves = 16;
// Who is not heard for 20 s is dropped by the other side (idl/DECISIONS.md).
constexpr double kMissed = 16.0;  // s

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
  std::string state;  ///< folder; empty: the system's own
  unsigned state_mb = 4096;
  bool check = false;
  std::string backup;  ///< file; then it serves nothing
  bool supervised = false;
  unsigned ask_process = 0;  ///< another server, which is asked; then it serves nothing
};

/// The store, or null where nothing shall outlive this process.
std::unique_ptr<server::StateStore> openState(const Options& options) {
  constexpr unsigned kMb = 20;
  const server::StateFile file = server::stateFile(options.state, options.network);
  if (!file.why.empty())
    server::log::warn("event=state_in_memory reason={}", handgraft::quoted(file.why));
  if (file.path == ":memory:") return nullptr;
  server::StateLimits limits;
  limits.bytes = static_cast<std::uint64_t>(options.state_mb) << kMb;
  return std::make_unique<server::StateStore>(file.path, limits);
}

/// What is wrong with the store, a line each.
int checkState(const Options& options) {
  const server::StateFile file = server::stateFile(options.state, options.network);
  const std::vector<std::string> problems = server::checkStore(file.path);
  for (const std::string& problem : problems)
    std::printf("%s\n", problem.c_str());
  std::printf("%s: %s\n", file.path.c_str(),
              problems.empty() ? "sound" : fmt::format("{} problems", problems.size()).c_str());
  return problems.empty() ? kDone : kFailed;
}

void backUpState(const Options& options) {
  const server::StateFile file = server::stateFile(options.state, options.network);
  server::backUpStore(file.path, options.backup);
  std::printf("%s: copied to %s\n", file.path.c_str(), options.backup.c_str());
}

/// Those of the command line, without the program's name and that flag.
std::vector<std::string> argumentsWithout(const std::string& flag, int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  std::erase(arguments, flag);
  return arguments;
}

/// Blocks SIGTERM and SIGINT in this thread and all that it starts; returns their set.
sigset_t blockStopSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  return set;
}

/// Since some time ago; a machine that sleeps counts, too.
double secondsWithSleep() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Hears the signals to stop on a thread of its own, which ends the process 10 s after the
/// first one, and at once by the second, whatever the others wait for.
class StopSignals {
 public:
  StopSignals() {
    std::thread([this, signals = blockStopSignals()] {
      constexpr timespec kPatience{10, 0};
      int signal = 0;
      sigwait(&signals, &signal);
      {
        const std::lock_guard lock(mutex_);
        signal_ = signal;
      }
      came_.notify_all();
      sigtimedwait(&signals, nullptr, &kPatience);
      server::log::error("event=ended_by_force reason=\"it did not stop by itself\"");
      server::log::flush();
      _exit(kFailed);
    }).detach();
  }

  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Waits for a signal, which is returned, or until this process has stood still for so long
  /// that others took it for gone: 0. Meanwhile what malloc keeps in holes between longer-lived
  /// pieces goes back to the system: the passing pieces of many sessions' edits would else add
  /// up to several times what the sessions hold.
  int wait() {
    constexpr std::chrono::seconds kPeriod(1);
    constexpr int kPeriodsBetweenTrims = 5;
    std::unique_lock lock(mutex_);
    double last_s = secondsWithSleep();
    for (int i = 1;; ++i) {
      if (came_.wait_for(lock, kPeriod, [this] {
            return signal_ > 0;
          }))
        return signal_;
      const double now_s = secondsWithSleep();
      if (now_s - std::exchange(last_s, now_s) > kMissed) return 0;
#ifdef __GLIBC__
      if (i % kPeriodsBetweenTrims == 0) malloc_trim(0);
#endif
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  int signal_ = 0;
};

/// Asks that server until nobody reads any more what it says.
void ask(const Options& options) {
  bool is_found = false;
  std::atomic<bool> is_read = true;
  server::probeServer(
      options.network, options.ask_process,
      [&](bool is_answer) {
        if (is_found && !is_answer) return;
        is_found = true;
        const char told = is_answer ? server::kAnswered : server::kFoundServer;
        if (write(STDOUT_FILENO, &told, 1) < 0 && errno != EAGAIN) is_read = false;
      },
      [&] {
        return !is_read;
      });
}

/// Gives up what a server of these options need not have.
std::string lockDown(const Options& options) {
  server::PermittedPaths all = server::usualPaths();
  if (!options.models.empty()) all.read.push_back(options.models);
  if (!options.network.identity.empty()) all.read.push_back(options.network.identity);
  const server::StateFile state = server::stateFile(options.state, options.network);
  if (state.path != ":memory:")
    all.written.push_back(std::filesystem::path(state.path).parent_path());
  return server::lockDown(all);
}

/// Serves until a signal: nothing that the bus says ends it. False if it is to be begun anew,
/// on its store: it was missed, and clients that dropped it do not find it again while it
/// believes to know them still.
bool serve(const Options& options) {
  const NetworkInterface interface = validate(options.network);
  const std::string given_up = lockDown(options);  // before all other threads, likewise:
  static StopSignals stop_signals;                 // and it outlives this function
  if (!options.network.identity.empty()) {
    // Before anything is opened.
    idl::security::readIdentity(options.network.identity, {idl::security::Role::kServer});
  }
  server::ModelStore models;
  int left_out = server::readLibrary(server::builtInLibrary(), models);
  if (!options.models.empty()) left_out += server::readLibrary(options.models, models);

  const std::unique_ptr<server::StateStore> state = openState(options);
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
  service_options.state = state.get();
  server::Service service(*bus, models, service_options);
  service.start();
  server::log::info(
      "event=ready version={}{} domain={} interface={} models={} sessions={} left_out={} "
      "workers={} state={} given_up={} readers_kept_from={} identity={}",
      HANDGRAFT_VERSION,
      options.network.server.empty() ? "" : " name=" + options.network.server,
      options.network.domain, options.network.interface, models.size(),
      service.status().session_count(), left_out, options.workers,
      state ? handgraft::quoted(state->path()) : "memory", handgraft::quoted(given_up),
      handgraft::quoted(server::sandboxOfThisKernel()),
      options.network.identity.empty() ? "none" : handgraft::quoted(options.network.identity));
  if (options.network.identity.empty() && !interface.loopback) {
    server::log::warn(
        "event=open interface={} reason=\"anybody on this network may read, edit, close and "
        "unload what is here: --identity keeps strangers out (handgraft keys)\"",
        handgraft::quoted(interface.name));
  }

  int signal = stop_signals.wait();
  while (signal == 0 && state == nullptr) {
    server::log::warn(
        "event=stood_still reason=\"clients of before may not find this server again; "
        "with --state it would start anew\"");
    signal = stop_signals.wait();
  }
  if (signal == 0) {
    server::log::warn(
        "event=stood_still reason=\"clients took this server for gone: it starts anew\"");
  } else {
    server::log::info("event=stopping signal={}", signal);
  }
  service.stop();
  if (signal != 0) server::log::info("event=stopped");
  return signal != 0;
}

void addNetworkOptions(CLI::App& app, Network& network) {
  app.add_option("--domain", network.domain, "DDS domain, 0-100")
      ->check(CLI::Range(0, kHighestDomain))
      ->envname("HANDGRAFT_DOMAIN")
      ->capture_default_str();
  app.add_option("--interface", network.interface,
                 "network interface to serve on: name, address or auto")
      ->envname("HANDGRAFT_INTERFACE")
      ->capture_default_str();
  app.add_option("--peers", network.peers,
                 "hosts that are told of this server one by one, where multicast is dropped")
      ->envname("HANDGRAFT_PEERS")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option(
         "--name", network.server,
         "name by which clients choose this server (--server), where a domain has several")
      ->envname("HANDGRAFT_SERVER");
  app.add_option("--identity", network.identity,
                 "folder of the identity, of role server, by which to serve a secured domain "
                 "(handgraft keys)")
      ->envname("HANDGRAFT_IDENTITY");
}

void addLimitOptions(CLI::App& app, Options& options, unsigned& reader_seconds) {
  app.add_option("--workers", options.workers, "threads for sessions' work, 1-256")
      ->check(CLI::Range(1u, 256u))
      ->capture_default_str();
  app.add_option("--reader-memory", options.reader.memory_mb,
                 "MB that reading one upload may take, 64-1048576")
      ->check(CLI::Range(64u, 1u << 20))
      ->capture_default_str();
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
}

void addStateOptions(CLI::App& app, Options& options) {
  app.add_option("--state", options.state,
                 "folder in which models and sessions outlive the server; :memory: for none "
                 "(default: $STATE_DIRECTORY, $XDG_STATE_HOME/handgraft or "
                 "~/.local/state/handgraft)")
      ->envname("HANDGRAFT_STATE");
  app.add_option("--state-size", options.state_mb, "MB that they may take there, 16-1048576")
      ->check(CLI::Range(16u, 1u << 20))
      ->capture_default_str();
  app.add_flag("--check", options.check, "say what is wrong with the state on disk, and end");
  app.add_option("--backup", options.backup,
                 "copy the state, also one in use, into this new file, and end");
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("handgraft-server: keeps models and sessions, answers on DDS",
               "handgraft-server");
  app.set_version_flag("--version", std::string("handgraft-server ") + HANDGRAFT_VERSION);
  addNetworkOptions(app, options.network);
  app.add_option(
      "--models", options.models,
      "folder with more hands, objects and contacts; replaces those of the same name");
  unsigned reader_seconds = static_cast<unsigned>(options.reader.time.count());
  addLimitOptions(app, options, reader_seconds);
  addStateOptions(app, options);
  app.add_option("--make-skins", options.make_skins,
                 "make the built-in hands' skins and solids in this folder and end; done when "
                 "it is built");
  app.add_flag("--supervised", options.supervised,
               "serve in a process of its own, which is started again when it dies or gives no "
               "answer for 5 s");
  app.add_option(server::kAskOption, options.ask_process)->group("");
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
  server::log::begin(options.log_level);
  try {
    if (!options.make_skins.empty()) {
      server::makeSkins(options.make_skins);
    } else if (options.check) {
      return checkState(options);
    } else if (!options.backup.empty()) {
      backUpState(options);
    } else if (options.ask_process != 0) {
      ask(options);
    } else if (options.supervised) {
      blockStopSignals();
      return server::supervise(argumentsWithout("--supervised", argc, argv));
    } else if (!serve(options)) {
      execv("/proc/self/exe", argv);
      throw std::runtime_error("this program cannot be started anew");
    }
    return kDone;
  } catch (const InvalidInput& error) {
    std::fprintf(stderr, "handgraft-server: %s\n", error.what());
    return kWrongInput;
  }
}

}  // namespace
}  // namespace handgraft

int main(int argc, char** argv) {
  try {
    return handgraft::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-server: %s\n", error.what());
    return handgraft::kFailed;
  }
}
