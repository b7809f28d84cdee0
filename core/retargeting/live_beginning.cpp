#include "core/retargeting/live_beginning.h"

#include <utility>

namespace handgraft::retargeting {

namespace {

constexpr double kQuiet = 0.075;    // s
constexpr double kMostWait = 0.25;  // s

}  // namespace

bool LiveBeginning::isDue(double time_s, int touches) {
  const bool is_first = !last_s_ || time_s <= *last_s_ || time_s - *last_s_ > kLivePause;
  last_s_ = time_s;
  const int before = std::exchange(touches_, touches);
  if (touches < kTouchesToBegin) {
    enough_s_.reset();
    is_due_ = false;
    return false;
  }
  if (!enough_s_) enough_s_ = time_s;
  if (touches > before) grew_s_ = time_s;
  is_due_ =
      is_due_ || is_first || time_s >= grew_s_ + kQuiet || time_s >= *enough_s_ + kMostWait;
  return is_due_;
}

}  // namespace handgraft::retargeting
