#include "core/geometry/polar_front.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace handgraft::geometry {

namespace {

// A fitted distance is good to 1e-4 at best; smaller gains are not worth carrying on.
constexpr double kFittedGain = 1e-6;
constexpr double kExactGain = 1e-12;  // a few roundings
// An exact value that ties with a fitted one takes its place: its angle is better.
constexpr double kExactTie = 1e-9;
// Positions of one sheet differ by rounding, some 1e-14 of r after a hundred faces.
constexpr double kSameSheet = 1e-9;
constexpr double kSameLength = 1e-7;       // of the edge
constexpr double kLengthRounding = 1e-12;  // of r
constexpr double kRayRounding = 1e-12;     // sine
constexpr double kFlatAngle = 1e-7;        // rad; sum of some ten arc tangents
// Two ends this much farther apart in T than on the surface were reached from two sides of the
// cut locus. On a sphere the ratio gets there at 0.79 pi only.
constexpr double kMostStretch = 4.0;
// A vertex improves a few times. Rounding on absurd input must not keep it going.
constexpr int kMostVisits = 64;
// Faces that one beam crosses beyond its window; slivers need most.
constexpr int kLongestBeam = 64;

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
  const int apex = mesh_.to(TriangleMesh::next(halfedge));
  const Node* left = nodeOf(from);
  const Node* right = nodeOf(to);
  if (!left || !right || left->r <= 0.0 || right->r <= 0.0 || apex == source_vertex_) return;

  const double length = (mesh_.vertices().col(to) - mesh_.vertices().col(from)).norm();
  if (length <= 0.0) return;
  const Eigen::Vector2d left_T = left->position();
  const Eigen::Vector2d right_T = right->position();
  const double length_T = (right_T - left_T).norm();
  if (left->exact && right->exact) {
    const double slack = kSameLength * length + kLengthRounding * std::max(left->r, right->r);
    if (std::abs(length_T - length) <= slack) {
      follow({halfedge, left_T, right_T, left_T, right_T, true, true});
      return;
    }
    // Two sheets of a surface that is flat here: whatever passes between them goes by beam.
    if (isFlat(from) && isFlat(to)) return;
  }
  if (apex_is_front || length_T > kMostStretch * length) return;
  fitSource(halfedge, *left, *right, length);
}

// === Exact: the beam through a window, followed past vertices that it does not serve

void PolarFront::follow(const Beam& first) {
  beams_.assign(1, first);
  for (int step = 0; !beams_.empty() && step < kLongestBeam; ++step) {
    const Beam beam = beams_.back();
    beams_.pop_back();
    const int h = beam.halfedge;
    const int apex = mesh_.to(TriangleMesh::next(h));

    // === Unfold the face into T
    const Eigen::Vector2d edge = beam.right - beam.left;
    const double length = edge.norm();
    if (!(length > 0.0)) continue;
    const Eigen::Vector2d along = edge / length;
    const Eigen::Vector2d left_of_edge = leftOf(along);
    // The origin lies behind the edge; from the side of the face or along it nothing is seen.
    const double depth = left_of_edge.dot(beam.left);
    if (!(depth > kRayRounding * beam.left.norm())) continue;
    const Apex local =
        apexOf(mesh_.vertices().col(mesh_.from(h)), mesh_.vertices().col(mesh_.to(h)),
               mesh_.vertices().col(apex), length);
    const Eigen::Vector2d apex_T = beam.left + local.x * along + local.y * left_of_edge;
    const double r = apex_T.norm();

    // === Serve the apex if it is seen
    const bool beyond_left =
        cross(beam.left_ray, apex_T) > kRayRounding * r * beam.left_ray.norm();
    const bool beyond_right =
        cross(apex_T, beam.right_ray) > kRayRounding * r * beam.right_ray.norm();
    const bool seen = !beyond_left && !beyond_right;
    if (apex == source_vertex_) continue;
    if (seen && r > 0.0 && isBetter(apex, r, Kind::kExact)) {
      offer(apex, r, apex_T / r, Kind::kExact);
    }
    const bool apex_known = standsAt(apex, apex_T);

    // === Go on through the two other edges, unless both ends of one know their way themselves
    if (!apex_known && !isFlat(apex)) continue;  // no sheet to follow on a curved surface
    const Node* left = nodeOf(mesh_.from(h));
    const Node* right = nodeOf(mesh_.to(h));
    const Node* ahead = nodeOf(apex);
    // Past the cut locus for good: all three have shorter ways.
    const auto outrun = [](const Node* node, const Eigen::Vector2d& p_T) {
      return node && node->r < p_T.norm() * (1.0 - kExactTie);
    };
    if (outrun(left, beam.left) && outrun(right, beam.right) && outrun(ahead, apex_T)) continue;

    const int right_edge = mesh_.twin(TriangleMesh::next(h));
    if (!beyond_right && right_edge >= 0 && !(apex_known && beam.right_known) &&
        distanceToSegment(apex_T, beam.right) <= radius_ + reach_) {
      beams_.push_back({right_edge, apex_T, beam.right, seen ? apex_T : beam.left_ray,
                        beam.right_ray, apex_known, beam.right_known});
    }
    const int left_edge = mesh_.twin(TriangleMesh::previous(h));
    if (!beyond_left && left_edge >= 0 && !(apex_known && beam.left_known) &&
        distanceToSegment(apex_T, beam.left) <= radius_ + reach_) {
      beams_.push_back({left_edge, beam.left, apex_T, beam.left_ray,
                        seen ? apex_T : beam.right_ray, beam.left_known, apex_known});
    }
  }
}

