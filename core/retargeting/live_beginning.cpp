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
  if (touches < kTouchesToBegin) {
    enough_s_.reset();
    is_due_ = false;
    not_before_s_ = time_s;
    return false;
  }
  if (is_first) not_before_s_ = time_s;
  if (is_first || !enough_s_) enough_s_ = time_s;
  if (touches > before) grew_s_ = time_s;
  is_due_ = is_due_ || is_first || is_slow || (digits > 1 && time_s >= grew_s_ + kQuiet) ||
            time_s >= *enough_s_ + kMostWait;
  return is_due_ && time_s >= not_before_s_;
}

bool LiveBeginning::putOff(double time_s) {
  if (!enough_s_ || time_s >= *enough_s_ + kMostPutOff) return false;
  not_before_s_ = time_s + kAgain;
  return true;
}

}  // namespace handgraft::retargeting
