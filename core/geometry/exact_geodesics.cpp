#include "core/geometry/exact_geodesics.h"

#include <algorithm>
#include <numbers>

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

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
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
    BucketQueue::Entry next;
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
    if (behind.node >= 0 && !behind.is_left) {
      const double gap = known - nodes_[behind.node].r;
      if (gap > 0.0 &&
          (left_distance * window.left_ray - behind.place).squaredNorm() < gap * gap)
        return false;
    }
  }
  if (right_tells) {
    right_distance = depth / right_sine;
    const double known = (offset + right_distance) * (1.0 - kSlack);
    const double at = foot + right_distance * right_cosine;
    if (left_node.r + at < known) return false;
    if (behind.node >= 0 && behind.is_left) {
      const double gap = known - nodes_[behind.node].r;
      if (gap > 0.0 &&
          (right_distance * window.right_ray - behind.place).squaredNorm() < gap * gap)
        return false;
    }
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
    const int apex = side.apex;
    if (window.nearest <= radius_) nodes_[apex].is_wanted = true;

    // === Unfold the face, by turning from edge to edge: taking directions from places instead
    // would blow up their rounding in every sliver on the way.
    const Eigen::Vector2d to_apex = turned(window.along, side.apex_x, side.apex_y);
    const Eigen::Vector2d p = window.left + to_apex;
    const double beyond_left = cross(window.left_ray, p);
    const double beyond_right = cross(p, window.right_ray);
    bool goes_left = beyond_left <= 0.0;
    bool goes_right = beyond_right <= 0.0;
    const double squared = p.squaredNorm();
    const double seen = kSeen * kSeen * squared;
    Window right = window;
    Window left = window;
    if ((goes_left || beyond_left * beyond_left <= seen) &&
        (goes_right || beyond_right * beyond_right <= seen)) {
      // === Serve the apex, which is seen
      const double distance = std::sqrt(squared);
      const double r = planes_[window.plane].offset + distance;
      const double slope = cross(p, window.along);
      const double at = slope != 0.0 ? -cross(p, window.left) / slope : 0.0;
      if (reach(apex, r, window.plane, p) && nodes_[apex].bends_paths) {
        arriveAt(apex, FlatFaces::previous(s),
                 std::max(0.0, std::atan2(cross(to_apex, p), to_apex.dot(p))));
      }
      // Chen & Han 1990: of the windows that serve an angle only the best one splits.
      if (r < side.split_distance * (1.0 - kGain)) {
        side.split_distance = r;
        side.split_at = at;
      } else if (at < side.split_at - kSamePlace * side.length) {
        goes_right = false;
      } else if (at > side.split_at + kSamePlace * side.length) {
        goes_left = false;
      }
      const Eigen::Vector2d p_ray = p / distance;
      if (!(beyond_left > 0.0)) right.left_ray = p_ray;
      if (!(beyond_right > 0.0)) left.right_ray = p_ray;
      goes_right = goes_right && isWide(right);
      goes_left = goes_left && isWide(left);
    }

    // === Go on through the two other sides
    if (goes_right) {
      right.side = FlatFaces::next(s);
      const FlatFaces::Side& ahead = faces_.side(right.side);
      right.left = p;
      right.left_node = apex;
      right.along = turned(window.along, (side.length - side.apex_x) * ahead.inverse_length,
                           -side.apex_y * ahead.inverse_length);
      goes_right =
          faces_.isOpen(right.side) && measure(right, {window.left_node, true, window.left});
    }
    if (goes_left) {
      left.side = FlatFaces::previous(s);
      const FlatFaces::Side& ahead = faces_.side(left.side);
      left.right_node = apex;
      left.along = turned(window.along, side.apex_x * ahead.inverse_length,
                          side.apex_y * ahead.inverse_length);
      goes_left =
          faces_.isOpen(left.side) &&
          measure(left, {window.right_node, false, window.left + side.length * window.along});
    }
    if (goes_left && goes_right) wait(left);
    if (!goes_left && !goes_right) return;
    window = goes_right ? right : left;
    if (window.nearest > queue_.nearEnd()) {
      wait(window);
      return;
    }
  }
}

}  // namespace handgraft::geometry
