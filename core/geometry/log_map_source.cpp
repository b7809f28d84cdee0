#include "core/geometry/log_map_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "core/base/angle.h"
#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr double kEdgeWeight = 1e-12;   // barycentric weight below which a point is on an edge
constexpr double kParallelSine = 1e-6;  // direction against normal; its azimuth keeps 10 digits
constexpr double kFlatTurn = 1e-12;     // sum of unit normals that cancel

/// The tangent plane: x along the projected direction, y to its left seen from outside.
struct TangentFrame {
  Eigen::Vector3d x;
  Eigen::Vector3d y;

  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& v) const {
    return {x.dot(v), y.dot(v)};
  }
};

TangentFrame tangentFrame(const Eigen::Vector3d& normal, const Eigen::Vector3d& direction) {
  if (!direction.allFinite() || direction.isZero(0.0)) {
    rejectInput("log map direction is ({}, {}, {}), it must be finite and not zero",
                direction[0], direction[1], direction[2]);
  }
  if (normal.isZero(0.0)) {
    rejectInput(
        "log map source has no normal (its faces have no area), another source is needed");
  }
  const Eigen::Vector3d d = direction.stableNormalized();
  const Eigen::Vector3d x = d - d.dot(normal) * normal;
  if (x.norm() < kParallelSine) {
    rejectInput(
        "log map direction ({}, {}, {}) is parallel to the normal ({}, {}, {}) at the "
        "source, it must have a part along the surface",
        direction[0], direction[1], direction[2], normal[0], normal[1], normal[2]);
  }
  const Eigen::Vector3d x_unit = x.normalized();
  return {x_unit, normal.cross(x_unit)};
}

Eigen::Vector2d unit(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

SourceNeighbour neighbourAt(int vertex, const Eigen::Vector2d& p_T) {
  const double r = p_T.norm();
  return {vertex, r, r > 0.0 ? Eigen::Vector2d(p_T / r) : Eigen::Vector2d::UnitX()};
}

Eigen::Vector3d perpendicularTo(const Eigen::Vector3d& axis, const Eigen::Vector3d& v) {
  const Eigen::Vector3d rest = v - v.dot(axis) * axis;
  const double length = rest.norm();
  return length > kFlatTurn ? Eigen::Vector3d(rest / length) : Eigen::Vector3d::Zero();
}

/// The face's own normal; a face without area borrows one from its corners, turned square to
/// the line that it is.
Eigen::Vector3d faceNormalAt(const TriangleMesh& mesh, const SurfacePoint& source) {
  Eigen::Vector3d normal = mesh.faceNormals().col(source.face);
  if (!normal.isZero(0.0)) return normal;
  Eigen::Vector3d longest = Eigen::Vector3d::Zero();
  for (int h = 3 * source.face; h < 3 * source.face + 3; ++h) {
    const Eigen::Vector3d edge = mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h));
    if (edge.norm() > longest.norm()) longest = edge;
  }
  return perpendicularTo(longest.stableNormalized(), normalOf(mesh, source));
}

// === Inside a face: the plane of the face

SourceLayout layOutFace(const TriangleMesh& mesh,
                        const SurfacePoint& source,
                        const Eigen::Vector3d& direction) {
  const TangentFrame frame = tangentFrame(faceNormalAt(mesh, source), direction);
  const Eigen::Vector3d origin = positionOf(mesh, source);
  SourceLayout layout;
  layout.origin = origin;
  layout.x = frame.x;
  layout.y = frame.y;
  layout.faces = {source.face};
  Eigen::Matrix<double, 2, 3> corners_T;
  for (int c = 0; c < 3; ++c) {
    const int v = mesh.faces()(c, source.face);
    corners_T.col(c) = frame.project(mesh.vertex(v) - origin);
    layout.neighbours.push_back(neighbourAt(v, corners_T.col(c)));
  }
  for (int c = 0; c < 3; ++c) {
    layout.wedges.push_back(
        {3 * source.face + c, corners_T.col(c), corners_T.col((c + 1) % 3)});
  }
  return layout;
}

// === On an edge: the plane between its two faces, both turned into it about the edge

