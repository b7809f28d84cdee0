#include "client/present/render/corner_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

namespace handgraft::client::render {

namespace {

// For each vertex the first vertex at the same place.
std::vector<std::uint32_t> weld(const std::vector<Eigen::Vector3f>& vertices) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3f& p = vertices[a];
    const Eigen::Vector3f& q = vertices[b];
    for (int k = 0; k < 3; ++k) {
      // NaN has no place in an order; each such vertex stays alone at the end.
      const bool p_nan = std::isnan(p[k]);
      const bool q_nan = std::isnan(q[k]);
      if (p_nan != q_nan) return q_nan;
      if (!p_nan && p[k] != q[k]) return p[k] < q[k];
    }
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<std::uint32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace

std::vector<Eigen::Vector3f> cornerNormals(const SurfaceMesh& mesh, double crease_rad) {
  const std::vector<std::uint32_t> place = weld(mesh.vertices_W);

  // === The area vector of each face, and the faces around each place
  std::vector<Eigen::Vector3f> area(mesh.triangles.size());
  std::vector<Eigen::Vector3f> unit(mesh.triangles.size());
  std::vector<std::uint32_t> begin(mesh.vertices_W.size() + 1, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3f& p = mesh.vertices_W[a];
    area[t] = (mesh.vertices_W[b] - p).cross(mesh.vertices_W[c] - p);
    const float length = area[t].norm();
    if (!(length > 0.0F) || !std::isfinite(length)) area[t].setZero();
    unit[t] = area[t].isZero(0.0F) ? area[t] : Eigen::Vector3f(area[t] / length);
    for (const std::uint32_t vertex : mesh.triangles[t])
      ++begin[place[vertex] + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> faces(3 * mesh.triangles.size());
  std::vector<std::uint32_t> filled(begin.begin(), begin.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t vertex : mesh.triangles[t]) {
      faces[filled[place[vertex]]++] = static_cast<std::uint32_t>(t);
    }
  }

  // === The mean over those that bend less than a crease
  // A place where very many faces meet would cost the square of their number.
  constexpr std::uint32_t kMostFaces = 64;
  const auto least_cosine = static_cast<float>(std::cos(crease_rad));
  std::vector<Eigen::Vector3f> normals(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t at = place[mesh.triangles[t][k]];
      const std::uint32_t end = std::min(begin[at + 1], begin[at] + kMostFaces);
      Eigen::Vector3f sum = area[t];
      for (std::uint32_t i = begin[at]; i < end; ++i) {
        if (faces[i] != t && unit[faces[i]].dot(unit[t]) >= least_cosine) sum += area[faces[i]];
      }
      const float length = sum.norm();
      normals[3 * t + k] = length > 0.0F ? Eigen::Vector3f(sum / length) : unit[t];
    }
  }
  return normals;
}

}  // namespace handgraft::client::render
