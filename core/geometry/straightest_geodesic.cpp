#include "core/geometry/straightest_geodesic.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/tangent_direction.h"

namespace handgraft::geometry {

namespace {

constexpr int kMostFaces = 1'000'000;  // a tenth of a second
// Of the mesh's mean edge: a way that passes a vertex this close goes through it.
constexpr double kVertexShare = 1e-11;
constexpr double kBeside = 1e-9;  // rad beyond a fan's side; noise of a way along an edge

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Weights of `point` in `face`, which shares the vertices that it lies between.
Eigen::Vector3d weightsIn(const TriangleMesh& mesh, const SurfacePoint& point, int face) {
  if (face == point.face) return point.barycentric / point.barycentric.sum();
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 3; ++k) {
      if (mesh.faces()(c, face) == mesh.faces()(k, point.face))
        weights[c] = point.barycentric[k];
    }
  }
  return weights / weights.sum();
}

/// Weights of the place at `share` of halfedge `h`.
Eigen::Vector3d weightsOn(int h, double share) {
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  weights[h % 3] = 1.0 - share;
  weights[TriangleMesh::next(h) % 3] = share;
  return weights;
}

/// A direction along the surface at a vertex or on an inner edge, which layouts can use.
Eigen::Vector3d anyDirection(const TriangleMesh& mesh, const SurfacePoint& point) {
  const int v = vertexAt(mesh, point);
  if (v < 0) {
    const int h = innerHalfedgeAt(mesh, point);
    return mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h));
  }
  int axis = 0;
  mesh.vertexNormals().col(v).cwiseAbs().minCoeff(&axis);
  return Eigen::Vector3d::Unit(axis);
}

/// Whether there is a tangent plane to speak of at a vertex or on an inner edge.
bool hasPlane(const TriangleMesh& mesh, const SurfacePoint& point) {
  const int v = vertexAt(mesh, point);
  if (v >= 0) return !mesh.vertexNormals().col(v).isZero(0.0);
  const int twin = mesh.twin(innerHalfedgeAt(mesh, point));
  return !mesh.faceNormals().col(point.face).isZero(0.0) ||
         !mesh.faceNormals().col(TriangleMesh::faceOf(twin)).isZero(0.0);
}

/// The way across one face: in over one side or from the source, out over another side.
struct Crossing {
  int face = -1;
  Eigen::Vector3d in = Eigen::Vector3d::Zero();  ///< barycentric
  int out = -1;                                  ///< halfedge of the face
  double share = 0.0;                            ///< along it
  double length = 0.0;
  double out_length = 0.0;    ///< of the whole side
  Eigen::Vector2d direction;  ///< in the next face: x along the side, y inwards
};

class Walker {
 public:
  Walker(const TriangleMesh& mesh, double length)
      : mesh_(mesh),
        length_(length),
        left_(length),
        vertex_reach_(kVertexShare * mesh.meanEdgeLength()) {}

  StraightWalk run(const SurfacePoint& start,
                   const SourceLayout& layout,
                   const SourceRay& ray) {
    walk_.trace.push_back(start);
    leave(start, layout, ray);
    for (int faces = 0; !done_; ++faces) {
      if (faces == kMostFaces) {
        giveUp();
      } else if (at_vertex_) {
        passVertex();
      } else {
        crossFace();
      }
    }
    return std::move(walk_);
  }

 private:
  /// From a source over its face to the side opposite to it.
  void leave(const SurfacePoint& source, const SourceLayout& layout, const SourceRay& ray) {
    const SourceWedge& wedge = layout.wedges[ray.wedge];
    direction_ = directionAlong(mesh_, layout, ray);
    if (ray.miss > kBeside) {  // a start on the surface's edge, heading outwards
      finish(source, direction_, left_ > 0.0 ? WalkEnd::kSurfaceEdge : WalkEnd::kArrived);
      return;
    }
    const double opening =
        std::atan2(std::abs(cross(wedge.from, wedge.to)), wedge.from.dot(wedge.to));
    const Eigen::Vector2d from(wedge.from.norm(), 0.0);
    const Eigen::Vector2d to =
        wedge.to.norm() * Eigen::Vector2d(std::cos(opening), std::sin(opening));
    const Eigen::Vector2d d(std::cos(ray.angle), std::sin(ray.angle));
    Crossing way;
    way.face = TriangleMesh::faceOf(wedge.halfedge);
    way.in = weightsIn(mesh_, source, way.face);
    way.out = wedge.halfedge;
    const double before = std::max(cross(from, d), 0.0);
    const double behind = std::max(cross(d, to), 0.0);
    way.share = before + behind > 0.0 ? before / (before + behind)
                                      : (ray.angle < 0.5 * opening ? 0.0 : 1.0);
    complete(way, {0.0, 0.0}, from, to, d);
    take(way);
  }

