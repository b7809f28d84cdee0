// The exact part of Dgpc: beams through windows whose ends lie on one isometric sheet,
// followed past vertices that they do not serve.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/dgpc.h"

namespace handgraft::geometry {

namespace {

// Places on one sheet differ by rounding, angles most where a window is seen edge-on.
constexpr double kSameSheet = 1e-6;
constexpr double kSameLength = 1e-7;       // of the edge
constexpr double kLengthRounding = 1e-12;  // of r
constexpr double kRayRounding = 1e-12;     // sine
constexpr double kShorter = 1e-9;          // of r: a way that is not merely another's rounding
constexpr double kFlatAngle = 1e-7;        // rad; sum of some ten arc tangents
// Faces that one beam crosses beyond its window; slivers need most.
constexpr int kLongestBeam = 256;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Eigen::Vector2d leftOf(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

/// From `from` to `apex`, in coordinates along the edge to `to` and to its left.
Eigen::Vector2d placeAlong(const Eigen::Vector3d& from,
                           const Eigen::Vector3d& to,
                           const Eigen::Vector3d& apex,
                           double length) {
  const Eigen::Vector3d along = (to - from) / length;
  const Eigen::Vector3d side = apex - from;
  const double x = side.dot(along);
  return {x, (side - x * along).norm()};
}

double distanceToSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double t = std::clamp(-a.dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (a + t * ab).norm();
}

}  // namespace

bool Dgpc::throughSheet(int halfedge, const Node& left, const Node& right, double length) {
  const double length_T = (right.position() - left.position()).norm();
  const double slack = kSameLength * length + kLengthRounding * std::max(left.r, right.r);
  // Two sheets of a surface that is flat here: whatever passes between them goes by beam.
  if (!(std::abs(length_T - length) <= slack)) {
    return !(isFlat(left.vertex) && isFlat(right.vertex));
  }
  if (mesh_.twin(halfedge) < 0) return false;  // nothing comes from beyond the surface's edge
  if (left.r <= 0.0 || right.r <= 0.0 || length <= 0.0) return false;
  if (mesh_.to(TriangleMesh::next(halfedge)) == source_vertex_) return false;

  // === The source behind the window: in coordinates along it, so that its ends have y > 0
  const double source_x = ((left.r - right.r) * (left.r + right.r) / length + length) / 2.0;
  const double depth_squared = (left.r - source_x) * (left.r + source_x);
  if (!(depth_squared > kRayRounding * kRayRounding * left.r * left.r)) return false;
  const double depth = std::sqrt(depth_squared);
  // The directions, exact as well, tell when the source is in front of the window.
  if (cross(right.direction_T, left.direction_T) <= 0.0) return false;
  follow({left.direction_T, right.direction_T, {-source_x, depth}, {length - source_x, depth}},
         halfedge);
  return false;
}

void Dgpc::follow(const Window& window, int halfedge) {
  beams_.clear();
  beams_.push_back({halfedge, window.left, window.right, Eigen::Vector2d::UnitX(), window.left,
                    window.right, true, true});
  for (int step = 0; !beams_.empty() && step < kLongestBeam; ++step) {
    const Beam beam = beams_.back();
    beams_.pop_back();
    const int vertex = mesh_.to(TriangleMesh::next(beam.halfedge));
    if (vertex == source_vertex_) continue;
    const auto left_end = mesh_.vertices().col(mesh_.from(beam.halfedge));
    const auto right_end = mesh_.vertices().col(mesh_.to(beam.halfedge));
    const double length = (right_end - left_end).norm();
    if (!(length > 0.0)) continue;

    Apex apex =
        unfold(beam, vertex,
               placeAlong(left_end, right_end, mesh_.vertices().col(vertex), length), length);
    if (apex.isSeen() && apex.r > 0.0 && isBetter(vertex, apex.r, Kind::kExact)) {
      offer(vertex, apex.r, directionThrough(window, apex.place), Kind::kExact);
    }
    apex.known = standsAt(vertex, window, apex.place, apex.r);
    if (goesPast(apex, beam, step == 0)) split(beam, apex);
  }
}

/// The apex is at `local` along the beam's halfedge. Unfolds by turning from edge to edge:
/// taking directions from places instead would blow up their rounding in every sliver on the
/// way.
Dgpc::Apex Dgpc::unfold(const Beam& beam,
                        int vertex,
                        const Eigen::Vector2d& local,
                        double length) {
  Apex apex;
  apex.vertex = vertex;
  apex.from_left = local.x() * beam.along + local.y() * leftOf(beam.along);
  apex.to_right = (length - local.x()) * beam.along - local.y() * leftOf(beam.along);
  apex.place = beam.left + apex.from_left;
  apex.r = apex.place.norm();
  apex.beyond_left =
      cross(beam.left_ray, apex.place) > kRayRounding * apex.r * beam.left_ray.norm();
  apex.beyond_right =
      cross(apex.place, beam.right_ray) > kRayRounding * apex.r * beam.right_ray.norm();
  return apex;
}

/// Whether there is anything to serve beyond the apex: not where both ends of all edges know
/// their way themselves, nor past the cut locus.
bool Dgpc::goesPast(const Apex& apex, const Beam& beam, bool is_first_face) const {
  if (apex.known && beam.left_known && beam.right_known) return false;
  const Node* node = nodeOf(apex.vertex);
  if (!apex.known) {
    if (!isFlat(apex.vertex)) return false;
    // A vertex that has not spread yet may still find its way; it asks this window again then.
    if (is_first_face && (!node || node->visits == 0)) return false;
  }
  const auto is_outrun = [&](int vertex, const Eigen::Vector2d& place) {
    const Node* reached = nodeOf(vertex);
    return reached && reached->r < place.norm() * (1.0 - kShorter);
  };
  // Past the cut locus for good: all three have shorter ways.
  return !(is_outrun(apex.vertex, apex.place) &&
           is_outrun(mesh_.from(beam.halfedge), beam.left) &&
           is_outrun(mesh_.to(beam.halfedge), beam.right));
}

/// Goes on through the two other edges, unless both ends of one know their way themselves.
void Dgpc::split(const Beam& beam, const Apex& apex) {
  const Eigen::Vector2d& p = apex.place;
  const int right_edge = mesh_.twin(TriangleMesh::next(beam.halfedge));
  if (!apex.beyond_right && right_edge >= 0 && !(apex.known && beam.right_known) &&
      distanceToSegment(p, beam.right) <= radius_ + reach_) {
    beams_.push_back({right_edge, p, beam.right, apex.to_right.normalized(),
                      apex.isSeen() ? p : beam.left_ray, beam.right_ray, apex.known,
                      beam.right_known});
  }
  const int left_edge = mesh_.twin(TriangleMesh::previous(beam.halfedge));
  if (!apex.beyond_left && left_edge >= 0 && !(apex.known && beam.left_known) &&
      distanceToSegment(beam.left, p) <= radius_ + reach_) {
    beams_.push_back({left_edge, beam.left, p, apex.from_left.normalized(), beam.left_ray,
                      apex.isSeen() ? p : beam.right_ray, beam.left_known, apex.known});
  }
}

bool Dgpc::standsAt(int vertex,
                    const Window& window,
                    const Eigen::Vector2d& p,
                    double r) const {
  const Node* node = nodeOf(vertex);
  if (!node || !node->exact || std::abs(node->r - r) > kSameSheet * r) return false;
  // The turn from the window's left end to p, carried over to T: complex numbers, no angles.
  const Eigen::Vector2d& d = window.left_direction_T;
  const double c = window.left.dot(p);
  const double s = cross(window.left, p);
  const Eigen::Vector2d direction_T(c * d.x() - s * d.y(), s * d.x() + c * d.y());
  return (direction_T / direction_T.norm() - node->direction_T).squaredNorm() <=
         kSameSheet * kSameSheet;
}

bool Dgpc::isFlat(int vertex) const {
  return mesh_.isBoundaryVertex(vertex) ||
         std::abs(mesh_.angleSum(vertex) - 2.0 * std::numbers::pi) <= kFlatAngle;
}

}  // namespace handgraft::geometry
