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

// Cosine of how far a rigid finger's skin turns where it touches: a face that looks farther
// away from where the patch looks is round an edge.
constexpr double kTurned = 0.26;  // 75 degrees

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

struct Facing {
  Eigen::Vector3d n_O;
  double weight = 0.0;  ///< contact integrated over the face
};

double contactTowards(const Eigen::Vector3d& d, const std::vector<Facing>& faces) {
  double contact = 0.0;
  for (const Facing& face : faces)
    contact += face.weight * std::max(0.0, face.n_O.dot(d));
  return contact;
}

/// Where most of the contact looks. Of a rim that is touched on both sides the mean looks
/// nowhere: so the best of directions all round is taken, and then the mean about it.
Eigen::Vector3d facingOf(const std::vector<Facing>& faces) {
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double most = -1.0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Eigen::Vector3d d = Eigen::Vector3d(x, y, z).normalized();
        const double contact = contactTowards(d, faces);
        if (contact > most) {
          most = contact;
          best = d;
        }
      }
    }
  }
  constexpr int kSteps = 5;
  for (int i = 0; i < kSteps; ++i) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Facing& face : faces)
      if (face.n_O.dot(best) > kTurned) mean += face.weight * face.n_O;
    if (mean.norm() > 0.0) best = mean.normalized();
  }
  return best;
}

}  // namespace

std::vector<Region> outlined(const TriangleMesh& mesh,
                             const Region& region,
                             const Eigen::VectorXd& value,
                             const Eigen::VectorXd& even,
                             const Eigen::VectorXd& areas,
                             const OutlineOptions& options) {
  const std::vector<int> vertices = verticesOf(mesh, region);
  const double top = topOf(vertices, value, areas);
  const double level = options.share * topOf(vertices, even, areas);
  const auto is_inside = [&](int v) {
    return even[v] > level || value[v] >= top;
  };
  std::vector<char> marked(static_cast<std::size_t>(mesh.faceCount()), 0);
  std::vector<int> inside;
  std::vector<Facing> facings;
  for (const int f : region) {
    const Eigen::Vector3i face = mesh.face(f);
    if (!(is_inside(face[0]) && is_inside(face[1]) && is_inside(face[2]))) continue;
    const Eigen::Vector3d a = mesh.vertex(face[0]);
    const Eigen::Vector3d twice = (mesh.vertex(face[1]) - a).cross(mesh.vertex(face[2]) - a);
    const double contact = (value[face[0]] + value[face[1]] + value[face[2]]) / 3.0;
    inside.push_back(f);
    facings.push_back({twice.normalized(), 0.5 * twice.norm() * contact});
  }
  const Eigen::Vector3d n_O = facingOf(facings);
  for (std::size_t i = 0; i < inside.size(); ++i)
    // A face without area looks nowhere; left out, it would be a hole.
    marked[static_cast<std::size_t>(inside[i])] =
        facings[i].weight == 0.0 || facings[i].n_O.dot(n_O) > kTurned ? 1 : 0;

  struct Part {
    Region faces;
    double area = 0.0;
    double contact = 0.0;
  };

  std::vector<Part> parts;
  for (Region& faces : connectedRegions(mesh, marked)) {
    Part part;
    for (const int f : faces) {
      const Eigen::Vector3i face = mesh.face(f);
      part.area += areaOf(mesh, f);
      part.contact +=
          areaOf(mesh, f) * (value[face[0]] + value[face[1]] + value[face[2]]) / 3.0;
    }
    part.faces = std::move(faces);
    parts.push_back(std::move(part));
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.contact > b.contact;
  });
  if (parts.empty() || parts.front().area < options.minimum_area_m2 ||
      !(parts.front().contact > 0.0))
    return {region};
  std::vector<Region> outlines;
  for (Part& part : parts)
    if (outlines.empty() || part.area >= options.minimum_area_m2)
      outlines.push_back(std::move(part.faces));
  return outlines;
}

}  // namespace handgraft::contact
