#include "server/supervisor/supervisor.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/log/log.h"
#include "server/supervisor/starvation.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kLook(100);
constexpr milliseconds kHeldUp(300);      // beyond the time to look
constexpr milliseconds kSilence(2000);    // a status comes once a second
constexpr milliseconds kUsual(1200);      // between two of them
constexpr milliseconds kForgiven(2000);   // of a silence, at most, where there is no processor
constexpr milliseconds kStart(60'000);    // to the first answer; a store may be large
constexpr milliseconds kEnd(12'000);      // it ends itself within 10 s (main.cpp)
constexpr milliseconds kFirstPause(100);  // before it is started again
constexpr milliseconds kLongestPause(30'000);
constexpr int kWrongInput = 2;

[[noreturn]] void become(const std::vector<std::string>& words, int out) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // also one that is stopped; its store can bear it
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  if (out >= 0) dup2(out, STDOUT_FILENO);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words)
    argv.push_back(const_cast<char*>(word.c_str()));  // execv takes char* and reads it only
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());
  _exit(1);
}

/// This program once more, with other arguments; killed when this goes out of scope.
class Twin {
 public:
  /// `out`: what becomes its standard output; -1: this process' own.
  explicit Twin(const std::vector<std::string>& arguments, int out = -1) {
    std::vector<std::string> words{"handgraft-server"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    pid_ = fork();
    if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (pid_ == 0) become(words, out);
  }

  ~Twin() {
    if (hasEnded()) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
  }

  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }

  bool hasEnded() {
    if (!has_ended_) has_ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return has_ended_;
  }

  /// Once it has ended: its exit code, nothing if it was killed.
  [[nodiscard]] std::optional<int> exitCode() const {
    if (!WIFEXITED(status_)) return std::nullopt;
    return WEXITSTATUS(status_);
  }

  [[nodiscard]] int endingSignal() const {
    return WIFSIGNALED(status_) ? WTERMSIG(status_) : 0;
  }

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  bool has_ended_ = false;
};

/// One that asks a server, and writes a byte for each answer (kFoundServer, kAnswered).
class ServerProbe {
 public:
  ServerProbe(std::vector<std::string> arguments, pid_t server) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0)
      throw std::system_error(errno, std::generic_category(), "pipe");
    answers_ = ends[0];
    arguments.insert(arguments.end(), {kAskOption, std::to_string(server)});
    twin_.emplace(arguments, ends[1]);
    close(ends[1]);
  }

  ~ServerProbe() { close(answers_); }

  ServerProbe(const ServerProbe&) = delete;
  ServerProbe& operator=(const ServerProbe&) = delete;

  struct Heard {
    bool found = false;  ///< the server, for the first time
    bool answered = false;
  };

  /// What was heard since the last call; waits for it up to `most`.
  Heard hear(milliseconds most) {
    Heard heard;
    pollfd waits{answers_, POLLIN, 0};
    if (poll(&waits, 1, static_cast<int>(most.count())) <= 0) return heard;
    std::array<char, 256> bytes{};
    ssize_t count = 0;
    while ((count = read(answers_, bytes.data(), bytes.size())) > 0) {
      const char* last = bytes.data() + count;
      heard.found =
          heard.found || std::find<const char*>(bytes.data(), last, kFoundServer) != last;
      heard.answered =
          heard.answered || std::find<const char*>(bytes.data(), last, kAnswered) != last;
    }
    // Its end has ended: nothing to wait for.
    if (!heard.found && !heard.answered) poll(nullptr, 0, static_cast<int>(most.count()));
    return heard;
  }

  /// It cannot ask, by what it was given: asking again would help nothing.
  bool isUnfit() { return twin_->hasEnded() && twin_->exitCode() == kWrongInput; }

 private:
  int answers_ = -1;
  std::optional<Twin> twin_;
};

/// The signal that asks this process to end, if there is one.
int askedToEnd() {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  constexpr timespec kNow{0, 0};
  return std::max(0, sigtimedwait(&ends, nullptr, &kNow));
}

bool isAskedToEndWithin(milliseconds time) {
  for (const auto until = Clock::now() + time; Clock::now() < until;) {
    if (askedToEnd() > 0) return true;
    poll(nullptr, 0, static_cast<int>(kLook.count()));
  }
  return false;
}

/// Asks the server to end, and sees to it that it does. Returns the exit code.
int end(Twin& server, int signal) {
  kill(server.pid(), signal);
  kill(server.pid(), SIGCONT);
  for (const auto until = Clock::now() + kEnd; Clock::now() < until;) {
    if (server.hasEnded()) return server.exitCode().value_or(1);
    if (askedToEnd() > 0) break;  // in a hurry
    poll(nullptr, 0, static_cast<int>(kLook.count()));
  }
  if (server.hasEnded()) return server.exitCode().value_or(1);
  log::error("event=server_killed process={} reason=\"it did not end\"", server.pid());
  return 1;
}