SourceLayout layOutEdge(const TriangleMesh& mesh,
                        const SurfacePoint& source,
                        int h,
                        const Eigen::Vector3d& direction) {
  const int twin = mesh.twin(h);
  const Eigen::Vector3d origin = positionOf(mesh, source);
  const Eigen::Vector3d along =
      (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).stableNormalized();

  Eigen::Vector3d normal = mesh.faceNormals().col(TriangleMesh::faceOf(h)) +
                           mesh.faceNormals().col(TriangleMesh::faceOf(twin));
  normal = perpendicularTo(along, normal);
  if (normal.isZero(0.0)) normal = faceNormalAt(mesh, source);
  const TangentFrame frame = tangentFrame(normal, direction);
  const Eigen::Vector2d along_T = frame.project(along).normalized();
  const Eigen::Vector2d left_T(-along_T.y(), along_T.x());

  // The face of h lies to the left of it, the twin's to the right.
  const auto place = [&](int v, double side) -> Eigen::Vector2d {
    const Eigen::Vector3d p = mesh.vertex(v) - origin;
    const double x = p.dot(along);
    const double y = side * along.cross(p).norm();
    return x * along_T + y * left_T;
  };
  const Eigen::Vector2d from_T = place(mesh.from(h), 0.0);
  const Eigen::Vector2d to_T = place(mesh.to(h), 0.0);
  const int left = mesh.to(TriangleMesh::next(h));
  const int right = mesh.to(TriangleMesh::next(twin));
  const Eigen::Vector2d left_apex_T = place(left, 1.0);
  const Eigen::Vector2d right_apex_T = place(right, -1.0);
  SourceLayout layout;
  layout.origin = origin;
  layout.x = frame.x;
  layout.y = frame.y;
  layout.faces = {TriangleMesh::faceOf(h), TriangleMesh::faceOf(twin)};
  layout.neighbours = {neighbourAt(mesh.from(h), from_T), neighbourAt(mesh.to(h), to_T),
                       neighbourAt(left, left_apex_T), neighbourAt(right, right_apex_T)};
  layout.wedges = {{TriangleMesh::next(h), to_T, left_apex_T},
                   {TriangleMesh::previous(h), left_apex_T, from_T},
                   {TriangleMesh::next(twin), from_T, right_apex_T},
                   {TriangleMesh::previous(twin), right_apex_T, to_T}};
  return layout;
}

// === At a vertex: the angles around it, rescaled to a full turn

/// Faces around a vertex, counter-clockwise, each by its halfedge that leaves the vertex.
struct Fan {
  std::vector<int> halfedges;
  bool closed = false;
};

std::vector<Fan> fansOf(const TriangleMesh& mesh, int v) {
  std::vector<int> waiting(mesh.outgoingBegin(v), mesh.outgoingEnd(v));
  // Ends of open fans first: whoever has no face to the right starts one.
  std::stable_partition(waiting.begin(), waiting.end(), [&](int h) {
    return mesh.twin(h) < 0;
  });
  std::vector<int> taken;
  std::vector<Fan> fans;
  for (const int first : waiting) {
    if (taken.size() == waiting.size()) break;
    if (std::find(taken.begin(), taken.end(), first) != taken.end()) continue;
    Fan fan;
    int h = first;
    while (true) {
      fan.halfedges.push_back(h);
      taken.push_back(h);
      h = mesh.twin(TriangleMesh::previous(h));
      if (h < 0 || h == first) break;
    }
    fan.closed = h == first;
    fans.push_back(std::move(fan));
  }
  return fans;
}

struct FanEdge {
  int vertex = -1;
  double length = 0.0;
  Eigen::Vector3d unit = Eigen::Vector3d::Zero();
  double angle = 0.0;  ///< from the fan's first edge, inside the surface
};

/// Edges of the fan; a closed fan ends with its first edge again, one turn later.
std::vector<FanEdge> edgesOf(const TriangleMesh& mesh, int v, const Fan& fan) {
  std::vector<FanEdge> edges;
  const auto append = [&](int to) {
    const Eigen::Vector3d edge = mesh.vertex(to) - mesh.vertex(v);
    FanEdge next{to, edge.norm(), edge.stableNormalized(), 0.0};
    if (!edges.empty()) {
      next.angle = edges.back().angle + angleBetween(edges.back().unit, next.unit);
    }
    edges.push_back(next);
  };
  for (const int h : fan.halfedges)
    append(mesh.to(h));
  append(mesh.to(TriangleMesh::next(fan.halfedges.back())));
  return edges;
}

