#include "core/base/error.h"
#include "core/hand/skin_wrap.h"

/// Built without CGAL.
namespace handgraft::hand {

geometry::TriangleMesh wrapped(const geometry::TriangleMesh& /*triangles*/,
                               double /*alpha_m*/,
                               double /*offset_m*/,
                               const Progress& /*progress*/) {
  rejectInput(
      "a skin cannot be wrapped: this Handgraft was built without CGAL "
      "(HANDGRAFT_WITH_CGAL=OFF); give the hand a skin that was made before");
}

geometry::TriangleMesh remeshed(const geometry::TriangleMesh& /*mesh*/, double /*edge_m*/) {
  rejectInput(
      "a skin cannot be remeshed: this Handgraft was built without CGAL "
      "(HANDGRAFT_WITH_CGAL=OFF)");
}

std::vector<int> selfIntersectingFaces(const geometry::TriangleMesh& /*mesh*/) {
  return {};
}

}  // namespace handgraft::hand
