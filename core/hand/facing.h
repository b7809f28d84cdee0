#pragma once

namespace handgraft::hand {

/// Cosine (32 degrees) between a site's normal and where its digits close: what looks farther
/// away is on a chamfer or a motor.
inline constexpr double kFacingWell = 0.85;

}  // namespace handgraft::hand
