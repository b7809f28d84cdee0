#include "core/geometry/log_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/dgpc.h"
#include "core/geometry/exact_geodesics.h"
#include "core/geometry/heat_log_map.h"
#include "core/geometry/index_map.h"
#include "core/geometry/log_map_source.h"

namespace handgraft::geometry {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-12;  // of a radius

double distanceToOrigin(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length_squared = ab.squaredNorm();
  const double t =
      length_squared > 0.0 ? std::clamp(-a.dot(ab) / length_squared, 0.0, 1.0) : 0.0;
  return (a + t * ab).norm();
}

/// Sorts what the front touched into the disk and its rim.
template <class Front>
class DiskBuilder {
 public:
  DiskBuilder(const TriangleMesh& mesh, const Front& front, double radius, LogMap& map)
      : mesh_(mesh), front_(front), radius_(radius), map_(map) {}

  void addVertices() {
    map_.r.setConstant(mesh_.vertexCount(), kNaN);
    map_.phi.setConstant(mesh_.vertexCount(), kNaN);
    for (const auto& node : front_.nodes()) {
      if (!(node.r <= radius_ && std::isfinite(node.r))) continue;  // touched, not reached
      map_.vertices.push_back(node.vertex);
      map_.r[node.vertex] = node.r;
      map_.phi[node.vertex] = node.r > 0.0 ? node.phi() : 0.0;
    }
    std::sort(map_.vertices.begin(), map_.vertices.end(), [&](int a, int b) {
      return std::pair(map_.r[a], a) < std::pair(map_.r[b], b);
    });
  }

  void addFaces(const std::vector<int>& source_faces) {
    for (const auto& node : front_.nodes()) {
      for (const int* h = mesh_.outgoingBegin(node.vertex); h != mesh_.outgoingEnd(node.vertex);
           ++h) {
        // Each face once: at the lowest of its corners.
        if (node.vertex < mesh_.to(*h) &&
            node.vertex < mesh_.from(TriangleMesh::previous(*h))) {
          addFace(TriangleMesh::faceOf(*h), source_faces);
        }
      }
    }
    const auto by_vertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex < b.vertex;
    };
    std::sort(map_.rim.begin(), map_.rim.end(), by_vertex);
    const auto same_vertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex == b.vertex;
    };
    map_.rim.erase(std::unique(map_.rim.begin(), map_.rim.end(), same_vertex), map_.rim.end());
    std::sort(map_.faces.begin(), map_.faces.end());
    std::sort(map_.rim_faces.begin(), map_.rim_faces.end());
  }

 private:
  void addFace(int f, const std::vector<int>& source_faces) {
    const typename Front::Node* corners[3];
    bool inside = true;
    for (int c = 0; c < 3; ++c) {
      corners[c] = front_.nodeOf(mesh_.faces()(c, f));
      if (!corners[c]) return;
      inside = inside && corners[c]->r <= radius_;
    }
    const bool at_source =
        std::find(source_faces.begin(), source_faces.end(), f) != source_faces.end();
    if (inside) {
      map_.faces.push_back(f);
      return;
    }
    const Eigen::Vector2d p_T[3] = {corners[0]->position(), corners[1]->position(),
                                    corners[2]->position()};
    if (at_source) {
      map_.faces.push_back(f);
    } else if (reachesIn(*corners[0], *corners[1]) || reachesIn(*corners[1], *corners[2]) ||
               reachesIn(*corners[2], *corners[0])) {
      map_.rim_faces.push_back(f);
    } else {
      return;
    }
    for (int c = 0; c < 3; ++c) {
      if (corners[c]->r > radius_) map_.rim.push_back({corners[c]->vertex, p_T[c]});
    }
  }

  /// In T, and on the surface, too: an edge that joins two sides of the cut locus passes near
  /// the source in T alone.
  [[nodiscard]] bool reachesIn(const typename Front::Node& a,
                               const typename Front::Node& b) const {
    const double length = (mesh_.vertex(a.vertex) - mesh_.vertex(b.vertex)).norm();
    return a.r + b.r - length <= 2.0 * radius_ * (1.0 + kRounding) &&
           distanceToOrigin(a.position(), b.position()) <= radius_;
  }

  const TriangleMesh& mesh_;
  const Front& front_;
  double radius_;
  LogMap& map_;
};

template <class Front>
LogMap diskOf(const TriangleMesh& mesh,
              const SourceLayout& layout,
              const Front& front,
              LogMap map) {
  DiskBuilder builder(mesh, front, map.radius, map);
  builder.addVertices();
  builder.addFaces(layout.faces);
  return map;
}

/// `empty` says what is wanted: source and radius.
LogMap fastMap(const TriangleMesh& mesh, const SourceLayout& layout, LogMap empty) {
  Dgpc front(mesh, layout, empty.radius);
  front.run();
  empty.method = LogMapMethod::kFast;
  return diskOf(mesh, layout, front, std::move(empty));
}

struct ExactMap {
  LogMap map;
  bool is_cut_short = false;
};

ExactMap exactMap(const TriangleMesh& mesh, const SourceLayout& layout, LogMap empty) {
  ExactGeodesics front(mesh, layout, empty.radius);
  front.run();
  empty.method = LogMapMethod::kExact;
  return {diskOf(mesh, layout, front, std::move(empty)), front.isCutShort()};
}

