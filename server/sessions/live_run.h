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

  /// `of`: hand and object, with their names. Frames: X_WO in W. What another hand did before,
  /// or this one about another object, is forgotten, and what lies behind in time.
  void add(const io::HandTrajectory& of,
           double time_s,
           const Pose& X_WO,
           const retargeting::LiveFollower::Answer& answer,
           const std::vector<std::string>& part_names);

  [[nodiscard]] bool isEmpty() const { return frames_.empty(); }

  /// BrokenContract if empty.
  [[nodiscard]] io::HandTrajectory trajectory() const;

 private:
  [[nodiscard]] int patchOf(const std::string& part);

  io::HandTrajectory of_;  ///< without frames
  std::deque<io::TrajectoryFrame> frames_;
  std::size_t forgotten_ = 0;
};

}  // namespace handgraft::server
