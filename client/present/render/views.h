#pragma once

#include <array>
#include <string>

#include <Eigen/Core>

#include "client/present/render/scene.h"

namespace handgraft::client::render {

/// A side from which a picture shows a scene.
struct View {
  Eigen::Vector3d from_W;  ///< towards the viewer
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();
  std::string title{};
};

/// For things that stand: the first is the one of 16 around the world's z axis that shows most
/// of the decals; the second shows most among those that are turned by 90 to 135 degrees from
/// it. Errors: InvalidInput for a scene that is not valid.
std::array<View, 2> viewsAroundUp(const Scene& scene);

/// For things that may lie anyhow: of 40 sides all around the two, at least 80 degrees from
/// each other, that together show each decal best; first the one that shows more. Errors as
/// above.
std::array<View, 2> viewsAllAround(const Scene& scene);

}  // namespace handgraft::client::render
