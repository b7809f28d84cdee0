#include "core/geometry/dgpc.h"

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
constexpr double kLengthRounding = 1e-12;  // of r
constexpr double kRayRounding = 1e-12;     // sine
// Two ends this much farther apart in T than on the surface were reached from two sides of the
// cut locus. On a sphere the ratio gets there at 0.79 pi only.
constexpr double kMostStretch = 4.0;
// A vertex improves a few times. Rounding on absurd input must not keep it going.
constexpr int kMostVisits = 1000;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Of small angles: arc tangent of s / c, 1e-6 of it, by its Pade approximant [5/4].
double smallAngle(double s, double c) {
  const double t = s / c;
  const double q = t * t;
  return t * (945.0 + q * (735.0 + 64.0 * q)) / (945.0 + q * (1050.0 + 225.0 * q));
}

constexpr double kSmallTangent = 0.5;  // up to which the approximant is that good
constexpr double kSmallTurn = 0.1;     // rad, whose sine and cosine need three terms

}  // namespace

Dgpc::Dgpc(const TriangleMesh& mesh, const SourceLayout& source, double radius)
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
  queueImproved();
}

void Dgpc::run() {
  while (!heap_.empty()) {
    const auto [r, index] = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    heap_.pop_back();
    Node& node = nodes_[index];
    if (r != node.r) continue;  // improved since, and waiting under its newer distance
    if (r > radius_ + reach_) return;
    if (++node.visits > kMostVisits) continue;
    // Vertices that fit one another in a circle gain ever less: each visit asks for twice as
    // much. It asks against what was spread last, so that of several offers the best is taken,
    // whichever comes first.
    node.least_gain *= 2.0;
    node.fitted_limit = node.r * (1.0 - node.least_gain);
    node.settled = true;
    spread(index);
    queueImproved();
  }
}

void Dgpc::queueImproved() {
  for (const int index : improved_) {
    nodes_[index].waits = false;
    heap_.emplace_back(nodes_[index].r, index);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  improved_.clear();
}

void Dgpc::spread(int index) {
  const Node node = nodes_[index];  // a copy: offers may move the nodes
  for (const int* h = mesh_.outgoingBegin(node.vertex); h != mesh_.outgoingEnd(node.vertex);
       ++h) {
    spreadInto(node, *h);
  }
  may_meet_ = true;
}

bool Dgpc::reachesIn(const Node& a, const Node* b, double length) const {
  // No place of the edge is nearer than this, by the triangle inequality.
  return b && a.r + b->r - length <= 2.0 * radius_ * (1.0 + kLengthRounding);
}

/// Everything that a vertex has to say to one of its faces.
void Dgpc::spreadInto(const Node& from, int halfedge) {
  const int side = TriangleMesh::next(halfedge);
  const int back = TriangleMesh::next(side);
  const int right = mesh_.from(side);
  const int left = mesh_.from(back);
  const auto p = mesh_.vertices().col(from.vertex);
  const auto p_right = mesh_.vertices().col(right);
  const auto p_left = mesh_.vertices().col(left);
  const double to_right = (p_right - p).norm();
  const double to_left = (p_left - p).norm();
  const double across = (p_left - p_right).norm();

  // Beyond the radius no vertex is met but those of faces that may reach into it.
  const bool within = from.r <= radius_;
  {
    const Node* at_right = nodeOf(right);
    const Node* at_left = nodeOf(left);
    may_meet_ = within || reachesIn(from, at_right, to_right) ||
                reachesIn(from, at_left, to_left) ||
                (at_right && reachesIn(*at_right, at_left, across));
  }
  if (within) reach_ = std::max({reach_, to_right, to_left});

  // An end that may still improve asks its windows when it has. Offers may move the nodes,
  // hence copies.
  const auto is_settled = [](const Node* node) {
    return node && node->settled;
  };
  if (const Node* at = nodeOf(right); is_settled(at)) {
    throughWindow(halfedge, from, Node(*at), {left, to_right, to_left, across});
  }
  if (const Node* at = nodeOf(left); is_settled(at)) {
    throughWindow(back, Node(*at), from, {right, to_left, across, to_right});
  }
  const Node* at_right = nodeOf(right);
  const Node* at_left = nodeOf(left);
  if (is_settled(at_right) && is_settled(at_left) && at_right->exact && at_left->exact) {
    static_cast<void>(throughSheet(side, Node(*at_right), Node(*at_left), across));
  }

  alongEdge(from, right, to_right);
  // The next face has this edge as its first one, if there is one that is asked.
  if (mesh_.twin(back) < 0 || !within) alongEdge(from, left, to_left);
}

void Dgpc::alongEdge(const Node& from, int to, double length) {
  if (from.vertex == source_vertex_) return;  // its neighbours were seen from the beginning
  offer(to, from.r + length, from.direction_T, Kind::kFitted);
}

void Dgpc::throughWindow(int halfedge,
                         const Node& left,
                         const Node& right,
                         const Behind& face) {
  if (left.exact && right.exact && !throughSheet(halfedge, left, right, face.length)) return;
  if (mesh_.twin(halfedge) < 0) return;  // nothing comes from beyond the surface's edge
  lookThrough(left, right, face);
}

Eigen::Vector2d Dgpc::directionThrough(const Window& window, const Eigen::Vector2d& p) {
  // The angle divides between the two ends as it does at the source that was placed: an
  // interpolation, so that errors do not grow from face to face as they would by unfolding.
  const double whole_sine = cross(window.right, window.left);
  const double whole_cosine = window.right.dot(window.left);
  const double part_sine = cross(p, window.left);
  const double part_cosine = p.dot(window.left);
  const Eigen::Vector2d& d = window.left_direction_T;
  const double turn_sine = cross(d, window.right_direction_T);
  const double turn_cosine = d.dot(window.right_direction_T);

  // === Nearly flat, and far from the source: without arc tangents
  // The turn in the window's plane, and what T turns more, in proportion.
  const double more_sine = turn_sine * whole_cosine + turn_cosine * whole_sine;
  const double more_cosine = turn_cosine * whole_cosine - turn_sine * whole_sine;
  if (whole_sine > 0.0 && part_sine >= 0.0 && whole_sine <= kSmallTangent * whole_cosine &&
      std::abs(more_sine) <= kSmallTurn * more_cosine) {
    const double share =
        smallAngle(part_sine, part_cosine) / smallAngle(whole_sine, whole_cosine);
    const double more = share * smallAngle(more_sine, more_cosine);
    const double q = more * more;
    const double c = 1.0 - q / 2.0 * (1.0 - q / 12.0);
    const double s = more * (1.0 - q / 6.0 * (1.0 - q / 20.0));
    const Eigen::Vector2d turned(part_cosine * d.x() + part_sine * d.y(),
                                 part_cosine * d.y() - part_sine * d.x());
    return Eigen::Vector2d(c * turned.x() - s * turned.y(), s * turned.x() + c * turned.y())
        .normalized();
  }

  const double whole = std::atan2(whole_sine, whole_cosine);
  const double part = std::atan2(part_sine, part_cosine);
  double turn = std::atan2(turn_sine, turn_cosine);
  // The right end lies clockwise of the left one, more than half a turn at a very sharp source.
  if (turn > std::numbers::pi / 2.0) turn -= 2.0 * std::numbers::pi;
  const double angle = whole > 0.0 ? turn * part / whole : 0.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * d.x() - s * d.y(), s * d.x() + c * d.y()};
}

