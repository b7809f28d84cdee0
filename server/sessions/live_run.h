#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/io/trajectory_writer.h"
#include "core/retargeting/live_follower.h"

namespace handgraft::server {

/// What a hand did after a demonstrator, to be exported: of the last kMostFrames answers.
class LiveRun {
 public:
  /// Five minutes at 120 Hz; some 1 kB each.
  static constexpr std::size_t kMostFrames = 36'000;

  /// Times rise. Frames: X_WO in W. Those of another hand before are forgotten.
  void add(const std::shared_ptr<const hand::HandModel>& model,
           double time_s,
           const Pose& X_WO,
           const retargeting::LiveFollower::Answer& answer,
           const std::vector<std::string>& part_names);

  [[nodiscard]] bool isEmpty() const { return frames_.empty(); }

  /// Names of hand and object, and the object, are left to the caller. BrokenContract if empty.
  [[nodiscard]] io::HandTrajectory trajectory() const;

 private:
  [[nodiscard]] int patchOf(const std::string& part);

  std::shared_ptr<const hand::HandModel> model_;
  std::vector<std::string> patch_names_;
  std::deque<io::TrajectoryFrame> frames_;
  std::size_t forgotten_ = 0;
};

}  // namespace handgraft::server
