#include "client/present/interruption.h"

#include <atomic>
#include <csignal>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

// What the handler touches.
std::atomic<bool> was_interrupted{false};
std::atomic<bool> was_terminated{false};
static_assert(std::atomic<bool>::is_always_lock_free);

struct sigaction before_int {};

struct sigaction before_term {};

void onSignal(int signal) {
  (signal == SIGTERM ? was_terminated : was_interrupted) = true;
}

void handle(struct sigaction* former_int, struct sigaction* former_term) {
  struct sigaction on_signal {};

  on_signal.sa_handler = onSignal;
  on_signal.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&on_signal.sa_mask);
  sigaction(SIGINT, &on_signal, former_int);
  sigaction(SIGTERM, &on_signal, former_term);
}

}  // namespace

Interruption::Interruption() {
  was_interrupted = false;
  was_terminated = false;
  handle(&before_int, &before_term);
}

Interruption::~Interruption() {
  sigaction(SIGINT, &before_int, nullptr);
  sigaction(SIGTERM, &before_term, nullptr);
}

bool Interruption::requested() const {
  const bool is_over = time_.count() > 0.0 && std::chrono::steady_clock::now() - begin_ > time_;
  return was_interrupted || was_terminated || is_over;
}

void Interruption::endAfter(std::chrono::duration<double> time) {
  time_ = time;
  begin_ = std::chrono::steady_clock::now();
}

void Interruption::checkpoint() const {
  if (was_interrupted || was_terminated) throw Cancelled();
  if (requested())
    throw TransportError(fmt::format("not done after {:.6g} s (--timeout)", time_.count()));
}

bool Interruption::terminated() const {
  return was_terminated;
}

void Interruption::reset() {
  was_interrupted = false;
  handle(nullptr, nullptr);
}

void Interruption::forget() {
  was_terminated = false;
  reset();
}

}  // namespace handgraft::client
