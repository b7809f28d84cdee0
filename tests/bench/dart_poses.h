#pragma once

#include <filesystem>

#include "core/hand/hand_model.h"

namespace handgraft::bench {

/// The largest difference of any entry of any link's pose, 4 x 4 in metres, from DART's over
/// random joints (within a radian or a metre) and roots. Followers are set by the file's own
/// factors and offsets, joint by joint. NaN if DART does not read the file or has other joints.
/// `model` with the joints of its free root.
double largestPoseDifference(const std::filesystem::path& urdf,
                             const hand::HandModel& model,
                             int poses);

}  // namespace handgraft::bench
