#include "server/sessions/live_run.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::server {

void LiveRun::add(const io::HandTrajectory& of,
                  double time_s,
                  const Pose& X_WO,
                  const retargeting::LiveFollower::Answer& answer,
                  const std::vector<std::string>& part_names) {
  const bool goes_on = of_.model == of.model && of_.object_O == of.object_O &&
                       !frames_.empty() && time_s > frames_.back().time_s;
  if (!goes_on) {
    *this = LiveRun();
    of_ = of;
  }
  io::TrajectoryFrame frame;
  frame.time_s = time_s;
  frame.pose_W = answer.pose;
  frame.X_WO = X_WO;
  frame.depths = answer.depths;
  for (const retargeting::LiveFollower::PartFit& fit : answer.parts) {
    const int patch = patchOf(part_names.at(static_cast<std::size_t>(fit.part)));
    frame.patches.push_back(
        {patch, 1.0, fit.distance_mm, fit.facing_deg, fit.reached, fit.on_object_W});
  }
  frames_.push_back(std::move(frame));
  if (frames_.size() <= kMostFrames) return;
  frames_.pop_front();
  ++forgotten_;
}

int LiveRun::patchOf(const std::string& part) {
  const auto known = std::find(of_.patch_names.begin(), of_.patch_names.end(), part);
  const auto index = static_cast<int>(known - of_.patch_names.begin());
  if (known == of_.patch_names.end()) of_.patch_names.push_back(part);
  return index;
}

io::HandTrajectory LiveRun::trajectory() const {
  HANDGRAFT_REQUIRE(!frames_.empty());
  io::HandTrajectory trajectory = of_;
  trajectory.motion = "a demonstrator";
  trajectory.frames.assign(frames_.begin(), frames_.end());
  trajectory.notes.push_back(fmt::format(
      "times count from {:.6g} s of the demonstrator's clock on", frames_.front().time_s));
  if (forgotten_ > 0)
    trajectory.notes.push_back(
        fmt::format("the last {} frames that were followed; {} before them are not kept",
                    frames_.size(), forgotten_));
  return trajectory;
}

}  // namespace handgraft::server