enum class Fate { kToEnd, kEnded, kDeaf };

struct Life {
  Fate fate = Fate::kEnded;
  int signal = 0;      ///< of kToEnd
  bool is_up = false;  ///< once
};

/// Since when the server has said nothing, and how much of that counts against it.
class Unheard {
 public:
  Unheard(pid_t server, Clock::time_point now)
      : server_(server), counted_(kForgiven, now), since_(now) {}

  void hear(Clock::time_point now) {
    counted_.begin(now);
    since_ = now;
    starvation_.reset();
  }

  /// Another one asks from now on.
  void askAnew(Clock::time_point now) { counted_.begin(now); }

  /// Nothing came between these.
  void goOn(Clock::time_point before, Clock::time_point now) {
    // What was not heard while this process itself stood still is nobody's silence.
    if (now - before > kLook + kHeldUp) {
      counted_.standStill(now - before);
      since_ += now - before;
    }
    if (now - since_ <= kUsual) return;
    if (!starvation_) starvation_.emplace(server_);
    counted_.forgive(std::min<Clock::duration>(starvation_->sinceLast(), now - before));
  }

  [[nodiscard]] Clock::duration counts(Clock::time_point now) const {
    return counted_.lasts(now);
  }

  [[nodiscard]] Clock::duration lasts(Clock::time_point now) const { return now - since_; }

 private:
  const pid_t server_;
  Silence counted_;          ///< since an answer, or a new asker
  Clock::time_point since_;  ///< an answer
  std::optional<Starvation> starvation_;
};

/// Watches the server until it ends, falls silent, or is to end.
Life watch(Twin& server, const std::vector<std::string>& arguments) {
  std::optional<ServerProbe> asker;
  asker.emplace(arguments, server.pid());
  Life life;
  bool is_asked_again = false;
  bool is_watched = true;
  Unheard unheard(server.pid(), Clock::now());
  while (true) {
    const Clock::time_point before = Clock::now();
    const ServerProbe::Heard heard = asker->hear(kLook);
    const Clock::time_point now = Clock::now();
    if ((life.signal = askedToEnd()) > 0) {
      life.fate = Fate::kToEnd;
      return life;
    }
    if (server.hasEnded()) return life;
    // What another asker finds at first may have waited for it.
    if (heard.answered || (heard.found && !life.is_up)) {
      life.is_up = true;
      is_asked_again = false;
      unheard.hear(now);
      continue;
    }
    unheard.goOn(before, now);
    if (!is_watched || unheard.counts(now) < (life.is_up ? kSilence : kStart)) continue;
    if (asker->isUnfit()) {
      log::warn(
          "event=not_asked reason=\"this server's identity may not ask; it is started "
          "again when it dies, not when it is silent: handgraft keys add makes one "
          "that may\"");
      is_watched = false;
      continue;
    }
    if (life.is_up && !is_asked_again) {
      // It may be the asker that is deaf.
      asker.reset();
      asker.emplace(arguments, server.pid());
      is_asked_again = true;
      unheard.askAnew(Clock::now());
      continue;
    }
    log::error("event=server_deaf process={} silent_s={:.1f}", server.pid(),
               std::chrono::duration<double>(unheard.lasts(now)).count());
    life.fate = Fate::kDeaf;
    return life;
  }
}

}  // namespace

int supervise(const std::vector<std::string>& arguments) {
  milliseconds pause = kFirstPause;
  for (bool was_up = false;;) {
    const Clock::time_point begin = Clock::now();
    Twin server(arguments);
    log::info("event=supervising process={}", server.pid());
    const Life life = watch(server, arguments);
    was_up = was_up || life.is_up;
    switch (life.fate) {
      case Fate::kToEnd:
        return end(server, life.signal);
      case Fate::kEnded: {
        const std::optional<int> code = server.exitCode();
        if (code == 0 || code == kWrongInput) return *code;
        log::error("event=server_died process={} {}={}", server.pid(), code ? "code" : "signal",
                   code ? *code : server.endingSignal());
        if (!was_up && code) return *code;
        break;
      }
      case Fate::kDeaf:
        kill(server.pid(), SIGKILL);
        break;
    }
    // One that dies again and again is not started ever faster.
    pause =
        Clock::now() - begin > kLongestPause ? kFirstPause : std::min(2 * pause, kLongestPause);
    if (isAskedToEndWithin(pause)) return 0;
  }
}

}  // namespace handgraft::server
