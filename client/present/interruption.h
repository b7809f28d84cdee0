#pragma once

namespace handgraft::client {

/// Turns Ctrl-C (SIGINT) and SIGTERM into a wish that whoever works or waits looks for. The
/// first signal asks to stop; a second one ends the process as usual.
///
/// One at a time in a process. Threads: all methods from any thread.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  [[nodiscard]] bool requested() const;

  /// Throws Cancelled if a signal has come.
  void checkpoint() const;

  /// True if it was SIGTERM, which means the whole program.
  [[nodiscard]] bool terminated() const;

  /// As if no Ctrl-C had come, for programs where it stops one thing of many; SIGTERM stays.
  void reset();
};

}  // namespace handgraft::client
