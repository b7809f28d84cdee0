#include "core/hand/link_facets.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/sample_thinning.h"

namespace handgraft::hand {

namespace {

using Eigen::Vector3d;

constexpr double kHiddenSpacing = 0.003;  // m, before samples are spread: as those of reports

// Faces that meet at more than that, outwards, make an edge; where three edges meet, a corner.
constexpr double kSharp = 0.5;           // rad
constexpr double kEdgeSpacing = 0.0015;  // m, before samples are spread
constexpr int kCorner = 3;
constexpr int kMostCuts = 64;  // of an edge
constexpr std::size_t kMostSharp = 20000;

/// Points all over a mesh, no farther apart than `kHiddenSpacing` or so, with their shares of
/// its area.
std::vector<Facet> facetsAllOver(const geometry::TriangleMesh& mesh_L) {
  std::vector<Facet> facets;
  for (int f = 0; f < mesh_L.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh_L.face(f);
    const Vector3d a = mesh_L.vertex(face[0]);
    const Vector3d u = mesh_L.vertex(face[1]) - a;
    const Vector3d v = mesh_L.vertex(face[2]) - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int cuts = std::clamp(static_cast<int>(std::ceil(longest / kHiddenSpacing)), 1, 64);
    Facet facet;
    facet.n_L = mesh_L.faceNormals().col(f);
    facet.area_m2 = 0.5 * u.cross(v).norm() / (cuts * cuts);
    // The middles of the triangles that parallels to the sides cut out of it, both ways up.
    for (int i = 0; i < cuts; ++i) {
      for (int j = 0; i + j < cuts; ++j) {
        facet.p_L = a + ((i + 1.0 / 3.0) * u + (j + 1.0 / 3.0) * v) / cuts;
        facets.push_back(facet);
        if (i + j + 1 >= cuts) continue;
        facet.p_L = a + ((i + 2.0 / 3.0) * u + (j + 2.0 / 3.0) * v) / cuts;
        facets.push_back(facet);
      }
    }
  }
  return facets;
}

/// Leaves out what is within `spacing` of one before it.
void thinOut(double spacing, std::vector<Facet>& facets) {
  Eigen::Matrix3Xd points(3, std::ssize(facets));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = facets[static_cast<std::size_t>(i)].p_L;
  std::vector<Facet> kept;
  for (const int k :
       geometry::thinOut(points, std::vector<int>(facets.size(), 0), spacing).kept)
    kept.push_back(facets[static_cast<std::size_t>(k)]);
  facets = std::move(kept);
}

}  // namespace

std::vector<Facet> facetsOf(const Skin& skin, const LinkPoses& X_SL) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  std::vector<Facet> facets;
  for (int f = 0; f < mesh_S.faceCount(); ++f) {
    const int link = skin.faceLinks()[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    const Eigen::Vector3i face = mesh_S.face(f);
    const Vector3d a = mesh_S.vertex(face[0]);
    const Vector3d b = mesh_S.vertex(face[1]);
    const Vector3d c = mesh_S.vertex(face[2]);
    Facet facet;
    facet.link = link;
    facet.p_S = (a + b + c) / 3.0;
    facet.p_L = inverse(X_SL[static_cast<std::size_t>(link)]) * facet.p_S;
    facet.area_m2 = 0.5 * (b - a).cross(c - a).norm();
    facets.push_back(facet);
  }
  return facets;
}

void projectOntoLinks(const Skin& skin, const LinkPoses& X_SL, std::vector<Facet>& facets) {
  for (Facet& facet : facets) {
    const auto hit = skin.links().nearestOf(facet.link, facet.p_S, skin.epsilon());
    if (!hit) continue;
    facet.p_L = inverse(X_SL[static_cast<std::size_t>(facet.link)]) * hit->position_S;
    facet.offset = hit->distance_m;
  }
}

void addHidden(const geometry::SignedDistance& own,
               const geometry::SignedDistance& part,
               int link,
               const Pose& X_SL,
               std::vector<Facet>& facets) {
  const std::vector<Facet> all = facetsAllOver(own.surface());
  Eigen::Matrix3Xd points(3, std::ssize(all));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = all[static_cast<std::size_t>(i)].p_L;
  const geometry::Thinned thinned =
      geometry::thinOut(points, std::vector<int>(all.size(), 0), kHiddenSpacing);
  std::vector<double> areas(thinned.kept.size(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i)
    areas[static_cast<std::size_t>(thinned.nearest[i])] += all[i].area_m2;
  for (std::size_t k = 0; k < thinned.kept.size(); ++k) {
    Facet facet = all[static_cast<std::size_t>(thinned.kept[k])];
    if (part.isWithin(facet.p_L, kHidden)) continue;
    // A wall within the solid borders nothing.
    const Vector3d off = 0.5 * kHidden * facet.n_L;
    if (own.contains(facet.p_L + off) && own.contains(facet.p_L - off)) continue;
    facet.link = link;
    facet.p_S = X_SL * facet.p_L;
    facet.area_m2 = areas[k];
    facets.push_back(facet);
  }
}

void addSharp(const geometry::SignedDistance& own,
              const geometry::SignedDistance& part,
              bool is_solid,
              double beneath,
              int link,
              const Pose& X_SL,
              std::vector<Facet>& facets) {
  const geometry::TriangleMesh& mesh_L = own.surface();
  std::vector<Facet> corners;
  std::vector<Facet> edges;
  std::vector<int> sharp_at(static_cast<std::size_t>(mesh_L.vertexCount()), 0);
  const auto add = [&](const Vector3d& p_L, const Vector3d& n_L, std::vector<Facet>& to) {
    Facet facet;
    facet.link = link;
    facet.p_L = p_L;
    facet.p_S = X_SL * p_L;
    facet.n_L = n_L;
    facet.is_sharp = true;
    to.push_back(facet);
  };
  for (int h = 0; h < 3 * mesh_L.faceCount(); ++h) {
    const int twin = mesh_L.twin(h);
    if (twin < h) continue;  // of both halves one
    const Vector3d n = mesh_L.faceNormals().col(geometry::TriangleMesh::faceOf(h));
    const Vector3d other = mesh_L.faceNormals().col(geometry::TriangleMesh::faceOf(twin));
    const Vector3d a = mesh_L.vertex(mesh_L.from(h));
    const Vector3d b = mesh_L.vertex(mesh_L.to(h));
    if (n.dot(other) > std::cos(kSharp) || n.cross(other).dot(b - a) <= 0.0) continue;
    const Vector3d n_L = (n + other).normalized();
    for (const int v : {mesh_L.from(h), mesh_L.to(h)})
      if (++sharp_at[static_cast<std::size_t>(v)] == kCorner)
        add(mesh_L.vertex(v), n_L, corners);
    const int cuts =
        std::clamp(static_cast<int>(std::ceil((b - a).norm() / kEdgeSpacing)), 1, kMostCuts);
    for (int i = 0; i <= cuts; ++i)
      add(a + (b - a) * i / cuts, n_L, edges);
  }
  corners.insert(corners.end(), edges.begin(), edges.end());
  // Screw threads and scans are all edges, and a look inside is dear.
  if (corners.size() > kMostSharp) thinOut(kEdgeSpacing, corners);
  std::erase_if(corners, [&](const Facet& facet) {
    return (!is_solid && !part.isWithin(facet.p_L, beneath)) ||
           own.contains(facet.p_L + 0.5 * kHidden * facet.n_L);
  });
  // Samples are what comes first.
  facets.insert(facets.begin(), corners.begin(), corners.end());
}

}  // namespace handgraft::hand