  /// Over the face behind halfedge `entry_`.
  void crossFace() {
    const int h = entry_;
    const Eigen::Vector3d a = mesh_.vertex(mesh_.from(h));
    const Eigen::Vector3d ab = mesh_.vertex(mesh_.to(h)) - a;
    const Eigen::Vector3d ac = mesh_.vertex(mesh_.to(TriangleMesh::next(h))) - a;
    const double length = ab.norm();
    const Eigen::Vector3d x = ab / length;
    Eigen::Vector3d y = ac - ac.dot(x) * x;
    const Eigen::Vector2d apex(ac.dot(x), y.norm());
    if (apex.y() > 0.0) {
      y /= apex.y();
      direction_ = entry_direction_.x() * x + entry_direction_.y() * y;
    }
    const Eigen::Vector2d p(entry_at_, 0.0);
    const Eigen::Vector2d& d = entry_direction_;
    // Seen along the way, the apex lies to the left (positive) or to the right.
    const double side = cross(d, apex - p);
    Crossing way;
    way.face = TriangleMesh::faceOf(h);
    way.in = weightsOn(h, entry_at_ / length);
    if (side > 0.0) {
      const double before = d.y() * (length - entry_at_);
      way.out = TriangleMesh::next(h);
      way.share = before / (before + side);
      complete(way, p, {length, 0.0}, apex, d);
    } else {
      const double behind = d.y() * entry_at_;
      way.out = TriangleMesh::previous(h);
      way.share = behind - side > 0.0 ? -side / (behind - side) : 0.0;
      complete(way, p, apex, {0.0, 0.0}, d);
    }
    take(way);
  }

  /// Lengths and directions of a way from `p` over the side from `a` to `b`.
  void complete(Crossing& way,
                const Eigen::Vector2d& p,
                const Eigen::Vector2d& a,
                const Eigen::Vector2d& b,
                const Eigen::Vector2d& d) const {
    const Eigen::Vector2d side = b - a;
    way.out_length = side.norm();
    way.length = std::max((a + way.share * side - p).dot(d), 0.0);
    const Eigen::Vector2d along = way.out_length > 0.0 ? Eigen::Vector2d(side / way.out_length)
                                                       : Eigen::Vector2d::UnitX();
    // Beyond the side its twin runs the other way, and inwards is there what is outwards here.
    way.direction = Eigen::Vector2d(-along.dot(d), -cross(along, d));
    way.direction.y() = std::max(way.direction.y(), 0.0);
    way.direction.normalize();
  }

  /// Walks a way to its end or as far as the length goes.
  void take(const Crossing& way) {
    if (!std::isfinite(way.length) || !std::isfinite(way.share)) {
      giveUp();
      return;
    }
    const double reach = way.out_length * way.share;
    const bool at_from = reach <= vertex_reach_;
    const bool at_to = way.out_length - reach <= vertex_reach_;
    const double share = at_from ? 0.0 : at_to ? 1.0 : way.share;
    const Eigen::Vector3d out = weightsOn(way.out, share);
    if (left_ <= way.length) {
      const double t = way.length > 0.0 ? left_ / way.length : 0.0;
      walk_.length = length_;
      finish({way.face, (1.0 - t) * way.in + t * out}, direction_, WalkEnd::kArrived);
      return;
    }
    left_ -= way.length;
    walk_.length += way.length;
    const SurfacePoint place{way.face, out};
    at_vertex_ = at_from || at_to;
    if (at_vertex_) {
      walk_.trace.push_back(place);
      return;
    }
    entry_ = mesh_.twin(way.out);
    if (entry_ < 0) {
      finish(place, direction_, WalkEnd::kSurfaceEdge);
      return;
    }
    walk_.trace.push_back(place);
    entry_at_ = (1.0 - way.share) * way.out_length;
    entry_direction_ = way.direction;
  }

