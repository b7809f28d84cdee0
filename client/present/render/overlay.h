#pragma once

#include <cstdint>

#include "client/present/render/camera.h"
#include "client/present/render/depth_buffer.h"
#include "client/present/render/image.h"
#include "client/present/render/scene.h"

namespace handgraft::client::render {

/// Draws the scene's lines and discs, `factor` samples a pixel. Ids: segments, markers, then
/// the rims of both.
void drawOverlay(const Scene& scene, const Camera& camera, float factor, DepthBuffer& buffer);

/// The colour of what `drawOverlay` drew with this id.
Color overlayColor(const Scene& scene, std::uint32_t id);

}  // namespace handgraft::client::render
