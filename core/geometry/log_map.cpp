#include "core/geometry/log_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/geometry/log_map_source.h"
#include "core/geometry/polar_front.h"

namespace handgraft::geometry {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double distanceToOrigin(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length_squared = ab.squaredNorm();
  const double t =
      length_squared > 0.0 ? std::clamp(-a.dot(ab) / length_squared, 0.0, 1.0) : 0.0;
  return (a + t * ab).norm();
}

/// Angle in (-pi, pi].
double angleOf(const Eigen::Vector2d& direction) {
  const double angle = std::atan2(direction.y(), direction.x());
  return angle == -std::numbers::pi ? std::numbers::pi : angle;
}

/// Sorts what the front touched into the disk and its rim.
class DiskBuilder {
 public:
  DiskBuilder(const TriangleMesh& mesh, const PolarFront& front, double radius, LogMap& map)
      : mesh_(mesh), front_(front), radius_(radius), map_(map) {}

  void addVertices() {
    map_.r.setConstant(mesh_.vertexCount(), kNaN);
    map_.phi.setConstant(mesh_.vertexCount(), kNaN);
    for (const PolarFront::Node& node : front_.nodes()) {
      if (node.r > radius_) continue;
      map_.vertices.push_back(node.vertex);
      map_.r[node.vertex] = node.r;
      map_.phi[node.vertex] = node.r > 0.0 ? angleOf(node.direction_T) : 0.0;
    }
    std::sort(map_.vertices.begin(), map_.vertices.end(), [&](int a, int b) {
      return std::pair(map_.r[a], a) < std::pair(map_.r[b], b);
    });
  }

  void addFaces(const std::vector<int>& source_faces) {
    for (const PolarFront::Node& node : front_.nodes()) {
      for (const int* h = mesh_.outgoingBegin(node.vertex); h != mesh_.outgoingEnd(node.vertex);
           ++h) {
        // Each face once: at the lowest of its corners.
        if (node.vertex < mesh_.to(*h) &&
            node.vertex < mesh_.from(TriangleMesh::previous(*h))) {
          addFace(TriangleMesh::faceOf(*h), source_faces);
        }
      }
    }
    const auto byVertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex < b.vertex;
    };
    std::sort(map_.rim.begin(), map_.rim.end(), byVertex);
    const auto sameVertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex == b.vertex;
    };
    map_.rim.erase(std::unique(map_.rim.begin(), map_.rim.end(), sameVertex), map_.rim.end());
    std::sort(map_.faces.begin(), map_.faces.end());
    std::sort(map_.rim_faces.begin(), map_.rim_faces.end());
  }

 private:
  void addFace(int f, const std::vector<int>& source_faces) {
    const PolarFront::Node* corners[3];
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
    } else if (std::min({distanceToOrigin(p_T[0], p_T[1]), distanceToOrigin(p_T[1], p_T[2]),
                         distanceToOrigin(p_T[2], p_T[0])}) <= radius_) {
      map_.rim_faces.push_back(f);
    } else {
      return;
    }
    for (int c = 0; c < 3; ++c) {
      if (corners[c]->r > radius_) map_.rim.push_back({corners[c]->vertex, p_T[c]});
    }
  }

  const TriangleMesh& mesh_;
  const PolarFront& front_;
  double radius_;
  LogMap& map_;
};

}  // namespace

LogMapMethod logMapMethodFrom(std::string_view name) {
  if (name == "fast") return LogMapMethod::kFast;
  rejectInput("log map method is {}, permitted: fast", quoted(std::string(name)));
}

std::string_view nameOf(LogMapMethod method) {
  switch (method) {
    case LogMapMethod::kFast:
      return "fast";
  }
  HANDGRAFT_REQUIRE(!"a known log map method");
  return {};
}

LogMap computeLogMap(const TriangleMesh& mesh,
                     const SurfacePoint& source,
                     const Eigen::Vector3d& direction,
                     double radius,
                     LogMapMethod method) {
  HANDGRAFT_REQUIRE(method == LogMapMethod::kFast);
  validate(mesh, source, "log map source");
  if (!(radius > 0.0)) rejectInput("log map radius is {} m, it must be positive", radius);

  const SourceLayout layout = layOutSource(mesh, source, direction);
  PolarFront front(mesh, layout, radius);
  front.run();

  LogMap map;
  map.source = source;
  map.radius = radius;
  DiskBuilder builder(mesh, front, radius, map);
  builder.addVertices();
  builder.addFaces(layout.faces);
  return map;
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