/// Fitted: what the window shows of its own face (Melvaer & Reimers 2012, 3.2).
void Dgpc::lookThrough(const Node& left, const Node& right, const Behind& face) {
  if (left.r <= 0.0 || right.r <= 0.0 || face.length <= 0.0 || face.apex == source_vertex_)
    return;
  // The way to the apex and the window are the diagonals of a quadrilateral, together longer
  // than two of its sides.
  const double least =
      std::max(left.r + face.right_length, right.r + face.left_length) - face.length;
  if (!isBetter(face.apex, least, Kind::kFitted)) return;
  const double square = face.length * face.length;
  if ((right.position() - left.position()).squaredNorm() > kMostStretch * kMostStretch * square)
    return;

  // === The source behind the window, in coordinates along it, from the two distances;
  // behind it, so that the window's ends have y = depth > 0
  const double source_x =
      ((left.r - right.r) * (left.r + right.r) / face.length + face.length) / 2.0;
  const double depth_squared = (left.r - source_x) * (left.r + source_x);
  if (!(depth_squared > kRayRounding * kRayRounding * left.r * left.r)) return;
  const double depth = std::sqrt(depth_squared);

  // === The apex, from its distances to the window's ends
  const double apex_x = ((face.left_length - face.right_length) *
                             (face.left_length + face.right_length) / face.length +
                         face.length) /
                        2.0;
  const double apex_y =
      std::sqrt(std::max(0.0, (face.left_length - apex_x) * (face.left_length + apex_x)));
  const Window window{
      left.direction_T, right.direction_T, {-source_x, depth}, {face.length - source_x, depth}};
  const Eigen::Vector2d p(apex_x - source_x, depth + apex_y);
  if (cross(window.left, p) > 0.0 || cross(p, window.right) > 0.0) return;
  const double r = p.norm();
  if (!isBetter(face.apex, r, Kind::kFitted)) return;
  offer(face.apex, r, directionThrough(window, p), Kind::kFitted);
}

bool Dgpc::isBetter(int vertex, double r, Kind kind) const {
  const Node* node = nodeOf(vertex);
  if (!node) return may_meet_;
  if (vertex == source_vertex_) return false;
  if (kind == Kind::kFitted) {
    return r < node->fitted_limit &&
           r < node->r * (node->exact ? 1.0 - kExactTie : 1.0 + kFittedTie);
  }
  return r < node->r * (node->exact ? 1.0 - kExactGain : 1.0 + kExactTie);
}

void Dgpc::offer(int vertex, double r, const Eigen::Vector2d& direction_T, Kind kind) {
  if (!isBetter(vertex, r, kind)) return;
  // Lengths that overflow, or whose squares vanish, reach nothing.
  if (!std::isfinite(r) || !direction_T.allFinite()) return;
  int& index = node_of_[vertex];
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
    nodes_.back().least_gain = kFittedGain;
  }
  Node& node = nodes_[index];
  node.r = r;
  node.direction_T = direction_T;
  node.exact = kind == Kind::kExact;
  node.settled = false;
  if (!node.waits) improved_.push_back(index);
  node.waits = true;
}

}  // namespace handgraft::geometry