  /// Half a turn, as angles at a vertex are counted, against where the way came from.
  void passVertex() {
    const SurfacePoint place = walk_.trace.back();
    at_vertex_ = false;
    if (!hasPlane(mesh_, place)) {
      giveUp();
      return;
    }
    const SourceLayout layout = layOutSource(mesh_, place, anyDirection(mesh_, place));
    const SourceRay back = rayAlong(mesh_, layout, place.face, -direction_);
    const double phi = phiOf(layout, back) + std::numbers::pi;
    const SourceRay on = rayAt(mesh_, layout, phi, place.face);
    if (on.miss > kBeside) {
      walk_.trace.pop_back();
      finish(place, direction_, WalkEnd::kSurfaceEdge);
      return;
    }
    leave(place, layout, on);
  }

  void giveUp() {
    const SurfacePoint place = walk_.trace.back();
    if (walk_.trace.size() > 1) walk_.trace.pop_back();
    finish(place, direction_, WalkEnd::kStuck);
  }

  void finish(SurfacePoint point, const Eigen::Vector3d& direction, WalkEnd end) {
    point.barycentric = point.barycentric.cwiseMax(0.0);
    point.barycentric /= point.barycentric.sum();
    done_ = true;
    walk_.end = end;
    walk_.point = point;
    walk_.direction = end == WalkEnd::kArrived ? directionAt(point, direction) : direction;
    walk_.trace.push_back(point);
  }

  /// The direction inside the end's face as a direction of the end's tangent plane.
  [[nodiscard]] Eigen::Vector3d directionAt(const SurfacePoint& point,
                                            const Eigen::Vector3d& direction) const {
    const bool at_vertex = vertexAt(mesh_, point) >= 0;
    if (!at_vertex && innerHalfedgeAt(mesh_, point) < 0) return direction;
    if (!hasPlane(mesh_, point)) return direction;
    const SourceLayout layout = layOutSource(mesh_, point, anyDirection(mesh_, point));
    const SourceRay on = rayAlong(mesh_, layout, point.face, direction);
    if (!at_vertex) {
      const double phi = phiOf(layout, on);
      return std::cos(phi) * layout.x + std::sin(phi) * layout.y;
    }
    if (on.miss <= kBeside) return direction;
    const SourceRay back = rayAlong(mesh_, layout, point.face, -direction);
    const double phi = phiOf(layout, back) + std::numbers::pi;
    const SourceRay beyond = rayAt(mesh_, layout, phi, point.face);
    return beyond.miss > kBeside ? direction : directionAlong(mesh_, layout, beyond);
  }

  const TriangleMesh& mesh_;
  double length_;
  double left_;
  double vertex_reach_;
  StraightWalk walk_;
  bool done_ = false;
  bool at_vertex_ = false;                               ///< the last of the trace
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  ///< in the face last crossed
  // === Into the next face: over which halfedge of it, where and how
  int entry_ = -1;
  double entry_at_ = 0.0;                         ///< from its start
  Eigen::Vector2d entry_direction_ = {0.0, 0.0};  ///< x along it, y into the face
};

}  // namespace

StraightWalk walkStraight(const TriangleMesh& mesh,
                          const SurfacePoint& start,
                          const Eigen::Vector3d& direction,
                          double length,
                          double heading) {
  validate(mesh, start, "start of a straight walk");
  if (!(length >= 0.0) || !std::isfinite(length)) {
    rejectInput("length of a straight walk is {} m, it must be finite and 0 or more", length);
  }
  if (!std::isfinite(heading)) {
    rejectInput("heading of a straight walk is {} rad, it must be finite", heading);
  }
  const SourceLayout layout = layOutSource(mesh, start, direction);
  return Walker(mesh, length).run(start, layout, rayAt(mesh, layout, heading, start.face));
}

}  // namespace handgraft::geometry
