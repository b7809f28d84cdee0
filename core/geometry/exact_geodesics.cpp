#include "core/geometry/exact_geodesics.h"

#include <algorithm>
#include <numbers>

#include "core/base/angle.h"

namespace handgraft::geometry {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr double kSeen = 1e-9;  // sine beyond a window's ray at which a corner is still seen
constexpr double kNarrowest = 1e-12;  // sine between a window's rays
constexpr double kGain = 1e-12;       // of r: a few roundings, not worth carrying on
constexpr double kSamePlace = 1e-9;   // of an edge
// Sine below which a ray does not tell where it crosses: 12 digits of the place are left there.
constexpr double kEdgeOn = 1e-4;
constexpr double kSlack = 1e-10;  // of r: a filter's comparison is off by less than that
// Windows that one side takes. Convex and noisy surfaces need some ten; endless windings around
// needles end here.
constexpr int kMostPasses = 4096;
// Of an edge: how far the order in which windows pass may differ from that of their distances.
constexpr double kStep = 1.0;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// `v` turned and stretched by `turn`, a complex number.
Eigen::Vector2d turned(const Eigen::Vector2d& v, double turn_x, double turn_y) {
  return {turn_x * v.x() - turn_y * v.y(), turn_x * v.y() + turn_y * v.x()};
}

}  // namespace

double ExactGeodesics::Node::phi() const {
  const double angle = std::remainder(turn, 2.0 * kPi);
  return angle <= -kPi ? kPi : angle;
}

ExactGeodesics::ExactGeodesics(const TriangleMesh& mesh,
                               const SourceLayout& source,
                               double radius)
    : faces_(mesh), radius_(radius), limit_(kInfinity) {
  for (const int f : source.faces)
    faces_.add(f);
  queue_ = BucketQueue(kStep * std::min(faces_.longestSide(), mesh.meanEdgeLength()));
  seed(source);
}

void ExactGeodesics::run() {
  while (queue_.advance()) {
    if (queue_.nearBegin() > radius_) tightenLimit();
    if (queue_.nearBegin() > limit_) break;
    BucketQueue::Entry next{};
    while (queue_.take(next)) {
      if (next.number < 0) {
        // Improved since: waiting under its newer distance.
        if (nodes_[~next.number].r == next.distance) spread(~next.number);
        continue;
      }
      free_.push_back(next.number);
      if (next.distance <= limit_) carry(windows_[next.number]);
    }
  }
  tightenLimit();
  for (Node& node : nodes_) {
    if (!(node.r <= limit_)) {
      node.r = kInfinity;
      continue;
    }
    const Plane& plane = planes_[node.plane];
    node.turn = plane.base;
    if (plane.scale > 0.0) node.turn += plane.scale * std::atan2(node.p.y(), node.p.x());
  }
}

/// A path to a wanted vertex that is shorter than the one known leads through none but windows
/// nearer than that.
void ExactGeodesics::tightenLimit() {
  limit_ = radius_;
  for (const Node& node : nodes_) {
    if (node.is_wanted) limit_ = std::max(limit_, node.r);
  }
  // Of a face that the disk reaches into, no corner is farther beyond it than a side is long.
  limit_ = std::min(limit_, radius_ + faces_.longestSide());
}

// === Vertices

void ExactGeodesics::takeNodes() {
  const IndexMap& vertices = faces_.vertices();
  for (int node = static_cast<int>(nodes_.size()); node < vertices.size(); ++node) {
    nodes_.emplace_back();
    nodes_.back().vertex = vertices.keyOf(node);
    nodes_.back().bends_paths = bendsPaths(vertices.keyOf(node));
  }
}

bool ExactGeodesics::bendsPaths(int vertex) const {
  const TriangleMesh& mesh = faces_.mesh();
  const double straight = mesh.isBoundaryVertex(vertex) ? kPi : 2.0 * kPi;
  return mesh.angleSum(vertex) > straight + kFlatAngle || !isOneFan(vertex);
}

bool ExactGeodesics::isOneFan(int vertex) const {
  const TriangleMesh& mesh = faces_.mesh();
  const int* begin = mesh.outgoingBegin(vertex);
  const int* end = mesh.outgoingEnd(vertex);
  int first = *begin;
  if (mesh.isBoundaryVertex(vertex)) {
    first = *std::find_if(begin, end - 1, [&](int h) {
      return mesh.twin(h) < 0;
    });
  }
  std::ptrdiff_t count = 0;
  int h = first;
  do {
    ++count;
    h = mesh.twin(TriangleMesh::previous(h));
  } while (h >= 0 && h != first);
  return count == end - begin;
}

// === The source

