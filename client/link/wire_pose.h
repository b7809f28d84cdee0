#pragma once

#include <array>
#include <string>

#include "core/base/pose.h"
#include "idl/common.h"

namespace handgraft::client {

/// A pose that came over the wire. Errors: InvalidInput naming `what` if it is none.
Pose poseOf(const v1::Pose& X, const std::string& what = "pose from the server");

v1::Pose messageOf(const Pose& X);

/// x y z in m, qw qx qy qz, as `--place` has it. Errors: InvalidInput naming `what`.
v1::Pose placeOf(const std::array<double, 7>& numbers, const std::string& what);

}  // namespace handgraft::client
