#pragma once

#include <optional>
#include <vector>

#include "core/contact/patch.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::bench {

/// Places inside a patch and the net between them, the same for every way to lay it out: its
/// boundary, copies of it drawn towards the root, and the root.
struct PatchNet {
  std::vector<geometry::SurfacePoint> places;
  std::vector<Eigen::Vector3d> p_O;
  std::vector<Eigen::Vector3i> triangles;
};

/// Rings at equal shares of the straight way from the root, by the `exact` log map.
PatchNet netOf(const geometry::TriangleMesh& object_O, const contact::Patch& patch, int rings);

/// How a net changed, over the triangles whose corners all have a place.
struct NetChange {
  int lost = 0;               ///< places
  double length_mean = 0.0;   ///< |edge on the skin / edge on the object - 1|
  double length_worst = 0.0;  ///< the same, 95th percentile
  double angle_mean = 0.0;    ///< rad
  double area_ratio = 1.0;
  double turned_over = 0.0;  ///< share of triangles whose sense of rotation did not mirror
  double fit_rms = 0.0;      ///< m, after the best rigid motion of the net onto its mirror side
};

/// Compares edges, angles and areas between the object and the places on the skin; `n_S` are
/// the skin's normals there, to tell turned triangles.
NetChange changeOf(const PatchNet& net,
                   const std::vector<std::optional<Eigen::Vector3d>>& p_S,
                   const std::vector<std::optional<Eigen::Vector3d>>& n_S);

}  // namespace handgraft::bench
