#include "core/contact/outline.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

/// Single vertices may be far above what a region reaches.
constexpr double kTopShare = 0.05;

std::vector<int> verticesOf(const TriangleMesh& mesh, const Region& region) {
  std::vector<int> vertices;
  for (const int f : region)
    for (const int v : mesh.face(f))
      vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// The largest value that at least `kTopShare` of the vertices' area reaches.
double topOf(std::vector<int> vertices,
             const Eigen::VectorXd& value,
             const Eigen::VectorXd& areas) {
  std::stable_sort(vertices.begin(), vertices.end(), [&](int a, int b) {
    return value[a] > value[b];
  });
  double whole = 0.0;
  for (const int v : vertices)
    whole += areas[v];
  double above = 0.0;
  for (const int v : vertices) {
    above += areas[v];
    if (above >= kTopShare * whole) return value[v];
  }
  return 0.0;
}

double areaOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3d a = mesh.vertex(mesh.face(f)[0]);
  return 0.5 *
         (mesh.vertex(mesh.face(f)[1]) - a).cross(mesh.vertex(mesh.face(f)[2]) - a).norm();
}

}  // namespace

Region outlined(const TriangleMesh& mesh,
                const Region& region,
                const Eigen::VectorXd& value,
                const Eigen::VectorXd& even,
                const Eigen::VectorXd& areas,
                const OutlineOptions& options) {
  const std::vector<int> vertices = verticesOf(mesh, region);
  const double top = topOf(vertices, value, areas);
  const double level = options.share * topOf(vertices, even, areas);
  const auto isInside = [&](int v) {
    return even[v] > level || value[v] >= top;
  };
  std::vector<char> marked(static_cast<std::size_t>(mesh.faceCount()), 0);
  for (const int f : region) {
    const Eigen::Vector3i face = mesh.face(f);
    marked[static_cast<std::size_t>(f)] =
        isInside(face[0]) && isInside(face[1]) && isInside(face[2]) ? 1 : 0;
  }

  Region best;
  double most_contact = 0.0;
  double best_area = 0.0;
  for (Region& part : connectedRegions(mesh, marked)) {
    double area = 0.0;
    double contact = 0.0;
    for (const int f : part) {
      const Eigen::Vector3i face = mesh.face(f);
      area += areaOf(mesh, f);
      contact += areaOf(mesh, f) * (value[face[0]] + value[face[1]] + value[face[2]]) / 3.0;
    }
    if (contact <= most_contact) continue;
    most_contact = contact;
    best_area = area;
    best = std::move(part);
  }
  return best.empty() || best_area < options.minimum_area_m2 ? region : best;
}

}  // namespace handgraft::contact