/// Faces that lie turned over in the tangent plane, or lose half of their area; counting stops
/// at `enough`.
int unsoundFaceCount(const TriangleMesh& mesh, const LogMap& map, int enough) {
  constexpr double kCollapsed = 0.5;
  constexpr double kThinnest = 1e-9;  // of the squared edges: no area that could collapse
  // Places of the disk's vertices, each taken from its polar coordinates once.
  IndexMap numbers(static_cast<int>(map.vertices.size() + map.rim.size()));
  std::vector<Eigen::Vector2d> places_T;
  for (const int v : map.vertices) {
    numbers.add(v);
    places_T.push_back(logCoordinatesAtVertex(map, v));
  }
  for (const LogMap::RimVertex& rim : map.rim) {
    numbers.add(rim.vertex);
    places_T.push_back(rim.p_T);
  }
  int count = 0;
  for (const std::vector<int>* faces : {&map.faces, &map.rim_faces}) {
    for (const int f : *faces) {
      if (count >= enough) return count;
      const Eigen::Vector3i face = mesh.face(f);
      const Eigen::Vector3d ab = mesh.vertex(face[1]) - mesh.vertex(face[0]);
      const Eigen::Vector3d ac = mesh.vertex(face[2]) - mesh.vertex(face[0]);
      const double area = ab.cross(ac).norm();
      if (area <= kThinnest * (ab.squaredNorm() + ac.squaredNorm())) continue;
      const Eigen::Vector2d a_T = places_T[numbers.find(face[0])];
      const Eigen::Vector2d ab_T = places_T[numbers.find(face[1])] - a_T;
      const Eigen::Vector2d ac_T = places_T[numbers.find(face[2])] - a_T;
      if (!(ab_T.x() * ac_T.y() - ab_T.y() * ac_T.x() > kCollapsed * area)) ++count;
    }
  }
  return count;
}

}  // namespace

LogMapMethod logMapMethodFrom(std::string_view name) {
  for (const LogMapMethod method :
       {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto, LogMapMethod::kSmooth,
        LogMapMethod::kHeat}) {
    if (name == nameOf(method)) return method;
  }
  rejectInput("log map method is {}, permitted: fast, exact, auto, smooth, heat",
              quoted(std::string(name)));
}

std::string_view nameOf(LogMapMethod method) {
  switch (method) {
    case LogMapMethod::kFast:
      return "fast";
    case LogMapMethod::kExact:
      return "exact";
    case LogMapMethod::kAuto:
      return "auto";
    case LogMapMethod::kSmooth:
      return "smooth";
    case LogMapMethod::kHeat:
      return "heat";
  }
  throw BrokenContract("a log map method that is not known");
}

LogMap computeLogMap(const TriangleMesh& mesh,
                     const SurfacePoint& source,
                     const Eigen::Vector3d& direction,
                     double radius,
                     LogMapMethod method) {
  validate(mesh, source, "log map source");
  if (!(radius > 0.0)) rejectInput("log map radius is {} m, it must be positive", radius);

  if (method == LogMapMethod::kSmooth) {
    return HeatLogMap(mesh).smooth(source, direction, radius);
  }
  if (method == LogMapMethod::kHeat) return HeatLogMap(mesh).heat(source, direction, radius);

  LogMap empty;
  empty.source = source;
  empty.radius = radius;
  const SourceLayout layout = layOutSource(mesh, source, direction);
  if (method == LogMapMethod::kFast) return fastMap(mesh, layout, std::move(empty));
  if (method == LogMapMethod::kExact) return exactMap(mesh, layout, std::move(empty)).map;

  ExactMap exact = exactMap(mesh, layout, empty);
  const bool is_upper_bound = exact.is_cut_short;
  if (!is_upper_bound && unsoundFaceCount(mesh, exact.map, 1) == 0) return std::move(exact.map);
  LogMap fast = fastMap(mesh, layout, std::move(empty));
  if (is_upper_bound) return fast;
  const int unsound = unsoundFaceCount(mesh, fast, std::numeric_limits<int>::max());
  const bool is_better =
      unsound == 0 || unsound < unsoundFaceCount(mesh, exact.map, unsound + 1);
  return is_better ? fast : std::move(exact.map);
}

Eigen::Vector2d logCoordinatesAtVertex(const LogMap& map, int vertex) {
  const double r = map.r[vertex];
  if (!std::isnan(r)) return {r * std::cos(map.phi[vertex]), r * std::sin(map.phi[vertex])};
  const auto place = std::lower_bound(map.rim.begin(), map.rim.end(), vertex,
                                      [](const LogMap::RimVertex& rim, int wanted) {
                                        return rim.vertex < wanted;
                                      });
  if (place != map.rim.end() && place->vertex == vertex) return place->p_T;
  return {kNaN, kNaN};
}

Eigen::Vector2d logCoordinates(const TriangleMesh& mesh,
                               const LogMap& map,
                               const SurfacePoint& point) {
  validate(mesh, point, "log coordinates' point");
  Eigen::Vector2d uv_T = Eigen::Vector2d::Zero();
  for (int c = 0; c < 3; ++c) {
    // A corner without weight has no say, reached or not.
    if (point.barycentric[c] == 0.0) continue;
    uv_T += point.barycentric[c] * logCoordinatesAtVertex(map, mesh.faces()(c, point.face));
  }
  return uv_T;
}

}  // namespace handgraft::geometry
