#include "core/geometry/surface_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr int kLeafFaces = 4;

/// A box around the faces [begin, end) of `Tree::order`; inner nodes have their left child next
/// to them and their right child at `right`.
struct Node {
  Eigen::AlignedBox3d box;
  int begin = 0;
  int end = 0;
  int right = -1;

  [[nodiscard]] bool isLeaf() const { return right < 0; }
};

struct Nearest {
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance_squared = std::numeric_limits<double>::infinity();
};

/// The nearest point of one triangle. Its plane counts only if the foot of the perpendicular
/// falls inside; the three edges are always tried, so slivers and zero-area faces need no
/// special case.
Nearest nearestOnTriangle(const Eigen::Vector3d corners[3], const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = corners[1] - corners[0];
  const Eigen::Vector3d ac = corners[2] - corners[0];
  const Eigen::Vector3d ap = p - corners[0];
  const Eigen::Vector3d normal = ab.cross(ac);
  const double normal_squared = normal.squaredNorm();
  Nearest best;

  if (normal_squared > 0.0) {
    const double weight_b = normal.dot(ap.cross(ac)) / normal_squared;
    const double weight_c = normal.dot(ab.cross(ap)) / normal_squared;
    if (weight_b >= 0.0 && weight_c >= 0.0 && weight_b + weight_c <= 1.0) {
      // The sum may round to 1 and the difference below 0.
      best.barycentric = {std::max(0.0, 1.0 - weight_b - weight_c), weight_b, weight_c};
      best.position = corners[0] + weight_b * ab + weight_c * ac;
      best.distance_squared = (p - best.position).squaredNorm();
      // The foot inside a well-shaped face is nearer than its edges; a sliver's weights are
      // noise.
      constexpr double kSliverSine = 1e-6;
      const double sine_squared = normal_squared / (ab.squaredNorm() * ac.squaredNorm());
      if (sine_squared > kSliverSine * kSliverSine) return best;
    }
  }
  for (int corner = 0; corner < 3; ++corner) {
    const int other = (corner + 1) % 3;
    const Eigen::Vector3d edge = corners[other] - corners[corner];
    const double length_squared = edge.squaredNorm();
    const double t =
        length_squared > 0.0
            ? std::clamp((p - corners[corner]).dot(edge) / length_squared, 0.0, 1.0)
            : 0.0;
    const Eigen::Vector3d position =
        t < 1.0 ? Eigen::Vector3d(corners[corner] + t * edge) : corners[other];
    const double distance_squared = (p - position).squaredNorm();
    if (distance_squared < best.distance_squared) {
      best.barycentric.setZero();
      best.barycentric[corner] = 1.0 - t;
      best.barycentric[other] = t;
      best.position = position;
      best.distance_squared = distance_squared;
    }
  }
  return best;
}

}  // namespace

struct SurfaceLocator::Tree {
  TriangleMesh mesh;
  std::vector<int> order;  ///< faces, those of one node side by side
  std::vector<Node> nodes;

  explicit Tree(const TriangleMesh& source) : mesh(source) {
    if (mesh.faceCount() == 0) rejectInput("mesh has 0 faces, a surface needs at least 1");
    order.resize(static_cast<std::size_t>(mesh.faceCount()));
    std::iota(order.begin(), order.end(), 0);
    Eigen::Matrix3Xd centres(3, mesh.faceCount());
    for (int f = 0; f < mesh.faceCount(); ++f)
      centres.col(f) = boxOf(f).center();
    nodes.reserve(order.size());
    build(0, mesh.faceCount(), centres);
  }

  [[nodiscard]] Eigen::AlignedBox3d boxOf(int f) const {
    Eigen::AlignedBox3d box(mesh.vertex(mesh.faces()(0, f)));
    box.extend(mesh.vertex(mesh.faces()(1, f)));
    box.extend(mesh.vertex(mesh.faces()(2, f)));
    return box;
  }

