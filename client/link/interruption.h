#pragma once

#include <functional>
#include <memory>

namespace handgraft::client {

/// Turns Ctrl-C (SIGINT) and SIGTERM into a call on an ordinary thread, where a request can be
/// cancelled. The first signal asks to stop; a second one ends the process as usual.
///
/// One at a time in a process.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// `action` runs on a thread of its own once a signal has come, and again every 100 ms until
  /// it is replaced, so that a wish to stop cannot fall between two steps of what it stops. An
  /// empty function: nothing runs any more, and none is running when this returns.
  void whenRequested(std::function<void()> action);

  [[nodiscard]] bool requested() const;

  /// Throws Cancelled if a signal has come.
  void checkpoint() const;

  /// True if it was SIGTERM, which means the whole program.
  [[nodiscard]] bool terminated() const;

  /// As if no Ctrl-C had come, for programs where it stops one thing of many; SIGTERM stays.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::client
