#include "core/manipulation/recorded_frames.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/angle.h"
#include "core/base/error.h"

namespace handgraft::manipulation {

namespace {

/// Why a frame is left out; empty: it is not.
using Reasons = std::vector<std::string>;

std::string whyNoHand(const DemonstratedFrame& frame) {
  try {
    hand::requireHand(frame.joints_W, frame.side);
  } catch (const InvalidInput& error) {
    return fmt::format("at {:.3f} s: {}", frame.time_s, error.what());
  }
  return "";
}

Eigen::Vector3d placeOfHand(const DemonstratedFrame& frame) {
  return frame.joints_W.rowwise().mean();
}

Eigen::Vector3d placeOfObject(const DemonstratedFrame& frame) {
  return frame.X_WO.translation();
}

/// What leaps away from where it was, and is back at once: nothing real does.
void leaveOutLeaps(const std::vector<DemonstratedFrame>& frames,
                   const char* what,
                   Eigen::Vector3d (*place_of)(const DemonstratedFrame&),
                   Reasons& reasons) {
  constexpr double kFastest = 5.0;    // m/s
  constexpr double kShortest = 0.05;  // m; a leap
  constexpr double kLongest = 0.1;    // s; until it is back
  const auto leapBetween = [&](const DemonstratedFrame& a, const DemonstratedFrame& b) {
    const double way = (place_of(b) - place_of(a)).norm();
    return way > std::max(kShortest, kFastest * (b.time_s - a.time_s)) ? way : 0.0;
  };
  std::optional<std::size_t> last;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!reasons[k].empty()) continue;
    const double leap = last ? leapBetween(frames[*last], frames[k]) : 0.0;
    bool is_back = false;
    for (std::size_t later = k + 1; leap > 0.0 && !is_back && later < frames.size() &&
                                    frames[later].time_s - frames[*last].time_s <= kLongest;
         ++later)
      is_back = reasons[later].empty() && leapBetween(frames[*last], frames[later]) == 0.0;
    if (is_back)
      reasons[k] = fmt::format("at {:.3f} s: the {} leaps by {:.0f} mm and comes back",
                               frames[k].time_s, what, 1e3 * leap);
    else
      last = k;
  }
}

/// Hands that hold something bend their fingers, by 2 deg in the flattest recorded frame.
void requireBentForwards(const std::vector<DemonstratedFrame>& frames) {
  constexpr double kBackwards = -8.0;  // deg
  double sum = 0.0;
  for (const DemonstratedFrame& frame : frames)
    sum += hand::fingerBend(frame.joints_W, frame.side);
  const double bend_deg = inDegrees(sum / static_cast<double>(frames.size()));
  if (bend_deg >= kBackwards) return;
  rejectInput(
      "the fingers bend backwards by {:.0f} deg in the mean: is it a {} hand, or mirrored?",
      -bend_deg, frames.front().side == hand::HandSide::kRight ? "left" : "right");
}

}  // namespace

RecordedFrames withoutGlitches(std::vector<DemonstratedFrame> frames) {
  constexpr double kMostGlitches = 0.1;  // share of the frames
  Reasons reasons;
  for (const DemonstratedFrame& frame : frames)
    reasons.push_back(whyNoHand(frame));
  const auto stays = [](const std::string& reason) {
    return reason.empty();
  };
  const auto left_out = [&] {
    return std::count_if(reasons.begin(), reasons.end(), std::not_fn(stays));
  };
  const auto first = [&]() -> const std::string& {
    return *std::find_if_not(reasons.begin(), reasons.end(), stays);
  };
  if (static_cast<double>(left_out()) > kMostGlitches * static_cast<double>(frames.size()))
    rejectInput("{} of {} frames show no hand; {}", left_out(), frames.size(), first());
  leaveOutLeaps(frames, "hand", placeOfHand, reasons);
  leaveOutLeaps(frames, "object", placeOfObject, reasons);

  RecordedFrames recorded;
  if (left_out() > 0)
    recorded.notes.push_back(fmt::format("left out {} of {} frames{}: {}", left_out(),
                                         frames.size(), left_out() > 1 ? ", the first" : "",
                                         first()));
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (reasons[k].empty()) recorded.frames.push_back(std::move(frames[k]));
  requireBentForwards(recorded.frames);
  return recorded;
}

}  // namespace handgraft::manipulation
