#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/surface_locator.h"
#include "core/geometry/surface_point.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

/// An object's mesh with the ways between its indices and its file's: a file's polygon is
/// several triangles of the mesh, and points without faces lie on the surface laid through
/// them. Borrows the file.
class IndexedObject {
 public:
  explicit IndexedObject(const MeshFile& file);

  [[nodiscard]] const MeshFile& file() const { return file_; }

  /// Given as points.
  [[nodiscard]] bool isCloud() const { return surface_.has_value(); }

  /// The mesh face that is the `triangle`-th of a file's face. Errors: InvalidInput if there is
  /// none.
  [[nodiscard]] int meshFace(int file_face, int triangle) const;

  /// Which triangle of its file's face a mesh face is.
  [[nodiscard]] int triangleOf(int mesh_face) const;

  /// Weights of a mesh face's corners in the order of the file's triangle, and the way back:
  /// they are the same.
  [[nodiscard]] Eigen::Vector3d swappedIfTurned(int mesh_face,
                                                const Eigen::Vector3d& barycentric) const;

  /// Where a point of a cloud lies on its surface. Errors: InvalidInput naming the field for
  /// points that are more than 5 mm away.
  [[nodiscard]] geometry::SurfacePoint nearest(const Eigen::Vector3d& p_O,
                                               const char* field) const;

 private:
  const MeshFile& file_;
  std::vector<std::pair<int, int>> triangles_;  ///< (file face, mesh face), sorted
  std::optional<geometry::SurfaceLocator> surface_;
};

}  // namespace handgraft::io