void ExactGeodesics::seed(const SourceLayout& source) {
  planes_.push_back({0.0, 0.0, 1.0});  // T itself
  if (source.vertex >= 0) faces_.addVertex(source.vertex);
  for (const SourceNeighbour& n : source.neighbours)
    faces_.addVertex(n.vertex);
  takeNodes();
  const auto node_at = [&](int vertex) {
    return faces_.vertices().find(vertex);
  };
  if (source.vertex >= 0) reach(node_at(source.vertex), 0.0, 0, Eigen::Vector2d::UnitX());
  for (const SourceNeighbour& n : source.neighbours)
    reach(node_at(n.vertex), n.r, 0, n.direction_T);

  const TriangleMesh& mesh = faces_.mesh();
  for (const int f : source.faces) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      const int node = node_at(mesh.from(h));
      nodes_[node].is_wanted = true;
      if (mesh.from(h) == source.vertex || nodes_[node].arrival_side >= 0) continue;
      const Eigen::Vector3d p = mesh.vertex(mesh.from(h));
      arriveAt(node, faces_.sideOf(h),
               angleBetween(mesh.vertex(mesh.to(h)) - p, source.origin - p));
    }
  }

  for (const SourceWedge& wedge : source.wedges) {
    const Eigen::Vector2d edge = wedge.from - wedge.to;
    const double length = edge.norm();
    if (!(length > 0.0) || wedge.from.isZero(0.0) || wedge.to.isZero(0.0)) continue;
    planes_.push_back({0.0, wedge.base, wedge.scale});
    open({wedge.to, edge / length, wedge.to.normalized(), wedge.from.normalized(),
          faces_.sideOf(wedge.halfedge), static_cast<int>(planes_.size()) - 1,
          node_at(mesh.to(wedge.halfedge)), node_at(mesh.from(wedge.halfedge))});
  }
}

bool ExactGeodesics::reach(int node, double r, int plane, const Eigen::Vector2d& p) {
  Node& n = nodes_[node];
  if (!(r < n.r * (1.0 - kGain))) return false;
  n.r = r;
  n.plane = plane;
  n.p = p;
  return true;
}

void ExactGeodesics::arriveAt(int node, int side, double angle) {
  Node& n = nodes_[node];
  n.arrival_side = side;
  n.arrival_angle = angle;
  if (n.bends_paths) queue_.put(n.r, ~node);
}

// === Windows

bool ExactGeodesics::isWide(const Window& window) {
  return cross(window.right_ray, window.left_ray) > kNarrowest ||
         window.right_ray.dot(window.left_ray) <= 0.0;
}

void ExactGeodesics::open(Window window) {
  if (!faces_.isOpen(window.side)) return;
  if (isWide(window) && measure(window, {})) wait(window);
}

void ExactGeodesics::wait(const Window& window) {
  int index = static_cast<int>(windows_.size());
  if (free_.empty()) {
    windows_.push_back(window);
  } else {
    index = free_.back();
    free_.pop_back();
    windows_[index] = window;
  }
  queue_.put(window.nearest, index);
}

/// Whether the corner's own path to `place` is shorter than `known`.
inline bool ExactGeodesics::comesFirst(const Behind& behind,
                                       const Eigen::Vector2d& place,
                                       double known) const {
  const double gap = known - nodes_[behind.node].r;
  return gap > 0.0 && (place - behind.place).squaredNorm() < gap * gap;
}

/// Finds the window's nearest place on the side ahead; false if a corner's own path is shorter
/// than all of the window's (Xin & Wang 2009, section 3.2: they cross the way from a corner
/// that comes first to the window's far end).
bool ExactGeodesics::measure(Window& window, const Behind& behind) const {
  const double offset = planes_[window.plane].offset;
  const double depth = cross(window.along, window.left);
  const double foot = -window.left.dot(window.along);
  const double length = faces_.side(window.side).length;
  const double left_sine = cross(window.along, window.left_ray);
  const double right_sine = cross(window.along, window.right_ray);
  const double left_cosine = window.left_ray.dot(window.along);
  const double right_cosine = window.right_ray.dot(window.along);
  const Node& left_node = nodes_[window.left_node];
  const Node& right_node = nodes_[window.right_node];

  // === Where the rays cross the side: distances along the rays
  double left_distance = 0.0;
  double right_distance = 0.0;
  const bool left_tells = left_sine > kEdgeOn;
  const bool right_tells = right_sine > kEdgeOn;
  if (left_tells) {
    left_distance = depth / left_sine;
    const double known = (offset + left_distance) * (1.0 - kSlack);
    const double at = foot + left_distance * left_cosine;
    if (right_node.r + (length - at) < known) return false;
    if (behind.node >= 0 && !behind.is_left &&
        comesFirst(behind, left_distance * window.left_ray, known))
      return false;
  }
  if (right_tells) {
    right_distance = depth / right_sine;
    const double known = (offset + right_distance) * (1.0 - kSlack);
    const double at = foot + right_distance * right_cosine;
    if (left_node.r + at < known) return false;
    if (behind.node >= 0 && behind.is_left &&
        comesFirst(behind, right_distance * window.right_ray, known))
      return false;
  }

  // === The nearest place: an end, or the foot of the perpendicular between them
  if (left_tells && left_cosine >= 0.0) {
    window.nearest = offset + left_distance;
  } else if (right_tells && right_cosine <= 0.0) {
    window.nearest = offset + right_distance;
  } else if (left_tells && right_tells) {
    window.nearest = offset + depth;
  } else {
    const double x = foot - std::clamp(foot, 0.0, length);
    window.nearest = offset + std::sqrt(x * x + depth * depth);
  }
  return window.nearest < kInfinity;
}

