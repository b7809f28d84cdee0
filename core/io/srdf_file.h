#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/hand/hand_model.h"
#include "core/hand/named_pose.h"

namespace handgraft::io {

struct SrdfFile {
  /// In the order of the file. Two of one name are told apart by their group: "left/open".
  std::vector<hand::NamedPose> poses;
  /// What was passed over: joints that the hand lacks, values moved into the limits.
  std::vector<std::string> notes;
};

/// Reads the named poses (`group_state`) of a MoveIt SRDF for a hand. Joints that a state does
/// not name stay at the model's rest pose; the file may speak of a whole robot, of which the
/// hand is a part.
///
/// Units: rad, m. Errors: InvalidInput naming the file, and the state and joint, for XML that
/// is not well-formed, another root element, a state without a name, a value that is no finite
/// number, more than kMostNamedPoses states or 4 MB.
SrdfFile readSrdf(const std::filesystem::path& path, const hand::HandModel& model);

inline constexpr int kMostNamedPoses = 1000;

}  // namespace handgraft::io