// === Fitted: the source placed by the two distances (Melvaer & Reimers 2012, section 3.2)

void PolarFront::fitSource(int halfedge, const Node& left, const Node& right, double length) {
  const int apex = mesh_.to(TriangleMesh::next(halfedge));
  // The source in coordinates along the edge and to its left, where it is behind: y < 0.
  const double source_x = ((left.r - right.r) * (left.r + right.r) / length + length) / 2.0;
  const double source_y_squared = (left.r - source_x) * (left.r + source_x);
  if (!(source_y_squared > 0.0)) return;
  const double depth = std::sqrt(source_y_squared);

  const Apex local =
      apexOf(mesh_.vertices().col(mesh_.from(halfedge)),
             mesh_.vertices().col(mesh_.to(halfedge)), mesh_.vertices().col(apex), length);
  const double crossing = source_x + (local.x - source_x) * depth / (local.y + depth);
  if (!(crossing >= 0.0 && crossing <= length)) return;
  const double r = std::hypot(local.x - source_x, local.y + depth);
  if (!isBetter(apex, r, Kind::kFitted)) return;

  // The angle divides between the two ends as it does at the source that was placed.
  const Eigen::Vector2d to_left(-source_x, depth);
  const Eigen::Vector2d to_right(length - source_x, depth);
  const Eigen::Vector2d to_apex(local.x - source_x, local.y + depth);
  const double whole = std::atan2(cross(to_right, to_left), to_right.dot(to_left));
  const double part = std::atan2(cross(to_apex, to_left), to_apex.dot(to_left));
  double turn = std::atan2(cross(left.direction_T, right.direction_T),
                           left.direction_T.dot(right.direction_T));
  // The right end lies clockwise of the left one, more than half a turn at a very sharp source.
  if (turn > std::numbers::pi / 2.0) turn -= 2.0 * std::numbers::pi;
  const double angle = whole > 0.0 ? turn * part / whole : 0.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Eigen::Vector2d& d = left.direction_T;
  offer(apex, r, {c * d.x() - s * d.y(), s * d.x() + c * d.y()}, Kind::kFitted);
}

bool PolarFront::isBetter(int vertex, double r, Kind kind) const {
  if (vertex == source_vertex_) return false;
  const Node* node = nodeOf(vertex);
  if (!node) return true;
  if (kind == Kind::kFitted) return r < node->r * (1.0 - kFittedGain);
  return r < node->r * (node->exact ? 1.0 - kExactGain : 1.0 + kExactTie);
}

void PolarFront::offer(int vertex, double r, const Eigen::Vector2d& direction_T, Kind kind) {
  int& index = node_of_[vertex];
  if (index >= 0 && !isBetter(vertex, r, kind)) return;
  if (!std::isfinite(r)) return;  // lengths that overflow reach nothing
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

bool PolarFront::standsAt(int vertex, const Eigen::Vector2d& p_T) const {
  const Node* node = nodeOf(vertex);
  return node && node->exact &&
         (node->position() - p_T).norm() <= kSameSheet * (node->r + p_T.norm());
}

bool PolarFront::isFlat(int vertex) const {
  return mesh_.isBoundaryVertex(vertex) ||
         std::abs(mesh_.angleSum(vertex) - 2.0 * std::numbers::pi) <= kFlatAngle;
}

}  // namespace handgraft::geometry
