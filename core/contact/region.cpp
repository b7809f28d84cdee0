#include "core/contact/region.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/base/error.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostSources = 24;  // places on the loop that stand for all of it

double lengthOf(const TriangleMesh& mesh, const std::vector<int>& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    length += (mesh.vertex(loop[(i + 1) % loop.size()]) - mesh.vertex(loop[i])).norm();
  }
  return length;
}

/// Cuts a closed walk into loops that pass each vertex once; walks to and fro vanish.
void splitIntoSimpleLoops(const std::vector<int>& walk, std::vector<std::vector<int>>& loops) {
  std::vector<int> path;
  std::unordered_map<int, std::size_t> place;
  for (const int v : walk) {
    const auto seen = place.find(v);
    if (seen != place.end()) {
      const std::size_t start = seen->second;
      std::vector<int> loop(path.begin() + static_cast<std::ptrdiff_t>(start), path.end());
      for (const int cut : loop)
        place.erase(cut);
      path.resize(start);
      if (loop.size() >= 3) loops.push_back(std::move(loop));
    }
    place[v] = path.size();
    path.push_back(v);
  }
  if (path.size() >= 3) loops.push_back(std::move(path));
}

/// The vertices and paths of a region, renumbered from 0 in the order of mesh indices.
class RegionGraph {
 public:
  RegionGraph(const TriangleMesh& mesh, const Region& region) {
    for (const int f : region) {
      for (int corner = 0; corner < 3; ++corner)
        vertices_.push_back(mesh.face(f)[corner]);
    }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    neighbours_.resize(vertices_.size());
    const std::unordered_set<int> faces(region.begin(), region.end());
    for (const int f : region) {
      for (int h = 3 * f; h < 3 * f + 3; ++h) {
        connect(mesh, mesh.from(h), mesh.to(h));
        const int twin = mesh.twin(h);
        if (twin > h && faces.count(TriangleMesh::faceOf(twin)) != 0)
          connectAcross(mesh, h, twin);
      }
    }
  }

  [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }

  [[nodiscard]] std::size_t indexOf(int v) const {
    const auto at = std::lower_bound(vertices_.begin(), vertices_.end(), v);
    HANDGRAFT_REQUIRE(at != vertices_.end() && *at == v);
    return static_cast<std::size_t>(at - vertices_.begin());
  }

  /// Dijkstra from one vertex, by index.
  [[nodiscard]] std::vector<double> distancesFrom(std::size_t source) const {
    using Entry = std::pair<double, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    std::vector<double> distance(vertices_.size(), kInfinity);
    distance[source] = 0.0;
    queue.emplace(0.0, source);
    while (!queue.empty()) {
      const auto [d, i] = queue.top();
      queue.pop();
      if (d > distance[i]) continue;
      for (const auto& [length, j] : neighbours_[i]) {
        if (d + length >= distance[j]) continue;
        distance[j] = d + length;
        queue.emplace(distance[j], j);
      }
    }
    return distance;
  }

 private:
  void connect(const TriangleMesh& mesh, int a, int b) {
    connect(a, b, (mesh.vertex(a) - mesh.vertex(b)).norm());
  }

  void connect(int a, int b, double length) {
    neighbours_[indexOf(a)].emplace_back(length, indexOf(b));
    neighbours_[indexOf(b)].emplace_back(length, indexOf(a));
  }

  /// Unfolds the two faces of an edge into a plane and joins their tips by a straight line,
  /// where that line crosses the edge.
  void connectAcross(const TriangleMesh& mesh, int h, int twin) {
    const int tip_a = mesh.from(TriangleMesh::previous(h));
    const int tip_b = mesh.from(TriangleMesh::previous(twin));
    const Eigen::Vector3d origin = mesh.vertex(mesh.from(h));
    const Eigen::Vector3d edge = mesh.vertex(mesh.to(h)) - origin;
    const double length = edge.norm();
    if (tip_a == tip_b || !(length > 0.0)) return;
    const auto unfold = [&](int tip) {
      const Eigen::Vector3d d = mesh.vertex(tip) - origin;
      const double along = d.dot(edge) / length;
      return Eigen::Vector2d(along, std::sqrt(std::max(0.0, d.squaredNorm() - along * along)));
    };
    const Eigen::Vector2d a = unfold(tip_a);
    const Eigen::Vector2d b = unfold(tip_b);
    const double height = a.y() + b.y();
    if (!(height > 0.0)) return;
    const double crossing = (a.x() * b.y() + b.x() * a.y()) / height;
    if (crossing < 0.0 || crossing > length) return;
    connect(tip_a, tip_b, std::hypot(a.x() - b.x(), height));
  }

