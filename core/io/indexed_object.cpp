#include "core/io/indexed_object.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::io {
namespace {

constexpr double kCloudReach = 0.005;  // m; from a point to the surface laid through it

}  // namespace

IndexedObject::IndexedObject(const MeshFile& file) : file_(file) {
  for (std::size_t f = 0; f < file.file_face.size(); ++f)
    triangles_.emplace_back(file.file_face[f], static_cast<int>(f));
  std::sort(triangles_.begin(), triangles_.end());
  if (file.cloud_O.cols() > 0) surface_.emplace(file.mesh);
}

int IndexedObject::meshFace(int file_face, int triangle) const {
  const auto first =
      std::lower_bound(triangles_.begin(), triangles_.end(), std::pair(file_face, 0));
  const auto at =
      std::distance(first, triangles_.end()) > triangle ? first + triangle : triangles_.end();
  if (at == triangles_.end() || at->first != file_face) {
    rejectInput("face {} (triangle {}) does not exist or has no area; the object's last is {}",
                file_face, triangle, triangles_.empty() ? -1 : triangles_.back().first);
  }
  return at->second;
}

int IndexedObject::triangleOf(int mesh_face) const {
  const int file_face = file_.file_face[static_cast<std::size_t>(mesh_face)];
  const auto first =
      std::lower_bound(triangles_.begin(), triangles_.end(), std::pair(file_face, 0));
  return static_cast<int>(
      std::lower_bound(first, triangles_.end(), std::pair(file_face, mesh_face)) - first);
}

Eigen::Vector3d IndexedObject::swappedIfTurned(int mesh_face,
                                               const Eigen::Vector3d& barycentric) const {
  if (file_.is_turned.empty() || file_.is_turned[static_cast<std::size_t>(mesh_face)] == 0)
    return barycentric;
  return {barycentric[0], barycentric[2], barycentric[1]};
}

geometry::SurfacePoint IndexedObject::nearest(const Eigen::Vector3d& p_O,
                                              const char* field) const {
  HANDGRAFT_REQUIRE(isCloud());
  const auto hit = surface_->nearest(p_O);
  if (hit.distance > kCloudReach) {
    rejectInput(
        "field '{}': a point lies {:.1f} mm from the object's surface, at most {:.1f} "
        "mm are permitted; was it left out of the surface?",
        field, 1e3 * hit.distance, 1e3 * kCloudReach);
  }
  return hit.point;
}

}  // namespace handgraft::io
