#include "client/present/motion_result.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

/// Largest of what changes from one row to the next over that time; `rate` becomes the change.
double largestChange(std::vector<double>& rate,
                     const std::vector<double>& now,
                     const std::vector<double>& before,
                     double time_s) {
  rate.resize(now.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    rate[i] = (now[i] - before[i]) / time_s;
    largest = std::max(largest, std::abs(rate[i]));
  }
  return largest;
}

/// Adds a frame to stretches of frames; `follows`: the frame before it was of the last one.
void addTo(std::vector<MotionSpan>& spans, bool follows, double time_s) {
  if (follows) {
    spans.back().end_s = time_s;
  } else {
    spans.push_back({time_s, time_s});
  }
}

}  // namespace

std::vector<v1::MotionFrame> framesOf(Client& server, std::uint64_t session_id) {
  std::vector<v1::MotionFrame> frames;
  v1::MotionFramesRequest request;
  request.session_id(session_id);
  for (bool is_last = false; !is_last;) {
    v1::MotionFrames some = server.motionFrames(request).get();
    if (some.frames().empty()) throw TransportError("the server sent no frame of a motion");
    for (v1::MotionFrame& frame : some.frames()) {
      if (!frames.empty() && frame.index() <= frames.back().index())
        throw TransportError("the server sent a motion's frames out of order");
      frames.push_back(std::move(frame));
    }
    is_last = some.is_last();
    request.first(frames.back().index() + 1);
  }
  return frames;
}

void requireConsistent(const MotionResult& result) {
  if (result.frames.empty()) throw TransportError("the server sent no frame of a motion");
  for (const v1::MotionFrame& frame : result.frames) {
    if (frame.joint_positions().size() != result.hand.joints().size()) {
      throw TransportError(fmt::format("frame {} has {} joints; the hand has {}", frame.index(),
                                       frame.joint_positions().size(),
                                       result.hand.joints().size()));
    }
    for (const v1::FramePatch& patch : frame.patches()) {
      if (patch.patch() >= result.motion.patches().size())
        throw TransportError(fmt::format("frame {} has patch {}; the motion has {}",
                                         frame.index(), patch.patch(),
                                         result.motion.patches().size()));
    }
  }
}

std::vector<PatchThere> patchesThere(const v1::MotionFrame& frame) {
  std::map<std::uint32_t, PatchThere> there;
  for (const v1::FramePatch& fit : frame.patches()) {
    if (fit.presence() < v1::PRESENCE_COUNTED) continue;
    PatchThere& patch = there[fit.patch()];
    patch.patch = fit.patch();
    patch.points += fit.point_count();
    patch.mean_mm += fit.point_count() * fit.mean_mm();
    patch.normal_deg += fit.point_count() * fit.normal_deg();
    patch.is_reached = patch.is_reached && fit.reached();
  }
  std::vector<PatchThere> patches;
  for (auto& [index, patch] : there) {
    if (patch.points > 0.0) {
      patch.mean_mm /= patch.points;
      patch.normal_deg /= patch.points;
    }
    patches.push_back(patch);
  }
  return patches;
}

std::vector<FrameMeasure> measuresOf(const MotionResult& result) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  std::vector<FrameMeasure> measures;

  // Each row of differences belongs to the middle of its two frames.
  struct Row {
    double time_s = 0.0;
    std::vector<double> values;
  };

  std::vector<Row> before(3);  // places, velocities, accelerations
  int known = 0;
  for (const v1::MotionFrame& frame : result.frames) {
    FrameMeasure measure;
    double points = 0.0;
    double mean = 0.0;
    double normal = 0.0;
    for (const PatchThere& patch : patchesThere(frame)) {
      ++measure.patches;
      measure.reached += patch.is_reached ? 1 : 0;
      points += patch.points;
      mean += patch.points * patch.mean_mm;
      normal += patch.points * patch.normal_deg;
    }
    measure.mean_mm = points > 0.0 ? mean / points : nothing;
    measure.normal_deg = points > 0.0 ? normal / points : nothing;
    Row row{frame.time_s(), frame.joint_positions()};
    double* const largest[] = {&measure.velocity, &measure.acceleration, &measure.jerk};
    for (int order = 0; order < 3; ++order) {
      const auto at = static_cast<std::size_t>(order);
      *largest[order] = nothing;
      if (order > known) continue;
      Row next;
      if (order < known) {
        next.time_s = 0.5 * (row.time_s + before[at].time_s);
        *largest[order] = largestChange(next.values, row.values, before[at].values,
                                        row.time_s - before[at].time_s);
      }
      before[at] = std::exchange(row, std::move(next));
    }
    known = std::min(known + 1, 3);
    measures.push_back(measure);
  }
  return measures;
}

std::vector<PatchOverTime> patchesOf(const MotionResult& result) {
  std::vector<PatchOverTime> patches;
  for (const std::string& name : result.motion.patches()) {
    patches.emplace_back();
    patches.back().name = name;
  }
  std::vector<char> was_there(patches.size(), 0);
  std::vector<char> was_reached(patches.size(), 0);
  for (const v1::MotionFrame& frame : result.frames) {
    std::vector<char> is_there(patches.size(), 0);
    std::vector<char> is_reached(patches.size(), 0);
    for (const PatchThere& fit : patchesThere(frame)) {
      const std::size_t at = fit.patch;
      PatchOverTime& patch = patches[at];
      is_there[at] = 1;
      addTo(patch.there, was_there[at] != 0, frame.time_s());
      ++patch.frames;
      patch.mean_mm += fit.mean_mm;
      patch.normal_deg += fit.normal_deg;
      patch.worst_mm = std::max(patch.worst_mm, fit.mean_mm);
      if (!fit.is_reached) continue;
      is_reached[at] = 1;
      ++patch.frames_reached;
      addTo(patch.reached, was_reached[at] != 0, frame.time_s());
    }
    was_there = std::move(is_there);
    was_reached = std::move(is_reached);
  }
  for (PatchOverTime& patch : patches) {
    if (patch.frames == 0) continue;
    patch.mean_mm /= patch.frames;
    patch.normal_deg /= patch.frames;
  }
  return patches;
}

}  // namespace handgraft::client
