#pragma once

#include <memory>

#include <Eigen/Core>

#include "core/geometry/log_map.h"

namespace handgraft::geometry {

/// Log maps by short heat flows over the whole surface: factored once per mesh, then a few
/// back-substitutions per source. Keeps no reference to the mesh; queries may run side by side.
///
/// phi, tangent planes and the x axis are those of `computeLogMap`. Every component of the mesh
/// is a system of its own, on an intrinsic Delaunay triangulation. A component that is not
/// manifold, not welded or holds a face without area is refused when a source lies on it.
///
/// A source inside a face or on an edge is a combination of vertices nearby, each one's share
/// told where it stands in the source's tangent plane: exact on a plane. `heat` takes the
/// corners with their barycentric weights; `smooth` spreads them to a round source
/// (`heat_source`), so that phi is as good as from a vertex.
///
/// Heat crosses everything: r is no geodesic distance behind a reflex edge of the surface or at
/// the cut locus. Vertices that come out nearer than nine tenths of the straight line from the
/// source are left out (NaN), like those that no heat reaches within double's range.
class HeatLogMap {
 public:
  /// Cost: two sparse factorisations (real and complex) per component, O(V^1.5) expected.
  explicit HeatLogMap(const TriangleMesh& mesh);
  ~HeatLogMap();
  HeatLogMap(HeatLogMap&&) noexcept;
  HeatLogMap& operator=(HeatLogMap&&) noexcept;
  HeatLogMap(const HeatLogMap&) = delete;
  HeatLogMap& operator=(const HeatLogMap&) = delete;

  /// Affine heat method: position vectors carried by the heat itself; phi is the best of all
  /// methods on smooth dense meshes, planes are exact, whatever the triangles.
  ///
  /// Errors: InvalidInput as `computeLogMap`, and if the source's component is refused (above).
  /// Cost: one real and two complex back-substitutions, over the disk and its ancestors in the
  ///   elimination tree alone, plus O(F); heat from farther than ten mean edges beyond the
  ///   radius is left out (1e-11 of it).
  /// Source: Soliman & Sharp 2025, "The Affine Heat Method". Differs: the system is block
  ///   triangular, and solved so.
  [[nodiscard]] LogMap smooth(const SurfacePoint& source,
                              const Eigen::Vector3d& direction,
                              double radius) const;

  /// Vector heat method: the directions of a radial and of a parallel field, and the distance
  /// that integrates the former. Coarser; the paper's own choice, kept for comparison.
  ///
  /// Errors: as `smooth`.
  /// Cost: a third factorisation at the first query, then two complex and one real
  ///   back-substitution for each corner of the source with weight.
  /// Source: Sharp, Soliman & Crane 2019, "The Vector Heat Method", section 8.2. Differs: along
  ///   an edge of the source the far end's direction counts alone, since the radial field has
  ///   none at the source; averaging the two makes r half an edge too short.
  [[nodiscard]] LogMap heat(const SurfacePoint& source,
                            const Eigen::Vector3d& direction,
                            double radius) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace handgraft::geometry
