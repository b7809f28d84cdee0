#pragma once

#include <array>
#include <vector>

#include "client/present/render/two_views.h"
#include "idl/common.h"
#include "idl/models.h"

namespace handgraft::client {

/// A scene with the sides that show it best. Frame W of the scene is O.
struct ContactsPicture {
  render::Scene scene;
  render::Caption caption;
  std::array<render::View, 2> views;
};

/// A hand's links where they are, for pictures of what it touches.
struct PosedLinks {
  std::vector<v1::Mesh> surfaces_L;
  std::vector<v1::Pose> X_OL;
};

/// The contact map's values as colours, from pale to dark, on the mesh that it came with, or
/// the bare object if there is no map; each patch's outline in its finger's colour, its root as
/// a dot, its direction as an arrow, if it has one; and a posed hand, through which one sees.
///
/// `contacts` and `object` must have been described with meshes.
/// Errors: TransportError if a description contradicts itself.
ContactsPicture pictureOf(const v1::ContactsDescription& contacts,
                          const v1::ObjectDescription& object,
                          const PosedLinks& hand);

}  // namespace handgraft::client
