#pragma once

#include <vector>

#include "client/present/motion_result.h"
#include "client/present/render/image.h"
#include "idl/models.h"

namespace handgraft::client {

/// A strip of `shown` frames, which have their shapes, above a plot over time of all of
/// `result.frames`: residuals of each patch, depth, speed, joints within their ranges.
///
/// The object stays in the middle of each frame and turns as it does in the world. `hand` and
/// `object` have been described with their meshes. Errors: TransportError if a frame lacks its
/// shapes. Cost: some 0.3 s a frame shown.
render::Image motionPicture(const MotionResult& result,
                            const std::vector<v1::MotionFrame>& shown,
                            const v1::HandDescription& hand,
                            const v1::ObjectDescription& object);

/// How many frames a strip shows at most.
inline constexpr std::uint32_t kFramesShown = 6;

}  // namespace handgraft::client
