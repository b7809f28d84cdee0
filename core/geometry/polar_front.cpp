#include "core/geometry/polar_front.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace handgraft::geometry {

namespace {

// A fitted distance is good to 1e-4 at best; smaller gains are not worth carrying on.
constexpr double kFittedGain = 1e-6;
constexpr double kFittedTie = 1e-10;  // rounding, however the mesh is turned or numbered
constexpr double kExactGain = 1e-12;  // a few roundings
// An exact value that ties with a fitted one takes its place: its angle is better.
constexpr double kExactTie = 1e-9;
// Places on one sheet differ by rounding, angles most where a window is seen edge-on.
constexpr double kSameSheet = 1e-6;
constexpr double kSameLength = 1e-7;       // of the edge
constexpr double kLengthRounding = 1e-12;  // of r
constexpr double kRayRounding = 1e-12;     // sine
constexpr double kFlatAngle = 1e-7;        // rad; sum of some ten arc tangents
// Two ends this much farther apart in T than on the surface were reached from two sides of the
// cut locus. On a sphere the ratio gets there at 0.79 pi only.
constexpr double kMostStretch = 4.0;
// A vertex improves a few times. Rounding on absurd input must not keep it going.
constexpr int kMostVisits = 1000;
// Faces that one beam crosses beyond its window; slivers need most.
constexpr int kLongestBeam = 256;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Eigen::Vector2d leftOf(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

/// The third corner of the face behind `halfedge`, in coordinates along it and to its left.
struct Apex {
  double x;
  double y;
};

Apex apexOf(const Eigen::Vector3d& from,
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

PolarFront::PolarFront(const TriangleMesh& mesh, const SourceLayout& source, double radius)
    : mesh_(mesh),
      radius_(radius),
      source_vertex_(source.vertex),
      node_of_(static_cast<std::size_t>(mesh.vertexCount()), -1) {
  if (source_vertex_ >= 0) offer(source_vertex_, 0.0, Eigen::Vector2d::UnitX(), Kind::kExact);
  for (const SourceNeighbour& n : source.neighbours) {
    if (n.vertex == source_vertex_) continue;
    offer(n.vertex, n.r, n.direction_T, Kind::kExact);
  }
  for (const int f : source.faces) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      reach_ = std::max(reach_, (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).norm());
    }
  }
}

void PolarFront::run() {
  while (!heap_.empty()) {
    const auto [r, index] = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    heap_.pop_back();
    Node& node = nodes_[index];
    if (r != node.r) continue;  // improved since, and waiting under its newer distance
    if (r > radius_ + reach_) return;
    if (++node.visits > kMostVisits) continue;
    node.spread_r = node.r;
    spread(node.vertex);
  }
}

void PolarFront::spread(int vertex) {
  const Node node = nodes_[node_of_[vertex]];  // a copy: offers may move the nodes
  const bool within = node.r <= radius_;
  for (const int* h = mesh_.outgoingBegin(vertex); h != mesh_.outgoingEnd(vertex); ++h) {
    const int into = TriangleMesh::previous(*h);
    alongEdge(node, mesh_.to(*h));
    if (mesh_.twin(into) < 0) alongEdge(node, mesh_.from(into));
    throughWindow(*h, false);
    throughWindow(into, false);
    throughWindow(TriangleMesh::next(*h), true);
    if (within) {
      reach_ = std::max(reach_, (mesh_.vertex(mesh_.to(*h)) - mesh_.vertex(vertex)).norm());
    }
  }
}

void PolarFront::alongEdge(const Node& from, int to) {
  if (from.vertex == source_vertex_) return;  // its neighbours were seen from the beginning
  const double r =
      from.r + (mesh_.vertices().col(to) - mesh_.vertices().col(from.vertex)).norm();
  offer(to, r, from.direction_T, Kind::kFitted);
}

void PolarFront::throughWindow(int halfedge, bool apex_is_front) {
  if (mesh_.twin(halfedge) < 0) return;  // nothing comes from beyond the surface's edge
  const int from = mesh_.from(halfedge);
  const int to = mesh_.to(halfedge);
  const Node* left = nodeOf(from);
  const Node* right = nodeOf(to);
  if (!left || !right || left->r <= 0.0 || right->r <= 0.0) return;
  // An end that has not spread may still improve; it asks this window again then.
  if (left->visits == 0 || right->visits == 0) return;
  if (mesh_.to(TriangleMesh::next(halfedge)) == source_vertex_) return;

  const double length = (mesh_.vertices().col(to) - mesh_.vertices().col(from)).norm();
  if (length <= 0.0) return;
  const double length_T = (right->position() - left->position()).norm();
  bool one_sheet = false;
  if (left->exact && right->exact) {
    const double slack = kSameLength * length + kLengthRounding * std::max(left->r, right->r);
    one_sheet = std::abs(length_T - length) <= slack;
    // Two sheets of a surface that is flat here: whatever passes between them goes by beam.
    if (!one_sheet && isFlat(from) && isFlat(to)) return;
  }
  if (!one_sheet && (apex_is_front || length_T > kMostStretch * length)) return;

  // === The source behind the window, from the two distances (Melvaer & Reimers 2012, 3.2)
  // In coordinates along the edge; behind it, so that the window's ends have y = depth > 0.
  const double source_x = ((left->r - right->r) * (left->r + right->r) / length + length) / 2.0;
  const double depth_squared = (left->r - source_x) * (left->r + source_x);
  if (!(depth_squared > kRayRounding * kRayRounding * left->r * left->r)) return;
  const double depth = std::sqrt(depth_squared);
  // Where both directions are exact they also tell when the source is in front of the window.
  if (one_sheet && cross(right->direction_T, left->direction_T) <= 0.0) return;
  const Window window{
      left->direction_T, right->direction_T, {-source_x, depth}, {length - source_x, depth}};
  if (one_sheet) {
    follow(window, halfedge);
  } else {
    lookThrough(window, halfedge, length);
  }
}

Eigen::Vector2d PolarFront::directionThrough(const Window& window, const Eigen::Vector2d& p) {
  // The angle divides between the two ends as it does at the source that was placed: an
  // interpolation, so that errors do not grow from face to face as they would by unfolding.
  const double whole =
      std::atan2(cross(window.right, window.left), window.right.dot(window.left));
  const double part = std::atan2(cross(p, window.left), p.dot(window.left));
  const Eigen::Vector2d& d = window.left_direction_T;
  double turn = std::atan2(cross(d, window.right_direction_T), d.dot(window.right_direction_T));
  // The right end lies clockwise of the left one, more than half a turn at a very sharp source.
  if (turn > std::numbers::pi / 2.0) turn -= 2.0 * std::numbers::pi;
  const double angle = whole > 0.0 ? turn * part / whole : 0.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * d.x() - s * d.y(), s * d.x() + c * d.y()};
}

