#include "core/cloud/triangle_soup.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace handgraft::cloud {

namespace {

/// For every triangle's edge (corner to next) the triangle beyond, -1 where there is not
/// exactly one.
std::vector<std::array<int, 3>> neighboursOf(const Triangles& triangles) {
  std::vector<std::tuple<int, int, int, int>> edges;  // low vertex, high vertex, triangle, edge
  edges.reserve(3 * triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(triangles[t][c], triangles[t][(c + 1) % 3]);
      edges.emplace_back(low, high, t, c);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::array<int, 3>> neighbours(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && std::get<0>(edges[end]) == std::get<0>(edges[i]) &&
           std::get<1>(edges[end]) == std::get<1>(edges[i]))
      ++end;
    if (end - i == 2) {
      const auto& [low, high, a, a_edge] = edges[i];
      const auto& [low_b, high_b, b, b_edge] = edges[i + 1];
      neighbours[a][a_edge] = b;
      neighbours[b][b_edge] = a;
    }
    i = end;
  }
  return neighbours;
}

bool runsAlong(const std::array<int, 3>& triangle, int from, int to) {
  bool runs = false;
  for (int c = 0; c < 3; ++c)
    runs |= triangle[c] == from && triangle[(c + 1) % 3] == to;
  return runs;
}

/// Turns every component's triangles to agree with its first one.
void orient(Triangles& triangles) {
  const std::vector<std::array<int, 3>> neighbours = neighboursOf(triangles);
  // Indexed by the edges as they were: turning a triangle renames its edges.
  const Triangles before = triangles;
  std::vector<char> turned(triangles.size(), -1);
  std::vector<int> open;
  for (int first = 0; first < static_cast<int>(triangles.size()); ++first) {
    if (turned[first] >= 0) continue;
    turned[first] = 0;
    open.push_back(first);
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      for (int c = 0; c < 3; ++c) {
        const int other = neighbours[t][c];
        if (other < 0 || turned[other] >= 0) continue;
        // Both run along the edge: they disagree.
        const bool same_way = runsAlong(before[other], before[t][c], before[t][(c + 1) % 3]);
        turned[other] = static_cast<char>(same_way ? 1 - turned[t] : turned[t]);
        open.push_back(other);
      }
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (turned[t] == 1) std::swap(triangles[t][1], triangles[t][2]);
}

}  // namespace

geometry::TriangleMesh orientedMesh(const std::vector<Eigen::Vector3d>& vertices,
                                    Triangles triangles) {
  orient(triangles);
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t v = 0; v < vertices.size(); ++v)
    points.col(static_cast<Eigen::Index>(v)) = vertices[v];
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int c = 0; c < 3; ++c)
      faces(c, static_cast<Eigen::Index>(t)) = triangles[t][c];
  return {std::move(points), std::move(faces)};
}

}  // namespace handgraft::cloud
