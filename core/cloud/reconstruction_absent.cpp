#include "core/base/error.h"
#include "core/cloud/reconstruction.h"

/// Built without CGAL.
namespace handgraft::cloud {

namespace {

[[noreturn]] void reject() {
  rejectInput(
      "points cannot be made a surface: this Handgraft was built without CGAL "
      "(HANDGRAFT_WITH_CGAL=OFF); give the object as a mesh with faces");
}

}  // namespace

Eigen::Matrix3Xd estimateNormals(const Eigen::Matrix3Xd& /*points*/,
                                 int /*neighbours*/,
                                 const Progress& /*progress*/) {
  reject();
}

geometry::TriangleMesh poissonSurface(const Eigen::Matrix3Xd& /*points*/,
                                      const Eigen::Matrix3Xd& /*normals*/,
                                      double /*spacing*/,
                                      double /*edge*/,
                                      const Progress& /*progress*/) {
  reject();
}

geometry::TriangleMesh advancingFrontSurface(const Eigen::Matrix3Xd& /*points*/,
                                             double /*longest_edge*/,
                                             const Progress& /*progress*/) {
  reject();
}

}  // namespace handgraft::cloud
