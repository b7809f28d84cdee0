#include "core/retargeting/live_searches.h"

#include <algorithm>

namespace handgraft::retargeting {

namespace {

constexpr double kPatience = 0.25;    // s
constexpr double kLongestWait = 4.0;  // s

}  // namespace

void LiveSearches::see(double step_s, bool is_lost, bool is_unserved) {
  lost_s_ = is_lost ? lost_s_ + step_s : 0.0;
  unserved_s_ = is_unserved ? unserved_s_ + step_s : 0.0;
}

bool LiveSearches::isDue(double time_s) const {
  return std::max(lost_s_, unserved_s_) >= kPatience && time_s >= not_before_s_;
}

void LiveSearches::foundNothing(double time_s) {
  not_before_s_ = time_s + wait_s_;
  wait_s_ = std::min(2.0 * wait_s_, kLongestWait);
}

void LiveSearches::found(double end_s) {
  wait_s_ = kShortestWait;
  not_before_s_ = end_s + wait_s_;
}

void LiveSearches::beginAnew(double time_s) {
  lost_s_ = unserved_s_ = 0.0;
  wait_s_ = kShortestWait;
  not_before_s_ = time_s;
}

}  // namespace handgraft::retargeting