// === Fitted: what the window shows of its own face

void PolarFront::lookThrough(const Window& window, int halfedge, double length) {
  const int apex = mesh_.to(TriangleMesh::next(halfedge));
  const Apex local =
      apexOf(mesh_.vertices().col(mesh_.from(halfedge)),
             mesh_.vertices().col(mesh_.to(halfedge)), mesh_.vertices().col(apex), length);
  const Eigen::Vector2d p(window.left.x() + local.x, window.left.y() + local.y);
  const double r = p.norm();
  if (!isBetter(apex, r, Kind::kFitted)) return;
  if (cross(window.left, p) > 0.0 || cross(p, window.right) > 0.0) return;
  offer(apex, r, directionThrough(window, p), Kind::kFitted);
}

// === Exact: the beam through a window, followed past vertices that it does not serve

void PolarFront::follow(const Window& window, int halfedge) {
  beams_.clear();
  beams_.push_back({halfedge, window.left, window.right, Eigen::Vector2d::UnitX(), window.left,
                    window.right, true, true});
  for (int step = 0; !beams_.empty() && step < kLongestBeam; ++step) {
    const Beam beam = beams_.back();
    beams_.pop_back();
    const int h = beam.halfedge;
    const int apex = mesh_.to(TriangleMesh::next(h));
    if (apex == source_vertex_) continue;

    // === Unfold the face, by turning from edge to edge: taking directions from places instead
    // would blow up their rounding in every sliver on the way.
    const auto a = mesh_.vertices().col(mesh_.from(h));
    const auto b = mesh_.vertices().col(mesh_.to(h));
    const auto c = mesh_.vertices().col(apex);
    const double length = (b - a).norm();
    if (!(length > 0.0)) continue;
    const Apex local = apexOf(a, b, c, length);
    const Eigen::Vector2d to_apex = local.x * beam.along + local.y * leftOf(beam.along);
    const Eigen::Vector2d p = beam.left + to_apex;
    const double r = p.norm();

    // === Serve the apex if it is seen
    const bool beyond_left = cross(beam.left_ray, p) > kRayRounding * r * beam.left_ray.norm();
    const bool beyond_right =
        cross(p, beam.right_ray) > kRayRounding * r * beam.right_ray.norm();
    const bool seen = !beyond_left && !beyond_right;
    if (seen && r > 0.0 && isBetter(apex, r, Kind::kExact)) {
      offer(apex, r, directionThrough(window, p), Kind::kExact);
    }
    const bool apex_known = standsAt(apex, window, p, r);

    // === Go on through the two other edges, unless both ends of one know their way themselves
    if (apex_known && beam.left_known && beam.right_known) continue;
    if (!apex_known) {
      if (!isFlat(apex)) continue;
      // A vertex that has not spread yet may still find its way; it asks this window again
      // then.
      const Node* node = nodeOf(apex);
      if (step == 0 && (!node || node->visits == 0)) continue;
    }
    const auto outrun = [&](int vertex, const Eigen::Vector2d& place) {
      const Node* node = nodeOf(vertex);
      return node && node->r < place.norm() * (1.0 - kExactTie);
    };
    // Past the cut locus for good: all three have shorter ways.
    if (outrun(apex, p) && outrun(mesh_.from(h), beam.left) &&
        outrun(mesh_.to(h), beam.right)) {
      continue;
    }
    const int right_edge = mesh_.twin(TriangleMesh::next(h));
    if (!beyond_right && right_edge >= 0 && !(apex_known && beam.right_known) &&
        distanceToSegment(p, beam.right) <= radius_ + reach_) {
      const Eigen::Vector2d rest =
          (length - local.x) * beam.along - local.y * leftOf(beam.along);
      beams_.push_back({right_edge, p, beam.right, rest.normalized(), seen ? p : beam.left_ray,
                        beam.right_ray, apex_known, beam.right_known});
    }
    const int left_edge = mesh_.twin(TriangleMesh::previous(h));
    if (!beyond_left && left_edge >= 0 && !(apex_known && beam.left_known) &&
        distanceToSegment(beam.left, p) <= radius_ + reach_) {
      beams_.push_back({left_edge, beam.left, p, to_apex.normalized(), beam.left_ray,
                        seen ? p : beam.right_ray, beam.left_known, apex_known});
    }
  }
}

