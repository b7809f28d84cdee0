#pragma once

#include "client/link/grasp_result.h"
#include "client/present/render/two_views.h"
#include "idl/models.h"

namespace handgraft::client {

struct GraspPicture {
  render::Scene scene;
  render::Caption caption;
};

/// The posed hand and the object, each finger's patch on both in its own colour, what was
/// dropped in grey, a line from each point on the hand to its partner on the object, a red dot
/// where the hand has no place for a point, and the axes of patches that have one.
///
/// `result.hand` and `object` must have been described with their meshes.
/// Errors: TransportError as `requireConsistent`; InvalidInput for triangles without vertices.
GraspPicture pictureOf(const GraspResult& result,
                       const v1::ObjectDescription& object,
                       const v1::ContactsDescription& contacts);

}  // namespace handgraft::client