/// The fan's angle at which the half plane of the x axis and the normal cuts the surface; of
/// several cuts (folded fans) the one that looks along x most. Nothing if x points off the fan.
std::optional<double> cutAngle(const std::vector<FanEdge>& edges, const TangentFrame& frame) {
  std::optional<double> angle;
  double best = 0.0;
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
    const double side_a = frame.y.dot(edges[e].unit);
    const double side_b = frame.y.dot(edges[e + 1].unit);
    if (side_a * side_b > 0.0 || side_a == side_b) continue;
    const Eigen::Vector3d cut =
        (std::abs(side_b) * edges[e].unit + std::abs(side_a) * edges[e + 1].unit).normalized();
    const double along = frame.x.dot(cut);
    if (along > best) {
      best = along;
      angle = edges[e].angle + angleBetween(edges[e].unit, cut);
    }
  }
  return angle;
}

/// The same for a direction that points off the fan: continued from the edge nearest to it in
/// the tangent plane.
double angleBeyond(const std::vector<FanEdge>& edges, const TangentFrame& frame) {
  double smallest = std::numeric_limits<double>::infinity();
  double angle = 0.0;
  for (const FanEdge& edge : edges) {
    const double turn = std::atan2(frame.y.dot(edge.unit), frame.x.dot(edge.unit));
    if (std::abs(turn) < smallest) {
      smallest = std::abs(turn);
      angle = edge.angle - turn;
    }
  }
  return angle;
}

SourceLayout layOutVertex(const TriangleMesh& mesh, int v, const Eigen::Vector3d& direction) {
  const TangentFrame frame = tangentFrame(mesh.vertexNormals().col(v), direction);
  SourceLayout layout;
  layout.vertex = v;
  layout.origin = mesh.vertex(v);
  layout.x = frame.x;
  layout.y = frame.y;
  for (const Fan& fan : fansOf(mesh, v)) {
    const std::vector<FanEdge> edges = edgesOf(mesh, v, fan);
    const double total = edges.back().angle;
    constexpr double kTurn = 2.0 * std::numbers::pi;
    // A closed fan becomes a full turn. An open one keeps its angles, unless they overlap.
    const double scale = total > 0.0 && (fan.closed || total > kTurn) ? kTurn / total : 1.0;
    const std::optional<double> cut = cutAngle(edges, frame);
    const double zero = cut ? *cut : angleBeyond(edges, frame);
    for (const int h : fan.halfedges)
      layout.faces.push_back(TriangleMesh::faceOf(h));
    const std::size_t edge_count = fan.closed ? edges.size() - 1 : edges.size();
    for (std::size_t e = 0; e < edge_count; ++e) {
      layout.neighbours.push_back(
          {edges[e].vertex, edges[e].length, unit(scale * (edges[e].angle - zero))});
    }
    for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
      layout.wedges.push_back({TriangleMesh::next(fan.halfedges[e]),
                               {edges[e].length, 0.0},
                               edges[e + 1].length * unit(edges[e + 1].angle - edges[e].angle),
                               scale * (edges[e].angle - zero),
                               scale});
    }
  }
  return layout;
}

}  // namespace

int innerHalfedgeAt(const TriangleMesh& mesh, const SurfacePoint& point) {
  for (int corner = 0; corner < 3; ++corner) {
    if (point.barycentric[corner] > kEdgeWeight) continue;
    // The edge opposite to the corner without weight.
    const int h = TriangleMesh::next(3 * point.face + corner);
    if (mesh.twin(h) >= 0) return h;
  }
  return -1;
}

SourceLayout layOutSource(const TriangleMesh& mesh,
                          const SurfacePoint& source,
                          const Eigen::Vector3d& direction) {
  const int v = vertexAt(mesh, source);
  if (v >= 0) return layOutVertex(mesh, v, direction);
  const int h = innerHalfedgeAt(mesh, source);
  return h >= 0 ? layOutEdge(mesh, source, h, direction) : layOutFace(mesh, source, direction);
}

}  // namespace handgraft::geometry
