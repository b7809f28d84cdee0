#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "hardware/safety/joint_limiter.h"

/// What is held against a governor's output: limits, and targets that are passed.
namespace handgraft::safety::test {

inline constexpr double kOvershoot = 1e-4;     // rad
inline constexpr double kWithin = 1.0 + 1e-6;  // share of a limit that is still within it

/// Largest finite differences of what was sent to one joint, as shares of its limits.
class RequestDeduplication {
 public:
  RequestDeduplication(const JointLimits& limits, double period)
      : limits_(limits),
        period_(period),
        memory_(static_cast<int>(2 * limits.acceleration / (limits.jerk * period)) + 4) {}

  /// At rest.
  void begin(double at) {
    x_[0] = x_[1] = x_[2] = x_[3] = at;
    still_ = memory_;
  }

  void add(double x) {
    std::rotate(std::begin(x_), std::end(x_) - 1, std::end(x_));
    x_[0] = x;
    still_ = x_[0] == x_[1] ? still_ + 1 : 0;
    const double T = period_;
    velocity = std::max(velocity, std::abs(x_[0] - x_[1]) / (T * limits_.velocity));
    acceleration = std::max(
        acceleration, std::abs(x_[0] - 2 * x_[1] + x_[2]) / (T * T * limits_.acceleration));
    jerk = std::max(
        jerk, std::abs(x_[0] - 3 * x_[1] + 3 * x_[2] - x_[3]) / (T * T * T * limits_.jerk));
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
  }

  /// Unchanged for as long as an average could remember motion: a moment at a turning point is
  /// no rest.
  [[nodiscard]] bool rests() const { return still_ >= memory_; }

  double velocity = 0, acceleration = 0, jerk = 0;
  double lowest = std::numeric_limits<double>::infinity(),
         highest = -std::numeric_limits<double>::infinity();

 private:
  JointLimits limits_;
  double period_;
  int memory_;
  int still_ = 0;
  double x_[4] = {};
};

/// How far a joint that rested when its target changed passes that target.
struct OvershootWatch {
  bool watches = false;
  double from = 0, target = 0;
  double worst = 0;
  int steps = 0;

  void see(double new_target, bool rests, double position) {
    if (new_target != target || !watches) {
      watches = rests;
      from = position;
      target = new_target;
      if (watches) ++steps;
    }
  }

  void sent(double position) {
    if (!watches) return;
    const double beyond = from < target ? position - target : target - position;
    worst = std::max(worst, beyond);
  }
};

}  // namespace handgraft::safety::test
