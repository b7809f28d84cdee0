#pragma once

#include "core/manipulation/motion.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::test {

/// A ball held by thumb, index and middle while it moves along x; the middle finger goes after
/// half of the time.
inline manipulation::Motion ballMotion(const BallGrasp& grasp, int frames = 12) {
  manipulation::Motion motion;
  motion.name = "carry";
  motion.object = "ball";
  for (int k = 0; k < frames; ++k) {
    motion.time_s.push_back(k / 60.0);
    Pose X_WO = Pose::Identity();
    X_WO.translation().x() = 0.01 * k;
    motion.X_WO.push_back(X_WO);
  }
  for (const contact::Patch& patch : grasp.contacts.patches) {
    manipulation::PatchTrack track;
    track.name = patch.name;
    track.end = patch.name == "middle" ? frames / 2 : frames;
    track.keys.resize(1);
    track.keys[0].patch = patch;
    motion.tracks.push_back(track);
  }
  return motion;
}

}  // namespace handgraft::test
