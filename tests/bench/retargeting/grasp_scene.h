#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "client/present/render/image.h"
#include "client/present/render/scene.h"
#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_model.h"

namespace handgraft::bench {

namespace render = client::render;

/// A hand about an object, patches on the object in their colours. Without a pose the object
/// stands alone.
render::Scene sceneOf(const hand::HandModel& model,
                      const std::optional<hand::HandPose>& pose_O,
                      const geometry::TriangleMesh& object_O,
                      const contact::ContactSet& contacts);

render::Color patchColor(std::size_t patch);

/// Images of one size, row by row.
render::Image tiled(const std::vector<render::Image>& images, int columns);

}  // namespace handgraft::bench
