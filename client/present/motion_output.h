#pragma once

#include <string>

#include "client/present/json_output.h"
#include "client/present/motion_result.h"

/// A motion, and a hand that followed one, for people and programs.
namespace handgraft::client {

namespace text {

/// How long it is, when each patch is there (as bars), and its notes.
std::string motion(const v1::MotionDescription& motion);

/// A row a patch, then what holds of all frames.
std::string motion(const MotionResult& result);

/// The same as far as the frames tell it: without what the solve's summary says.
std::string motionFit(const MotionResult& result);

/// A row a patch of the frame that holds at a time.
std::string motionFrame(const MotionResult& result, double time_s);

}  // namespace text

namespace json {

/// The fields of MotionSummary, `hand`, `object`, `motion`, `joint_names`, `patches`, each with
/// its spans, and `frames`: MotionFrame with what is measured of it.
Json motion(const MotionResult& result);

/// Of those `patches`, and `frames_touching`.
Json motionFit(const MotionResult& result);

/// MotionFrame of the frame that holds at a time, its patches with their names.
Json motionFrame(const MotionResult& result, double time_s);

}  // namespace json

/// A line a frame: time, fit, depth, speeds, how many joints stand at limits.
std::string frameTable(const MotionResult& result);

}  // namespace handgraft::client
