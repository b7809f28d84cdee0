#include "core/cloud/pinholes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace handgraft::cloud {

namespace {

using geometry::TriangleMesh;

constexpr int kMostEdges = 24;

bool isEdge(const TriangleMesh& mesh, int a, int b) {
  return std::any_of(mesh.outgoingBegin(a), mesh.outgoingEnd(a), [&](int h) {
    return mesh.to(h) == b || mesh.from(TriangleMesh::previous(h)) == b;
  });
}

/// Area, and a little of its edges: flat holes have many triangulations of the same area, of
/// which the one with short diagonals is wanted.
double costOf(const TriangleMesh& mesh, int a, int b, int c) {
  const Eigen::Vector3d ab = mesh.vertex(b) - mesh.vertex(a);
  const Eigen::Vector3d ac = mesh.vertex(c) - mesh.vertex(a);
  return 0.5 * ab.cross(ac).norm() +
         1e-2 * (ab.squaredNorm() + ac.squaredNorm() + (ac - ab).squaredNorm());
}

/// The triangles over a loop, looking as the faces around it; none if every way needs an edge
/// that the mesh has.
std::optional<std::vector<Eigen::Vector3i>> lidOf(const TriangleMesh& mesh,
                                                  const std::vector<int>& loop) {
  const auto count = static_cast<int>(loop.size());
  constexpr double kNever = std::numeric_limits<double>::infinity();
  // cost[i][j]: of the best lid between vertices i..j of the loop and the diagonal from j to i.
  std::vector<std::vector<double>> cost(count, std::vector<double>(count, 0.0));
  std::vector<std::vector<int>> apex(count, std::vector<int>(count, -1));
  for (int span = 2; span < count; ++span) {
    for (int i = 0; i + span < count; ++i) {
      const int j = i + span;
      cost[i][j] = kNever;
      if (span + 1 < count && isEdge(mesh, loop[i], loop[j])) continue;
      for (int k = i + 1; k < j; ++k) {
        if (cost[i][k] == kNever || cost[k][j] == kNever) continue;
        const double total = cost[i][k] + cost[k][j] + costOf(mesh, loop[i], loop[k], loop[j]);
        if (total < cost[i][j]) {
          cost[i][j] = total;
          apex[i][j] = k;
        }
      }
    }
  }
  if (cost[0][count - 1] == kNever) return std::nullopt;
  std::vector<Eigen::Vector3i> lid;
  std::vector<std::pair<int, int>> open{{0, count - 1}};
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    const int k = apex[i][j];
    if (k < 0) continue;  // an edge of the loop
    // The faces run along the loop, so the lid runs against it.
    lid.emplace_back(loop[j], loop[k], loop[i]);
    open.emplace_back(i, k);
    open.emplace_back(k, j);
  }
  return lid;
}

}  // namespace

std::vector<std::vector<int>> borderLoops(const TriangleMesh& mesh) {
  std::vector<std::vector<int>> loops;
  std::vector<char> used(static_cast<std::size_t>(3 * mesh.faceCount()), 0);
  std::vector<int> place(static_cast<std::size_t>(mesh.vertexCount()), -1);  // on `path`
  std::vector<int> path;
  const auto unused_from = [&](int v) {
    const auto h = std::find_if(mesh.outgoingBegin(v), mesh.outgoingEnd(v), [&](int candidate) {
      return mesh.twin(candidate) < 0 && used[candidate] == 0;
    });
    return h == mesh.outgoingEnd(v) ? -1 : *h;
  };
  for (int first = 0; first < 3 * mesh.faceCount(); ++first) {
    if (mesh.twin(first) >= 0 || used[first] != 0) continue;
    path.assign(1, mesh.from(first));
    place[path.front()] = 0;
    for (int h = first; h >= 0; h = unused_from(path.back())) {
      used[h] = 1;
      const int v = mesh.to(h);
      if (place[v] < 0) {
        place[v] = static_cast<int>(path.size());
        path.push_back(v);
        continue;
      }
      // Back at a vertex: what lies between is a loop; the path goes on from there.
      loops.emplace_back(path.begin() + place[v], path.end());
      while (path.back() != v) {
        place[path.back()] = -1;
        path.pop_back();
      }
    }
    for (const int v : path)
      place[v] = -1;
  }
  return loops;
}

double widthOf(const TriangleMesh& mesh, const std::vector<int>& loop) {
  double squared = 0.0;
  // Loops of thousands of vertices are measured at every few of them.
  const std::size_t step = 1 + loop.size() / 1000;
  for (std::size_t i = 0; i < loop.size(); i += step)
    for (std::size_t j = 0; j < i; j += step)
      squared = std::max(squared, (mesh.vertex(loop[i]) - mesh.vertex(loop[j])).squaredNorm());
  return std::sqrt(squared);
}

Mended closePinholes(const TriangleMesh& mesh, double widest) {
  Mended mended;
  std::vector<Eigen::Vector3i> faces;
  if (mesh.nonManifoldEdgeCount() == 0) {
    for (const std::vector<int>& loop : borderLoops(mesh)) {
      if (loop.size() < 3 || loop.size() > kMostEdges) continue;
      const double width = widthOf(mesh, loop);
      if (width > widest) continue;
      const auto lid = lidOf(mesh, loop);
      if (!lid) continue;
      faces.insert(faces.end(), lid->begin(), lid->end());
      ++mended.closed;
      mended.widest = std::max(mended.widest, width);
    }
  }
  Eigen::Matrix3Xi all(3, mesh.faceCount() + std::ssize(faces));
  all.leftCols(mesh.faceCount()) = mesh.faces();
  for (std::size_t f = 0; f < faces.size(); ++f)
    all.col(mesh.faceCount() + static_cast<Eigen::Index>(f)) = faces[f];
  mended.mesh = TriangleMesh(mesh.vertices(), std::move(all));
  // Two lids may have met at a diagonal that neither saw: rather holes than such an edge.
  if (mended.mesh.nonManifoldEdgeCount() > mesh.nonManifoldEdgeCount()) mended = {mesh, 0, 0.0};
  return mended;
}

}  // namespace handgraft::cloud