bool PolarFront::isBetter(int vertex, double r, Kind kind) const {
  if (vertex == source_vertex_) return false;
  const Node* node = nodeOf(vertex);
  if (!node) return true;
  if (kind == Kind::kFitted) {
    // Vertices that fit one another in a circle gain ever less: each visit asks for twice as
    // much. It asks against what the vertex spread last, so that of several offers the best is
    // taken, whichever comes first.
    if (!(r < node->spread_r * (1.0 - std::ldexp(kFittedGain, node->visits)))) return false;
    return r < node->r * (node->exact ? 1.0 - kExactTie : 1.0 + kFittedTie);
  }
  return r < node->r * (node->exact ? 1.0 - kExactGain : 1.0 + kExactTie);
}

void PolarFront::offer(int vertex, double r, const Eigen::Vector2d& direction_T, Kind kind) {
  int& index = node_of_[vertex];
  if (index >= 0 && !isBetter(vertex, r, kind)) return;
  if (!std::isfinite(r)) return;  // lengths that overflow reach nothing
  if (index >= 0 && kind == Kind::kFitted && r >= nodes_[index].r * (1.0 - kFittedTie)) {
    // Two ways of one length: the one further clockwise, whichever comes first.
    Eigen::Vector2d& known_T = nodes_[index].direction_T;
    if (cross(direction_T, known_T) > 0.0) known_T = direction_T;
    return;
  }
  if (index < 0) {
    index = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    nodes_.back().vertex = vertex;
  }
  Node& node = nodes_[index];
  node.r = r;
  node.direction_T = direction_T;
  node.exact = kind == Kind::kExact;
  heap_.emplace_back(r, index);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

bool PolarFront::standsAt(int vertex,
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

bool PolarFront::isFlat(int vertex) const {
  return mesh_.isBoundaryVertex(vertex) ||
         std::abs(mesh_.angleSum(vertex) - 2.0 * std::numbers::pi) <= kFlatAngle;
}

}  // namespace handgraft::geometry
