#pragma once

#include <chrono>

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

  /// A signal has come, or the time is over.
  [[nodiscard]] bool requested() const;

  /// From then on it is as if a signal had come, but for what `checkpoint` throws. Before
  /// anybody waits.
  void endAfter(std::chrono::duration<double> time);

  /// Throws Cancelled if a signal has come, TransportError if the time is over.
  void checkpoint() const;

  /// True if it was SIGTERM, which means the whole program.
  [[nodiscard]] bool terminated() const;

  /// As if no Ctrl-C had come, for programs where it stops one thing of many; SIGTERM stays.
  void reset();

  /// As if no signal at all had come, for what is short and still to be written in the end. The
  /// next one asks to stop, the one after it ends the process.
  void forget();

 private:
  std::chrono::duration<double> time_{0};  ///< 0: no end
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace handgraft::client