  std::vector<int> vertices_;
  std::vector<std::vector<std::pair<double, std::size_t>>> neighbours_;
};

}  // namespace

std::vector<Region> connectedRegions(const TriangleMesh& mesh,
                                     const std::vector<char>& marked) {
  HANDGRAFT_REQUIRE(std::ssize(marked) == mesh.faceCount());
  std::vector<char> open = marked;
  std::vector<Region> regions;
  for (int first = 0; first < mesh.faceCount(); ++first) {
    if (open[first] == 0) continue;
    Region region = {first};
    open[first] = 0;
    for (std::size_t i = 0; i < region.size(); ++i) {
      for (int h = 3 * region[i]; h < 3 * region[i] + 3; ++h) {
        const int twin = mesh.twin(h);
        if (twin < 0 || open[TriangleMesh::faceOf(twin)] == 0) continue;
        open[TriangleMesh::faceOf(twin)] = 0;
        region.push_back(TriangleMesh::faceOf(twin));
      }
    }
    regions.push_back(std::move(region));
  }
  return regions;
}

OuterBoundary outerBoundary(const TriangleMesh& mesh, const Region& region) {
  const std::unordered_set<int> faces(region.begin(), region.end());
  const auto leads_out = [&](int h) {
    return mesh.twin(h) < 0 || faces.count(TriangleMesh::faceOf(mesh.twin(h))) == 0;
  };

  std::vector<std::vector<int>> loops;
  std::unordered_set<int> walked;
  for (const int f : region) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      if (!leads_out(h) || walked.count(h) != 0) continue;
      std::vector<int> walk;
      for (int at = h; walked.insert(at).second;) {
        walk.push_back(mesh.from(at));
        // Turn about the edge's end, inside the region, until an edge leads out of it again.
        at = TriangleMesh::next(at);
        while (!leads_out(at))
          at = TriangleMesh::next(mesh.twin(at));
      }
      splitIntoSimpleLoops(walk, loops);
    }
  }

  OuterBoundary boundary;
  double longest = -1.0;
  for (std::vector<int>& loop : loops) {
    const double length = lengthOf(mesh, loop);
    if (length <= longest) continue;
    longest = length;
    boundary.loop = std::move(loop);
  }
  boundary.other_loops = std::max(0, static_cast<int>(loops.size()) - 1);
  return boundary;
}

int geodesicCentre(const TriangleMesh& mesh,
                   const Region& region,
                   const std::vector<int>& loop) {
  HANDGRAFT_REQUIRE(!region.empty() && !loop.empty());
  const RegionGraph graph(mesh, region);
  const std::size_t count = graph.vertices().size();
  std::vector<double> farthest(count, 0.0);
  std::vector<double> sum(count, 0.0);
  const std::size_t sources = std::min<std::size_t>(loop.size(), kMostSources);
  for (std::size_t k = 0; k < sources; ++k) {
    const int source = loop[k * loop.size() / sources];
    const std::vector<double> distance = graph.distancesFrom(graph.indexOf(source));
    for (std::size_t i = 0; i < count; ++i) {
      farthest[i] = std::max(farthest[i], distance[i]);
      sum[i] += distance[i];
    }
  }

  const std::unordered_set<int> on_loop(loop.begin(), loop.end());
  std::size_t best = count;
  const auto better = [&](std::size_t i, std::size_t j) {
    const bool i_outside = on_loop.count(graph.vertices()[i]) != 0;
    const bool j_outside = on_loop.count(graph.vertices()[j]) != 0;
    if (i_outside != j_outside) return j_outside;
    return std::pair(farthest[i], sum[i]) < std::pair(farthest[j], sum[j]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (best == count || better(i, best)) best = i;
  }
  return graph.vertices()[best];
}

}  // namespace handgraft::contact
