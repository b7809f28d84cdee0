#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "idl/models.h"
#include "idl/motions.h"
#include "idl/sessions.h"

/// A hand that followed a motion, as commands show it.
namespace handgraft::client {

struct MotionResult {
  v1::SessionState session;
  v1::MotionDescription motion;
  v1::HandDescription hand;
  v1::MotionSummary summary;
  std::vector<v1::MotionFrame> frames;  ///< all of them
  double total_ms = 0.0;                ///< from the first request to the last reply
  double files_ms = 0.0;                ///< files and pictures written after it
  bool kept = false;                    ///< the session stays open
};

/// All frames of a session's motion, without shapes, in as many messages as they need.
/// Errors: TransportError if what comes is not what was asked for.
std::vector<v1::MotionFrame> framesOf(Client& server, std::uint64_t session_id);

/// Errors: TransportError if lists that belong together differ in length.
void requireConsistent(const MotionResult& result);

/// What is measured of one frame. Speeds are the largest of any joint, by differences from the
/// frames before it (rad or m, over s to the 1st, 2nd, 3rd power); NaN where there are none.
struct FrameMeasure {
  double mean_mm = 0.0;  ///< over the points of patches at least half there; NaN without
  double normal_deg = 0.0;
  int patches = 0;
  int reached = 0;
  double velocity = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
};

std::vector<FrameMeasure> measuresOf(const MotionResult& result);

/// A stretch of time.
struct MotionSpan {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// What there is to say of one patch over all frames.
struct PatchOverTime {
  std::string name;
  std::vector<MotionSpan> there;  ///< at least half
  std::vector<MotionSpan> reached;
  int frames = 0;  ///< in which it is there
  int frames_reached = 0;
  double mean_mm = 0.0;
  double worst_mm = 0.0;
  double normal_deg = 0.0;
};

/// A patch in a frame in which it counts as there. One that is there several times (a palm's
/// recorded points) is reached if each of them is.
struct PatchThere {
  std::uint32_t patch = 0;
  double points = 0.0;
  double mean_mm = 0.0;  ///< over all of its points, likewise the next
  double normal_deg = 0.0;
  bool is_reached = true;
};

/// By rising patch.
std::vector<PatchThere> patchesThere(const v1::MotionFrame& frame);

/// In the motion's order; those that found no place on the hand have no frames.
std::vector<PatchOverTime> patchesOf(const MotionResult& result);

}  // namespace handgraft::client
