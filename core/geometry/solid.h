#pragma once

#include <memory>

#include "core/base/progress.h"
#include "core/geometry/distance_grid.h"
#include "core/geometry/walls.h"

namespace handgraft::geometry {

/// An object as what no hand may enter: its inside where it has one, and its thin walls, sheets
/// and edges, where an inside says little or does not exist.
///
/// Holes wider than a finger stay open (Holes::kOpenWideOnes), so that a cup without thickness
/// can be reached into. Const and safe from several threads.
class Solid {
 public:
  /// Errors: InvalidInput if the mesh has no face with three different corners; Cancelled on
  /// wish. Cost: some 0.1 s.
  Solid(const TriangleMesh& mesh, const Progress& progress);

  [[nodiscard]] const DistanceGrid& grid() const { return grid_; }

  [[nodiscard]] const Walls& walls() const { return walls_; }

 private:
  Solid(std::shared_ptr<const SignedDistance> exact, const Progress& progress);

  Walls walls_;
  DistanceGrid grid_;
};

}  // namespace handgraft::geometry
