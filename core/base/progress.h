#pragma once

#include <atomic>
#include <functional>
#include <string_view>

#include "core/base/error.h"

namespace handgraft {

/// Carries progress out of long work and a wish to stop into it. One per piece of work;
/// `cancel` may be called from any thread, everything else from the thread that works.
class Progress {
 public:
  /// `stage` is a short verb phrase ("wrapping the skin"); `fraction` lies in [0, 1].
  using Listener = std::function<void(std::string_view stage, double fraction)>;

  Progress() = default;

  explicit Progress(Listener listener) : listener_(std::move(listener)) {}

  /// A part of larger work: reports to its own listener, and stops when `whole`, which must
  /// outlive it, is to stop.
  Progress(const Progress& whole, Listener listener)
      : listener_(std::move(listener)), whole_(&whole) {}

  void report(std::string_view stage, double fraction) const {
    if (listener_) listener_(stage, fraction);
  }

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  [[nodiscard]] bool cancelled() const {
    return cancelled_.load(std::memory_order_relaxed) ||
           (whole_ != nullptr && whole_->cancelled());
  }

  /// Throws Cancelled if someone asked to stop. Call it in loops that may take long.
  void checkpoint() const {
    if (cancelled()) throw Cancelled();
  }

 private:
  Listener listener_;
  const Progress* whole_ = nullptr;
  std::atomic<bool> cancelled_{false};
};

}  // namespace handgraft
