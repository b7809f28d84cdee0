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

}  // namespace text

namespace json {

/// The fields of MotionSummary, `hand`, `object`, `motion`, `joint_names`, `patches`, each with
/// its spans, and `frames`: MotionFrame with what is measured of it.
Json motion(const MotionResult& result);

}  // namespace json

/// A line a frame: time, fit, depth, speeds, how many joints stand at limits.
std::string frameTable(const MotionResult& result);

}  // namespace handgraft::client
