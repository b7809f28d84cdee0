#include "tests/bench/cgal_geodesics.h"

#include <limits>
#include <optional>

// Only this file sees CGAL's geodesics.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Heat_method_3/Surface_mesh_geodesic_distances_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include "core/base/error.h"

namespace handgraft::bench {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Surface::Vertex_index;
using Face = Surface::Face_index;

/// Vertices and faces keep their numbers.
Surface surfaceOf(const geometry::TriangleMesh& mesh) {
  Surface surface;
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const Eigen::Vector3d p = mesh.vertex(v);
    surface.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z()));
  }
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const Face added = surface.add_face(Vertex(static_cast<unsigned>(face[0])),
                                        Vertex(static_cast<unsigned>(face[1])),
                                        Vertex(static_cast<unsigned>(face[2])));
    if (added == Surface::null_face()) rejectInput("face {}: the mesh is not manifold", f);
  }
  return surface;
}

}  // namespace

struct CgalShortestPaths::Parts {
  using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, Surface>;
  using Paths = CGAL::Surface_mesh_shortest_path<Traits>;

  Surface surface;
  Eigen::Matrix3Xi faces;
  std::optional<Paths> paths;
};

CgalShortestPaths::CgalShortestPaths(const geometry::TriangleMesh& mesh)
    : parts_(std::make_unique<Parts>()) {
  parts_->surface = surfaceOf(mesh);
  parts_->faces = mesh.faces();
}

CgalShortestPaths::~CgalShortestPaths() = default;

void CgalShortestPaths::build(const geometry::SurfacePoint& source) {
  const Surface& surface = parts_->surface;
  const Face face(static_cast<unsigned>(source.face));
  // CGAL counts corners from the tail of the face's own halfedge, we from the face's first.
  const auto h = surface.halfedge(face);
  const Vertex corners[] = {surface.source(h), surface.target(h),
                            surface.target(surface.next(h))};
  Parts::Traits::Barycentric_coordinates weights{};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    for (int ours = 0; ours < 3; ++ours) {
      if (parts_->faces(ours, source.face) == static_cast<int>(corners[corner].idx()))
        weights[corner] = source.barycentric[ours];
    }
  }
  parts_->paths.emplace(surface);
  parts_->paths->add_source_point(face, weights);
  parts_->paths->build_sequence_tree();
}

double CgalShortestPaths::distanceTo(int vertex) {
  const double r =
      parts_->paths->shortest_distance_to_source_points(Vertex(static_cast<unsigned>(vertex)))
          .first;
  return r >= 0.0 ? r : std::numeric_limits<double>::quiet_NaN();
}

struct CgalHeatMethod::Parts {
  explicit Parts(const geometry::TriangleMesh& mesh)
      : surface(surfaceOf(mesh)), heat(surface) {}

  Surface surface;
  CGAL::Heat_method_3::
      Surface_mesh_geodesic_distances_3<Surface, CGAL::Heat_method_3::Intrinsic_Delaunay>
          heat;
};

CgalHeatMethod::CgalHeatMethod(const geometry::TriangleMesh& mesh)
    : parts_(std::make_unique<Parts>(mesh)) {
  // It factors when it is first asked.
  static_cast<void>(distancesFrom(0));
}

CgalHeatMethod::~CgalHeatMethod() = default;

Eigen::VectorXd CgalHeatMethod::distancesFrom(int vertex) {
  parts_->heat.clear_sources();
  parts_->heat.add_source(Vertex(static_cast<unsigned>(vertex)));
  const auto distances = parts_->surface.add_property_map<Vertex, double>("v:distance").first;
  parts_->heat.estimate_geodesic_distances(distances);
  Eigen::VectorXd result(static_cast<int>(parts_->surface.number_of_vertices()));
  for (const Vertex v : parts_->surface.vertices())
    result[static_cast<int>(v.idx())] = distances[v];
  return result;
}

}  // namespace handgraft::bench
