#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::bench {

/// Polar coordinates that a log map should give, V entries each; NaN where the truth says
/// nothing. phi is up to one constant rotation per source.
struct PolarTruth {
  Eigen::VectorXd r;
  Eigen::VectorXd phi;
};

/// A surface whose log map is known in closed form.
///
/// Planes, cylinders and cones are developable *polyhedra*: every vertex of every version lies
/// on the same prism or pyramid, no face crosses a ridge, and the truth is the polyhedron
/// unrolled, not the round surface it stands for. The sphere's truth are arcs.
struct MeasuredSurface {
  std::string surface;  ///< "plane", "cylinder", "cone", "cone past its apex", "sphere"
  std::string version;  ///< one of mesh_versions
  geometry::TriangleMesh mesh;
  /// Whether a log map may start at this place of the mesh, in its frame.
  std::function<bool(const Eigen::Vector3d&)> may_start;
  /// Of the disk about a source, metres; the plane's is infinite.
  std::function<double(const geometry::SurfacePoint&)> radius;
  std::function<PolarTruth(const geometry::SurfacePoint&)> truth;
};

/// `sliver`: every second face holds a point 1/100 of its height off one of its edges, which
/// makes needles of about 1:100. `anisotropic`: cells 1:10. `jittered`: vertices moved by 30 %
/// of an edge inside the surface. `obtuse`: most faces have an angle above 90 degrees.
inline const std::vector<std::string> mesh_versions{"as it is", "sliver", "anisotropic",
                                                    "jittered", "obtuse"};

/// All surfaces in all versions, about `vertex_count` vertices each (slivers have twice as
/// many; the sphere 10 * 4^n + 2, the nearest of them by ratio). Deterministic.
std::vector<MeasuredSurface> measuredSurfaces(int vertex_count);

}  // namespace handgraft::bench
