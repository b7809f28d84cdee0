#include "core/retargeting/live_beginning.h"

#include <utility>

namespace handgraft::retargeting {

namespace {

constexpr double kQuiet = 0.075;     // s
constexpr double kMostWait = 0.25;   // s
constexpr double kAgain = 0.1;       // s
constexpr double kMostPutOff = 1.0;  // s

}  // namespace

bool LiveBeginning::isDue(double time_s, int touches, int digits) {
  const bool is_first = !last_s_ || time_s <= *last_s_ || time_s - *last_s_ > kLivePause;
  // Of frames as far apart the next one is later than the hand should begin.
  const bool is_slow = last_s_ && time_s - *last_s_ >= kQuiet;
  last_s_ = time_s;
  const int before = std::exchange(touches_, touches);
  const bool is_pinch = touches >= kTouchesToPinch && digits >= kTouchesToPinch;
  if (!is_pinch) pinch_s_.reset();
  if (is_pinch && (is_first || !pinch_s_)) pinch_s_ = time_s;
  if (is_first || (!is_pinch && touches < kTouchesToBegin)) not_before_s_ = time_s;
  if (touches < kTouchesToBegin) {
    enough_s_.reset();
    is_due_ = false;
    is_pinch_due_ = is_pinch && (is_pinch_due_ || is_first || time_s >= *pinch_s_ + kMostWait);
    return is_pinch_due_ && time_s >= not_before_s_;
  }
  is_pinch_due_ = false;
  if (is_first || !enough_s_) enough_s_ = time_s;
  if (touches > before) grew_s_ = time_s;
  is_due_ = is_due_ || is_first || is_slow || (digits > 1 && time_s >= grew_s_ + kQuiet) ||
            time_s >= *enough_s_ + kMostWait;
  return is_due_ && time_s >= not_before_s_;
}

bool LiveBeginning::putOff(double time_s) {
  const std::optional<double> since_s = enough_s_ ? enough_s_ : pinch_s_;
  if (!since_s || time_s >= *since_s + kMostPutOff) return false;
  not_before_s_ = time_s + kAgain;
  return true;
}

}  // namespace handgraft::retargeting