  /// Halves by count along the longest side of the centres' box: depth is log2 F whatever the
  /// mesh.
  int build(int begin, int end, const Eigen::Matrix3Xd& centres) {
    const int index = static_cast<int>(nodes.size());
    nodes.emplace_back();
    Eigen::AlignedBox3d box;
    Eigen::AlignedBox3d centre_box;
    for (int i = begin; i < end; ++i) {
      box.extend(boxOf(order[i]));
      centre_box.extend(Eigen::Vector3d(centres.col(order[i])));
    }
    int right = -1;
    if (end - begin > kLeafFaces) {
      int axis = 0;
      centre_box.sizes().maxCoeff(&axis);
      const int middle = begin + (end - begin) / 2;
      std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                       [&](int a, int b) {
                         return std::pair(centres(axis, a), a) < std::pair(centres(axis, b), b);
                       });
      build(begin, middle, centres);
      right = build(middle, end, centres);
    }
    nodes[index] = {box, begin, end, right};
    return index;
  }
};

SurfaceLocator::SurfaceLocator(const TriangleMesh& mesh)
    : tree_(std::make_unique<Tree>(mesh)) {}

SurfaceLocator::~SurfaceLocator() = default;
SurfaceLocator::SurfaceLocator(SurfaceLocator&&) noexcept = default;
SurfaceLocator& SurfaceLocator::operator=(SurfaceLocator&&) noexcept = default;

SurfaceLocator::Hit SurfaceLocator::nearest(const Eigen::Vector3d& p) const {
  const auto hit = nearest(p, std::numeric_limits<double>::infinity());
  if (!hit) rejectInput("query point is ({}, {}, {}), too far from the mesh", p[0], p[1], p[2]);
  return *hit;
}

std::optional<SurfaceLocator::Hit> SurfaceLocator::nearest(const Eigen::Vector3d& p,
                                                           double reach) const {
  if (!p.allFinite()) {
    rejectInput("query point is ({}, {}, {}), coordinates must be finite", p[0], p[1], p[2]);
  }
  Nearest best;
  best.distance_squared = reach * reach;
  int best_face = -1;

  // Depth first, the nearer child first. Each level leaves one node waiting: 64 hold any mesh.
  std::pair<double, int> waiting[64];
  int waiting_count = 0;
  waiting[waiting_count++] = {tree_->nodes[0].box.squaredExteriorDistance(p), 0};
  while (waiting_count > 0) {
    const auto [bound, index] = waiting[--waiting_count];
    if (bound > best.distance_squared) continue;
    const Node& node = tree_->nodes[index];
    if (node.isLeaf()) {
      for (int i = node.begin; i < node.end; ++i) {
        const int f = tree_->order[i];
        const Eigen::Vector3i face = tree_->mesh.face(f);
        const Eigen::Vector3d corners[3] = {tree_->mesh.vertex(face[0]),
                                            tree_->mesh.vertex(face[1]),
                                            tree_->mesh.vertex(face[2])};
        const Nearest candidate = nearestOnTriangle(corners, p);
        if (candidate.distance_squared < best.distance_squared ||
            (candidate.distance_squared == best.distance_squared &&
             (best_face < 0 || f < best_face))) {
          best = candidate;
          best_face = f;
        }
      }
      continue;
    }
    const int left = index + 1;
    const double left_bound = tree_->nodes[left].box.squaredExteriorDistance(p);
    const double right_bound = tree_->nodes[node.right].box.squaredExteriorDistance(p);
    const bool left_first = left_bound <= right_bound;
    waiting[waiting_count++] =
        left_first ? std::pair(right_bound, node.right) : std::pair(left_bound, left);
    waiting[waiting_count++] =
        left_first ? std::pair(left_bound, left) : std::pair(right_bound, node.right);
  }
  // Coordinates so far away that their squares overflow leave every face equally near.
  if (best_face < 0 || !std::isfinite(best.distance_squared)) return std::nullopt;
  return Hit{{best_face, best.barycentric}, best.position, std::sqrt(best.distance_squared)};
}

void SurfaceLocator::facesTouching(const Eigen::AlignedBox3d& box,
                                   std::vector<int>& faces) const {
  faces.clear();
  int waiting[64];
  int waiting_count = 0;
  waiting[waiting_count++] = 0;
  while (waiting_count > 0) {
    const int index = waiting[--waiting_count];
    const Node& node = tree_->nodes[index];
    if (!node.box.intersects(box)) continue;
    if (!node.isLeaf()) {
      waiting[waiting_count++] = node.right;
      waiting[waiting_count++] = index + 1;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i)
      if (tree_->boxOf(tree_->order[i]).intersects(box)) faces.push_back(tree_->order[i]);
  }
}

const TriangleMesh& SurfaceLocator::mesh() const {
  return tree_->mesh;
}

}  // namespace handgraft::geometry
