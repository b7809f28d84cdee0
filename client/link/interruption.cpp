#include "client/link/interruption.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client {

namespace {

constexpr char kInterrupted = 'i';
constexpr char kTerminated = 't';
constexpr char kGoodbye = 'q';
constexpr int kRepeatMs = 100;

// What the handler may touch: a lock-free number and write().
std::atomic<int> pipe_end{-1};
static_assert(std::atomic<int>::is_always_lock_free);

void onSignal(int signal) {
  const int saved = errno;
  const char byte = signal == SIGTERM ? kTerminated : kInterrupted;
  const int fd = pipe_end.load();
  if (fd >= 0) {
    // A full pipe holds a signal already.
    [[maybe_unused]] const ssize_t written = write(fd, &byte, 1);
  }
  errno = saved;
}

}  // namespace

struct Interruption::Impl {
  Impl() {
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error(fmt::format("no pipe for signals: {}", std::strerror(errno)));
    }
    pipe_end = pipe[1];
    handle(&before_int, &before_term);
    listener = std::thread([this] {
      listen();
    });
  }

  ~Impl() {
    sigaction(SIGINT, &before_int, nullptr);
    sigaction(SIGTERM, &before_term, nullptr);
    pipe_end = -1;
    [[maybe_unused]] const ssize_t written = write(pipe[1], &kGoodbye, 1);
    listener.join();
    close(pipe[0]);
    close(pipe[1]);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  static void handle(struct sigaction* before_int, struct sigaction* before_term) {
    struct sigaction on_signal {};

    on_signal.sa_handler = onSignal;
    on_signal.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigemptyset(&on_signal.sa_mask);
    sigaction(SIGINT, &on_signal, before_int);
    sigaction(SIGTERM, &on_signal, before_term);
  }

  void listen() {
    while (true) {
      pollfd waiting{pipe[0], POLLIN, 0};
      const int ready = poll(&waiting, 1, requested ? kRepeatMs : -1);
      if (ready < 0 && errno == EINTR) continue;
      if (ready > 0) {
        char byte = kGoodbye;
        if (read(pipe[0], &byte, 1) != 1 || byte == kGoodbye) return;
        if (byte == kTerminated) terminated = true;
        requested = true;
      }
      const std::lock_guard lock(mutex);
      if (requested && action) action();
    }
  }

  std::array<int, 2> pipe{};

  struct sigaction before_int {};

  struct sigaction before_term {};

  std::mutex mutex;
  std::function<void()> action;
  std::atomic<bool> requested{false};
  std::atomic<bool> terminated{false};
  std::thread listener;
};

Interruption::Interruption() : impl_(std::make_unique<Impl>()) {}

Interruption::~Interruption() = default;

void Interruption::whenRequested(std::function<void()> action) {
  const std::lock_guard lock(impl_->mutex);
  impl_->action = std::move(action);
}

bool Interruption::requested() const {
  return impl_->requested;
}

void Interruption::checkpoint() const {
  if (requested()) throw Cancelled();
}

bool Interruption::terminated() const {
  return impl_->terminated;
}

void Interruption::reset() {
  const std::lock_guard lock(impl_->mutex);
  impl_->requested = impl_->terminated.load();
  Impl::handle(nullptr, nullptr);
}

}  // namespace handgraft::client
