#include "core/hand/skin_wrap.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include "core/base/error.h"
#include "core/hand/wrap_queries.h"

namespace handgraft::hand {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using WrapMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Lets a wish to stop into the wrapping, and says that it goes on.
struct Checkpoint : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
  explicit Checkpoint(const Progress& p) : progress(p) {}

  template <class Wrapper, class Gate>
  void before_facet_treatment(const Wrapper& /*wrapper*/, const Gate& /*gate*/) {
    if (++steps % 1024 != 0) return;
    progress.checkpoint();
    // How many gates there will be nobody knows.
    progress.report("wrapping", steps / (steps + 1e5));
  }

  const Progress& progress;
  unsigned steps = 0;
};

namespace AW3 = CGAL::Alpha_wraps_3::internal;

Eigen::Vector3d fromCgal(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

Kernel::Point_3 toCgal(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

/// The triangles, as CGAL's wrapping asks for them. Its own oracle takes two thirds of a wrap's
/// time: a set of those seen each query, and ten queries a step along a Voronoi edge.
class Oracle {
 public:
  // NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
  using Geom_traits = AW3::Alpha_wrap_AABB_traits<Kernel>;

  explicit Oracle(const geometry::TriangleMesh& triangles) : queries_(triangles) {}

  [[nodiscard]] const Geom_traits& geom_traits() const { return traits_; }

  [[nodiscard]] CGAL::Bbox_3 bbox() const {
    Eigen::AlignedBox3d box;
    for (const int v : queries_.triangles().faces().reshaped())
      box.extend(queries_.triangles().vertex(v));
    return {box.min().x(), box.min().y(), box.min().z(),
            box.max().x(), box.max().y(), box.max().z()};
  }

  [[nodiscard]] bool do_intersect(const Geom_traits::Ball_3& ball) const {
    const double distance = queries_.nearest(fromCgal(ball.boundary().center())).distance;
    return distance * distance <= ball.boundary().squared_radius();
  }

  template <class Traits>
  [[nodiscard]] bool do_intersect(
      const AW3::Tetrahedron_with_outside_info<Traits>& cell) const {
    const auto corner = [&](int i) {
      return fromCgal(cell.m_tet.vertex(i));
    };
    const Touch touch =
        queries_.touches({corner(0), corner(1), corner(2), corner(3)}, unclear_);
    if (touch != Touch::kTooCloseToTell) return touch == Touch::kYes;
    const auto do_intersect = traits_.do_intersect_3_object();
    return std::any_of(unclear_.begin(), unclear_.end(), [&](int f) {
      const geometry::TriangleMesh& mesh = queries_.triangles();
      const Eigen::Vector3i face = mesh.face(f);
      return do_intersect(
          cell, Kernel::Triangle_3(toCgal(mesh.vertex(face[0])), toCgal(mesh.vertex(face[1])),
                                   toCgal(mesh.vertex(face[2]))));
    });
  }

  [[nodiscard]] Kernel::Point_3 closest_point(const Kernel::Point_3& p) const {
    return toCgal(queries_.nearest(fromCgal(p)).position);
  }

  [[nodiscard]] double squared_distance(const Kernel::Point_3& p) const {
    const double distance = queries_.nearest(fromCgal(p)).distance;
    return distance * distance;
  }

  bool first_intersection(const Kernel::Point_3& p,
                          const Kernel::Point_3& q,
                          Kernel::Point_3& found,
                          double offset_m) const {
    const auto place = queries_.firstWithin(offset_m, fromCgal(p), fromCgal(q));
    if (place) found = toCgal(*place);
    return place.has_value();
  }

  // NOLINTEND(readability-identifier-naming)

 private:
  Geom_traits traits_;
  WrapQueries queries_;
  mutable std::vector<int> unclear_;
};

WrapMesh toCgal(const geometry::TriangleMesh& mesh) {
  WrapMesh result;
  result.reserve(static_cast<unsigned>(mesh.vertexCount()),
                 static_cast<unsigned>(mesh.faceCount() * 3 / 2),
                 static_cast<unsigned>(mesh.faceCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    result.add_vertex(toCgal(mesh.vertex(v)));
  }
  using Vertex = WrapMesh::Vertex_index;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    HANDGRAFT_REQUIRE(result.add_face(Vertex(static_cast<unsigned>(face[0])),
                                      Vertex(static_cast<unsigned>(face[1])),
                                      Vertex(static_cast<unsigned>(face[2]))) !=
                      WrapMesh::null_face());
  }
  return result;
}

geometry::TriangleMesh fromCgal(const WrapMesh& mesh) {
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(mesh.number_of_vertices()));
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(mesh.number_of_faces()));
  std::vector<int> index(mesh.num_vertices(), -1);
  int count = 0;
  for (const auto v : mesh.vertices()) {
    vertices.col(count) = fromCgal(mesh.point(v));
    index[v.idx()] = count++;
  }
  int face = 0;
  for (const auto f : mesh.faces()) {
    int corner = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
      faces(corner++, face) = index[v.idx()];
    ++face;
  }
  return {std::move(vertices), std::move(faces)};
}

}  // namespace

geometry::TriangleMesh wrapped(const geometry::TriangleMesh& triangles,
                               double alpha_m,
                               double offset_m,
                               const Progress& progress) {
  std::vector<int> faces;
  for (int f = 0; f < triangles.faceCount(); ++f)
    if (!triangles.faceNormals().col(f).isZero()) faces.push_back(f);
  if (faces.empty()) rejectInput("skin: there is no triangle with an area to wrap");
  const Oracle oracle(
      geometry::TriangleMesh(triangles.vertices(), triangles.faces()(Eigen::all, faces)));
  AW3::Alpha_wrap_3<Oracle> wrapping(oracle);
  WrapMesh wrap;
  Checkpoint checkpoint(progress);
  wrapping(alpha_m, offset_m, wrap, CGAL::parameters::visitor(checkpoint));
  progress.checkpoint();
  return fromCgal(wrap);
}

geometry::TriangleMesh remeshed(const geometry::TriangleMesh& mesh, double edge_m) {
  WrapMesh result = toCgal(mesh);
  PMP::isotropic_remeshing(
      result.faces(), edge_m, result,
      CGAL::parameters::number_of_iterations(2).number_of_relaxation_steps(1));
  result.collect_garbage();
  return fromCgal(result);
}

std::vector<int> selfIntersectingFaces(const geometry::TriangleMesh& mesh) {
  const WrapMesh surface = toCgal(mesh);
  std::vector<std::pair<WrapMesh::Face_index, WrapMesh::Face_index>> pairs;
  PMP::self_intersections(surface, std::back_inserter(pairs));
  std::vector<int> faces;
  for (const auto& [a, b] : pairs) {
    faces.push_back(static_cast<int>(a.idx()));
    faces.push_back(static_cast<int>(b.idx()));
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

}  // namespace handgraft::hand
