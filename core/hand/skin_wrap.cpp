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

WrapMesh toCgal(const geometry::TriangleMesh& mesh) {
  WrapMesh result;
  result.reserve(static_cast<unsigned>(mesh.vertexCount()),
                 static_cast<unsigned>(mesh.faceCount() * 3 / 2),
                 static_cast<unsigned>(mesh.faceCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const Eigen::Vector3d p = mesh.vertex(v);
    result.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z()));
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
    const Kernel::Point_3& p = mesh.point(v);
    vertices.col(count) << p.x(), p.y(), p.z();
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
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> faces;
  points.reserve(static_cast<std::size_t>(triangles.vertexCount()));
  for (int v = 0; v < triangles.vertexCount(); ++v) {
    const Eigen::Vector3d p = triangles.vertex(v);
    points.emplace_back(p.x(), p.y(), p.z());
  }
  for (int f = 0; f < triangles.faceCount(); ++f) {
    if (triangles.faceNormals().col(f).isZero()) continue;
    const Eigen::Vector3i face = triangles.face(f);
    faces.push_back({static_cast<std::size_t>(face[0]), static_cast<std::size_t>(face[1]),
                     static_cast<std::size_t>(face[2])});
  }
  if (faces.empty()) rejectInput("skin: there is no triangle with an area to wrap");
  WrapMesh wrap;
  Checkpoint checkpoint(progress);
  // Of the two lists of options it is the second that the wrapping sees.
  CGAL::alpha_wrap_3(points, faces, alpha_m, offset_m, wrap, CGAL::parameters::default_values(),
                     CGAL::parameters::visitor(checkpoint));
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