/// Unfolds the face behind `side`, by turning from edge to edge: taking directions from places
/// instead would blow up their rounding in every sliver on the way.
inline ExactGeodesics::Apex ExactGeodesics::unfold(const Window& window,
                                                   const FlatFaces::Side& side) {
  const Eigen::Vector2d from_left = turned(window.along, side.apex_x, side.apex_y);
  const Eigen::Vector2d place = window.left + from_left;
  return {place, from_left, place.squaredNorm(), cross(window.left_ray, place),
          cross(place, window.right_ray)};
}

inline bool ExactGeodesics::isSeen(const Apex& apex) {
  const double seen = kSeen * kSeen * apex.squared;
  return (apex.beyond_left <= 0.0 || apex.beyond_left * apex.beyond_left <= seen) &&
         (apex.beyond_right <= 0.0 || apex.beyond_right * apex.beyond_right <= seen);
}

/// Serves an apex that is seen, and narrows the windows that go on to either side of it.
inline void ExactGeodesics::serve(const Window& window, int s, const Apex& apex, Split& split) {
  FlatFaces::Side& side = faces_.side(s);
  const Eigen::Vector2d& p = apex.place;
  const double distance = std::sqrt(apex.squared);
  const double r = planes_[window.plane].offset + distance;
  const double slope = cross(p, window.along);
  const double at = slope != 0.0 ? -cross(p, window.left) / slope : 0.0;
  if (reach(side.apex, r, window.plane, p) && nodes_[side.apex].bends_paths) {
    arriveAt(side.apex, FlatFaces::previous(s),
             std::max(0.0, std::atan2(cross(apex.from_left, p), apex.from_left.dot(p))));
  }
  // Chen & Han 1990: of the windows that serve an angle only the best one splits.
  if (r < side.split_distance * (1.0 - kGain)) {
    side.split_distance = r;
    side.split_at = at;
  } else if (at < side.split_at - kSamePlace * side.length) {
    split.goes_right = false;
  } else if (at > side.split_at + kSamePlace * side.length) {
    split.goes_left = false;
  }
  const Eigen::Vector2d p_ray = p / distance;
  if (!(apex.beyond_left > 0.0)) split.right.left_ray = p_ray;
  if (!(apex.beyond_right > 0.0)) split.left.right_ray = p_ray;
  split.goes_right = split.goes_right && isWide(split.right);
  split.goes_left = split.goes_left && isWide(split.left);
}

/// Makes `right` the part of `window` that leaves the face right of the apex; false if nothing
/// comes of it.
inline bool ExactGeodesics::goOnRight(const Window& window,
                                      int s,
                                      const Apex& apex,
                                      Window& right) const {
  const FlatFaces::Side& side = faces_.side(s);
  right.side = FlatFaces::next(s);
  const FlatFaces::Side& ahead = faces_.side(right.side);
  right.left = apex.place;
  right.left_node = side.apex;
  right.along = turned(window.along, (side.length - side.apex_x) * ahead.inverse_length,
                       -side.apex_y * ahead.inverse_length);
  return faces_.isOpen(right.side) && measure(right, {window.left_node, true, window.left});
}

/// The same left of the apex.
inline bool ExactGeodesics::goOnLeft(const Window& window, int s, Window& left) const {
  const FlatFaces::Side& side = faces_.side(s);
  left.side = FlatFaces::previous(s);
  const FlatFaces::Side& ahead = faces_.side(left.side);
  left.right_node = side.apex;
  left.along = turned(window.along, side.apex_x * ahead.inverse_length,
                      side.apex_y * ahead.inverse_length);
  return faces_.isOpen(left.side) &&
         measure(left, {window.right_node, false, window.left + side.length * window.along});
}

/// Takes a window from face to face, as long as it is one and stays within the step at hand.
void ExactGeodesics::carry(Window window) {
  while (true) {
    const int s = faces_.across(window.side);
    takeNodes();
    FlatFaces::Side& side = faces_.side(s);
    if (++side.passes > kMostPasses) {
      cut_short_ = true;
      return;
    }
    if (window.nearest <= radius_) nodes_[side.apex].is_wanted = true;

    const Apex apex = unfold(window, side);
    Split split{window, window, apex.beyond_left <= 0.0, apex.beyond_right <= 0.0};
    if (isSeen(apex)) serve(window, s, apex, split);
    const bool goes_right = split.goes_right && goOnRight(window, s, apex, split.right);
    const bool goes_left = split.goes_left && goOnLeft(window, s, split.left);
    if (goes_left && goes_right) wait(split.left);
    if (!goes_left && !goes_right) return;
    window = goes_right ? split.right : split.left;
    if (window.nearest > queue_.nearEnd()) {
      wait(window);
      return;
    }
  }
}

}  // namespace handgraft::geometry
