#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_locator.h"

namespace handgraft::hand {

/// Whether a triangle reaches into a tetrahedron, as far as doubles can tell.
enum class Touch { kNo, kYes, kTooCloseToTell };

/// The inside counts, a common border is too close to tell. Frames: all corners in one.
Touch touchOf(const std::array<Eigen::Vector3d, 4>& tetrahedron,
              const std::array<Eigen::Vector3d, 3>& triangle);

/// What a wrapping asks of the triangles that it wraps: it asks near to where it asked before,
/// so that an answer bounds the next one. Not for several threads.
class WrapQueries {
 public:
  /// Errors: InvalidInput if there is no triangle.
  explicit WrapQueries(const geometry::TriangleMesh& triangles) : locator_(triangles) {}

  [[nodiscard]] const geometry::TriangleMesh& triangles() const { return locator_.mesh(); }

  /// The nearest place of the triangles.
  const geometry::SurfaceLocator::Hit& nearest(const Eigen::Vector3d& p) const;

  /// Where the way from `p` to `q` first comes within `offset_m` of the triangles, to a
  /// hundredth of it; none if it does not. Source: sphere tracing, Hart 1996.
  [[nodiscard]] std::optional<Eigen::Vector3d> firstWithin(double offset_m,
                                                           const Eigen::Vector3d& p,
                                                           const Eigen::Vector3d& q) const;

  /// Whether a triangle reaches into the tetrahedron. Where doubles cannot tell, `unclear` is
  /// filled with the faces that must be looked at exactly.
  [[nodiscard]] Touch touches(const std::array<Eigen::Vector3d, 4>& tetrahedron,
                              std::vector<int>& unclear) const;

 private:
  geometry::SurfaceLocator locator_;
  mutable std::optional<geometry::SurfaceLocator::Hit> last_;
  mutable Eigen::Vector3d last_p_ = Eigen::Vector3d::Zero();
  mutable std::vector<int> near_;
};

}  // namespace handgraft::hand
