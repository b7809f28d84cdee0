#include "core/geometry/window_front.h"

#include <algorithm>
#include <functional>
#include <numbers>

namespace handgraft::geometry {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Flatter vertices bend no path: whatever lies in their shadow counts as seen past them.
constexpr double kFlatAngle = 1e-9;  // rad
constexpr double kSeen = 1e-9;  // sine beyond a window's ray at which a corner is still seen
constexpr double kNarrowest = 1e-12;  // sine between a window's rays
constexpr double kGain = 1e-12;       // of r: a few roundings, not worth carrying on
constexpr double kSlack = 1e-12;      // of r: what a filter's comparison may be off
constexpr double kSamePlace = 1e-9;   // of an edge
constexpr double kEdgeOn = 1e-6;      // sine below which a ray does not tell where it crosses
// Windows that one face takes. Convex and noisy surfaces need some ten; endless windings around
// needles end here.
constexpr int kMostPasses = 4096;
// Of an edge: how far the order in which windows pass may differ from that of their distances.
constexpr double kStep = 1.0;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Eigen::Vector2d leftOf(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

Eigen::Vector2d unit(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

double WindowFront::Node::phi() const {
  const double angle = std::remainder(turn, 2.0 * kPi);
  return angle <= -kPi ? kPi : angle;
}

WindowFront::WindowFront(const TriangleMesh& mesh, const SourceLayout& source, double radius)
    : mesh_(mesh),
      radius_(radius),
      node_of_(static_cast<std::size_t>(mesh.vertexCount()), -1),
      face_of_(static_cast<std::size_t>(mesh.faceCount()), -1) {
  seed(source);
  step_ = kStep * std::min(reach_, mesh.meanEdgeLength());
}

void WindowFront::run() {
  while (!far_.empty() && far_.front().first <= radius_ + reach_) {
    // What lies within one step comes in any order: last in, first out, while it is at hand.
    near_end_ = std::min(far_.front().first + step_, radius_ + reach_);
    while (!far_.empty() && far_.front().first <= near_end_) {
      near_.push_back(far_.front());
      std::pop_heap(far_.begin(), far_.end(), std::greater<>());
      far_.pop_back();
    }
    while (!near_.empty()) {
      const auto [distance, index] = near_.back();
      near_.pop_back();
      advance(distance, index);
    }
  }
  for (Node& node : nodes_) {
    const Plane& plane = planes_[node.plane];
    node.turn = plane.base;
    if (plane.scale > 0.0) node.turn += plane.scale * std::atan2(node.p.y(), node.p.x());
  }
}

void WindowFront::advance(double distance, int index) {
  if (index < 0) {
    // Improved since: waiting under its newer distance.
    if (nodes_[~index].r == distance) spread(~index);
    return;
  }
  const Window window = windows_[index];
  free_.push_back(index);
  if (isUseless(window)) return;
  const Face& face = faces_[faceAt(TriangleMesh::faceOf(window.halfedge))];
  if (distance <= radius_) {
    for (const Side& side : face.sides)
      reach_ = std::max(reach_, side.length);
  }
  pass(window);
}

// === The disk, in numbers of its own

int WindowFront::nodeAt(int vertex) {
  int& node = node_of_[vertex];
  if (node < 0) {
    node = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    nodes_.back().vertex = vertex;
    nodes_.back().bends_paths = bendsPaths(vertex);
  }
  return node;
}

int WindowFront::faceAt(int f) {
  if (face_of_[f] >= 0) return face_of_[f];
  face_of_[f] = static_cast<int>(faces_.size());
  Face face{};
  for (int c = 0; c < 3; ++c) {
    const int h = 3 * f + c;
    face.nodes[c] = nodeAt(mesh_.from(h));
    const Eigen::Vector3d a = mesh_.vertex(mesh_.from(h));
    const Eigen::Vector3d edge = mesh_.vertex(mesh_.to(h)) - a;
    const Eigen::Vector3d to_apex = mesh_.vertex(mesh_.to(TriangleMesh::next(h))) - a;
    const double length = edge.norm();
    const Eigen::Vector3d along =
        length > 0.0 ? Eigen::Vector3d(edge / length) : Eigen::Vector3d::Zero();
    const double x = to_apex.dot(along);
    face.sides[c] = {length, x, (to_apex - x * along).norm(), kInfinity, 0.0};
  }
  faces_.push_back(face);
  return face_of_[f];
}

bool WindowFront::bendsPaths(int vertex) const {
  const double straight = mesh_.isBoundaryVertex(vertex) ? kPi : 2.0 * kPi;
  return mesh_.angleSum(vertex) > straight + kFlatAngle || !isOneFan(vertex);
}

bool WindowFront::isOneFan(int vertex) const {
  const int* begin = mesh_.outgoingBegin(vertex);
  const int* end = mesh_.outgoingEnd(vertex);
  const int first = *std::find_if(begin, end - 1, [&](int h) {
    return mesh_.twin(h) < 0;
  });
  std::ptrdiff_t count = 0;
  int h = first;
  do {
    ++count;
    h = mesh_.twin(TriangleMesh::previous(h));
  } while (h >= 0 && h != first);
  return count == end - begin;
}

// === The source

void WindowFront::seed(const SourceLayout& source) {
  planes_.push_back({0.0, 0.0, 1.0});  // T itself
  if (source.vertex >= 0) reach(nodeAt(source.vertex), 0.0, 0, Eigen::Vector2d::UnitX());
  for (const SourceNeighbour& n : source.neighbours)
    reach(nodeAt(n.vertex), n.r, 0, n.direction_T);

  for (const int f : source.faces) {
    const Face& face = faces_[faceAt(f)];
    for (const Side& side : face.sides)
      reach_ = std::max(reach_, side.length);
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      const int node = node_of_[mesh_.from(h)];
      if (mesh_.from(h) == source.vertex || nodes_[node].arrival_edge >= 0) continue;
      const Eigen::Vector3d p = mesh_.vertex(mesh_.from(h));
      arriveAt(node, h, angleBetween(mesh_.vertex(mesh_.to(h)) - p, source.origin - p));
    }
  }

  for (const SourceWedge& wedge : source.wedges) {
    const int twin = mesh_.twin(wedge.halfedge);
    const Eigen::Vector2d edge = wedge.from - wedge.to;
    const double length = edge.norm();
    if (twin < 0 || !(length > 0.0) || wedge.from.isZero(0.0) || wedge.to.isZero(0.0)) continue;
    planes_.push_back({0.0, wedge.base, wedge.scale});
    open({twin, static_cast<int>(planes_.size()) - 1, nodeAt(mesh_.from(twin)),
          nodeAt(mesh_.to(twin)), length, wedge.to, edge / length, wedge.to.normalized(),
          wedge.from.normalized()},
         Behind::kNone, -1, Eigen::Vector2d::Zero());
  }
}

bool WindowFront::reach(int node, double r, int plane, const Eigen::Vector2d& p) {
  Node& n = nodes_[node];
  if (!(r < n.r * (1.0 - kGain))) return false;
  n.r = r;
  n.plane = plane;
  n.p = p;
  return true;
}

void WindowFront::arriveAt(int node, int edge, double angle) {
  Node& n = nodes_[node];
  n.arrival_edge = edge;
  n.arrival_angle = angle;
  if (n.bends_paths) push(n.r, ~node);
}

// === Windows

bool WindowFront::isUseless(const Window& window) const {
  return nodes_[window.left_node].r < window.left_bound ||
         nodes_[window.right_node].r < window.right_bound ||
         nodes_[window.behind_node].r < window.behind_bound;
}

void WindowFront::open(const Bundle& bundle,
                       Behind behind,
                       int behind_node,
                       const Eigen::Vector2d& behind_place) {
  const double width = cross(bundle.right_ray, bundle.left_ray);
  if (!(width > kNarrowest) && bundle.right_ray.dot(bundle.left_ray) > 0.0) return;

  // === Where the rays cross the edge, as lengths along the edge and along the rays
  const double depth = cross(bundle.left, bundle.along);
  const double left_sine = cross(bundle.left_ray, bundle.along);
  const double right_sine = cross(bundle.right_ray, bundle.along);
  const double offset = planes_[bundle.plane].offset;
  Window window{bundle.halfedge,  bundle.plane, bundle.left_node, bundle.right_node,
                bundle.left_node, bundle.left,  bundle.along,     bundle.left_ray,
                bundle.right_ray, -kInfinity,   -kInfinity,       -kInfinity};
  const double foot = -bundle.left.dot(bundle.along);
  double begin = 0.0;
  double end = bundle.length;
  const bool left_tells = std::abs(left_sine) > kEdgeOn;
  const bool right_tells = std::abs(right_sine) > kEdgeOn;
  if (left_tells) {
    begin = std::clamp(-cross(bundle.left_ray, bundle.left) / left_sine, 0.0, bundle.length);
    // Xin & Wang 2009, section 3.2: all of the window's paths cross the way from a corner that
    // comes first to its far end.
    const double r = offset + length(begin - foot, depth);
    const double known = r * (1.0 - kSlack);
    window.right_bound = known - (bundle.length - begin);
    if (behind == Behind::kRightOfPaths) {
      window.behind_node = behind_node;
      window.behind_bound = known - (bundle.left + begin * bundle.along - behind_place).norm();
    }
  }
  if (right_tells) {
    end = std::clamp(-cross(bundle.right_ray, bundle.left) / right_sine, 0.0, bundle.length);
    const double r = offset + length(end - foot, depth);
    const double known = r * (1.0 - kSlack);
    window.left_bound = known - end;
    if (behind == Behind::kLeftOfPaths) {
      window.behind_node = behind_node;
      window.behind_bound = known - (bundle.left + end * bundle.along - behind_place).norm();
    }
  }
  if (isUseless(window)) return;
  const double nearest =
      offset + length(std::clamp(foot, begin, std::max(begin, end)) - foot, depth);
  if (!(nearest < kInfinity)) return;

  int index = static_cast<int>(windows_.size());
  if (free_.empty()) {
    windows_.push_back(window);
  } else {
    index = free_.back();
    free_.pop_back();
    windows_[index] = window;
  }
  push(nearest, index);
}

void WindowFront::pass(const Window& window) {
  const int h = window.halfedge;
  Face& face = faces_[face_of_[TriangleMesh::faceOf(h)]];
  if (++face.passes > kMostPasses) {
    cut_short_ = true;
    return;
  }
  const int corner = h % 3;
  const int right_corner = (corner + 1) % 3;
  const int apex_corner = (corner + 2) % 3;
  Side& side = face.sides[corner];
  const int apex = face.nodes[apex_corner];

  // === Unfold the face, by turning from edge to edge: taking directions from places instead
  // would blow up their rounding in every sliver on the way.
  const Eigen::Vector2d up = side.apex_y * leftOf(window.along);
  const Eigen::Vector2d to_apex = side.apex_x * window.along + up;
  const Eigen::Vector2d p = window.left + to_apex;
  const double distance = p.norm();
  const double beyond_left = cross(window.left_ray, p);
  const double beyond_right = cross(p, window.right_ray);
  bool goes_left = beyond_left <= 0.0;
  bool goes_right = beyond_right <= 0.0;

  // === Serve the apex if it is seen
  if (beyond_left <= kSeen * distance && beyond_right <= kSeen * distance) {
    const double r = planes_[window.plane].offset + distance;
    const double slope = cross(p, window.along);
    const double at = slope != 0.0 ? -cross(p, window.left) / slope : 0.0;
    if (reach(apex, r, window.plane, p)) {
      if (nodes_[apex].bends_paths) {
        arriveAt(apex, 3 * TriangleMesh::faceOf(h) + apex_corner,
                 std::max(0.0, std::atan2(cross(to_apex, p), to_apex.dot(p))));
      }
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
  }

  // === Go on through the two other edges
  const Eigen::Vector2d p_ray = p / distance;
  const int right_edge = goes_right ? mesh_.twin(TriangleMesh::next(h)) : -1;
  const int left_edge = goes_left ? mesh_.twin(TriangleMesh::previous(h)) : -1;
  const double right_length = face.sides[right_corner].length;
  const double left_length = face.sides[apex_corner].length;
  if (right_edge >= 0 && right_length > 0.0) {
    const Eigen::Vector2d rest = (side.length - side.apex_x) * window.along - up;
    open({right_edge, window.plane, apex, window.right_node, right_length, p,
          rest / right_length, beyond_left > 0.0 ? window.left_ray : p_ray, window.right_ray},
         Behind::kLeftOfPaths, window.left_node, window.left);
  }
  if (left_edge >= 0 && left_length > 0.0) {
    open(
        {left_edge, window.plane, window.left_node, apex, left_length, window.left,
         to_apex / left_length, window.left_ray, beyond_right > 0.0 ? window.right_ray : p_ray},
        Behind::kRightOfPaths, window.right_node, window.left + side.length * window.along);
  }
}

// === Vertices that bend paths

double WindowFront::cornerAngle(int h) {
  const Side& opposite = faces_[faceAt(TriangleMesh::faceOf(h))].sides[(h % 3 + 1) % 3];
  return std::atan2(opposite.apex_y * opposite.length,
                    opposite.apex_y * opposite.apex_y -
                        opposite.apex_x * (opposite.length - opposite.apex_x));
}

/// The most clockwise halfedge of the fan of `h`, or `h` itself if the fan is closed.
int WindowFront::firstOfFan(int h) const {
  int first = h;
  while (mesh_.twin(first) >= 0) {
    first = TriangleMesh::next(mesh_.twin(first));
    if (first == h) break;
  }
  return first;
}

void WindowFront::spread(int node) {
  const int v = nodes_[node].vertex;
  const int arrival = firstOfFan(nodes_[node].arrival_edge);
  spreadOverFan(node, arrival, nodes_[node].arrival_angle, true);
  if (isOneFan(v)) return;
  // === Into every other fan, in all directions
  std::vector<int> firsts{arrival};
  for (const int* h = mesh_.outgoingBegin(v); h != mesh_.outgoingEnd(v); ++h) {
    int first = firstOfFan(*h);
    if (mesh_.twin(first) >= 0) {  // closed: named by its lowest halfedge
      int lowest = first;
      bool is_arrival_fan = false;
      int turn = first;
      do {
        lowest = std::min(lowest, turn);
        is_arrival_fan = is_arrival_fan || turn == arrival;
        turn = mesh_.twin(TriangleMesh::previous(turn));
      } while (turn >= 0 && turn != first);
      first = is_arrival_fan ? arrival : lowest;
    }
    if (std::find(firsts.begin(), firsts.end(), first) != firsts.end()) continue;
    firsts.push_back(first);
    spreadOverFan(node, first, 0.0, false);
  }
}

/// A shortest path goes on where it has at least half a turn on either side of it.
void WindowFront::spreadOverFan(int node, int first, double arrival, bool is_arrival_fan) {
  struct Corner {
    int halfedge;
    double begin;
    double end;
  };

  std::vector<Corner> corners;
  double angle = 0.0;
  int h = first;
  do {
    const double begin = angle;
    angle += cornerAngle(h);
    if (is_arrival_fan && h == nodes_[node].arrival_edge) arrival += begin;
    corners.push_back({h, begin, angle});
    h = mesh_.twin(TriangleMesh::previous(h));
  } while (h >= 0 && h != first);

  const bool closed = h == first;
  const int plane = static_cast<int>(planes_.size());
  const Node& n = nodes_[node];
  const Plane& before = planes_[n.plane];
  double turn = before.base;
  if (before.scale > 0.0) turn += before.scale * std::atan2(n.p.y(), n.p.x());
  planes_.push_back({n.r, turn, 0.0});
  const auto serve = [&](double low, double high) {
    for (const Corner& c : corners) {
      if (c.end >= low && c.begin <= high) {
        spreadInto(plane, c.halfedge, low - c.begin, high - c.begin);
      }
    }
  };
  if (!is_arrival_fan) {
    serve(-kInfinity, kInfinity);
  } else if (closed) {
    serve(arrival + kPi - kFlatAngle, arrival + angle - kPi + kFlatAngle);
  } else {
    serve(-kInfinity, arrival - kPi + kFlatAngle);
    serve(arrival + kPi - kFlatAngle, kInfinity);
  }
}

/// Through the corner that starts counter-clockwise of `h`, between two angles measured from
/// it.
void WindowFront::spreadInto(int plane, int h, double low, double high) {
  const Face& face = faces_[faceAt(TriangleMesh::faceOf(h))];
  const int corner = h % 3;
  const double angle = cornerAngle(h);
  const double right_length = face.sides[corner].length;
  const double left_length = face.sides[(corner + 2) % 3].length;
  const Side& across = face.sides[(corner + 1) % 3];
  const int right_node = face.nodes[(corner + 1) % 3];
  const int left_node = face.nodes[(corner + 2) % 3];
  const double offset = planes_[plane].offset;
  // The neighbours' paths arrive along these edges.
  const auto reachAlong = [&](int node, double length, int edge, double at) {
    if (reach(node, offset + length, plane, Eigen::Vector2d::UnitX())) {
      arriveAt(node, edge, at);
    }
  };
  const int next = TriangleMesh::next(h);
  const int previous = TriangleMesh::previous(h);
  if (low <= kFlatAngle) reachAlong(right_node, right_length, next, cornerAngle(next));
  if (high >= angle - kFlatAngle) reachAlong(left_node, left_length, previous, 0.0);

  const int twin = mesh_.twin(next);
  if (twin < 0 || !(across.length > 0.0)) return;
  const Eigen::Vector2d left = left_length * unit(angle);
  const Eigen::Vector2d right(right_length, 0.0);
  open({twin, plane, left_node, right_node, across.length, left, (right - left) / across.length,
        unit(std::min(angle, high)), unit(std::max(0.0, low))},
       Behind::kNone, -1, Eigen::Vector2d::Zero());
}

void WindowFront::push(double distance, int index) {
  if (distance <= near_end_) {
    near_.emplace_back(distance, index);
    return;
  }
  far_.emplace_back(distance, index);
  std::push_heap(far_.begin(), far_.end(), std::greater<>());
}

}  // namespace handgraft::geometry
