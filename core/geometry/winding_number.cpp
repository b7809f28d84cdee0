#include "core/geometry/winding_number.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include "core/geometry/wide.h"

namespace handgraft::geometry {

namespace {

constexpr int kLeafFaces = 8;
constexpr double kFar = 2.0;  // radii; Barill et al. use 2, too

Eigen::Vector3d areaVector(const Eigen::Matrix3d& corners) {
  return 0.5 * (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
}

/// Four numbers in memory, moved whole: what is written in halves and read whole just after
/// waits for both.
using StoredLanes = double __attribute__((vector_size(32), aligned(8), may_alias));

}  // namespace

/// Four sums of angles, each angle within half a turn either way: as the argument of the
/// product of complex numbers, so that one arctangent does for many of them.
struct WindingNumber::Angles {
  double x[4] = {1.0, 1.0, 1.0, 1.0};
  double y[4] = {};
  double turns[4] = {};

  [[nodiscard]] double sum() const {
    double angles = 0.0;
    for (int i = 0; i < 4; ++i)
      angles += std::atan2(y[i], x[i]) + 2.0 * std::numbers::pi * turns[i];
    return angles;
  }
};

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  std::vector<Piece> pieces = piecesOf(mesh);
  Corners corners;
  corners.reserve(static_cast<std::size_t>(mesh.faceCount()));
  if (!pieces.empty()) buildPieces(pieces, 0, static_cast<int>(pieces.size()), corners);
  pack(corners);
}

std::vector<WindingNumber::Piece> WindingNumber::piecesOf(const TriangleMesh& mesh) {
  const auto [component_of, count] = mesh.components();
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const int component = component_of[face[0]];
    Eigen::Matrix3d corners;
    for (int i = 0; i < 3; ++i)
      corners.col(i) = mesh.vertex(face[i]);
    Piece& piece = pieces[component];
    for (int i = 0; i < 3; ++i)
      piece.box.extend(corners.col(i));
    piece.corners.push_back(corners);
    for (int h = 3 * f; h < 3 * f + 3; ++h)
      piece.is_closed = piece.is_closed && mesh.twin(h) >= 0;
  }
  // Vertices without faces.
  std::erase_if(pieces, [](const Piece& piece) {
    return piece.corners.empty();
  });
  return pieces;
}

int WindingNumber::buildPieces(std::vector<Piece>& pieces,
                               int begin,
                               int end,
                               Corners& corners) {
  const auto first = static_cast<int>(corners.size());
  if (end - begin == 1) {
    const Piece& piece = pieces[begin];
    corners.insert(corners.end(), piece.corners.begin(), piece.corners.end());
    const int index = build(first, static_cast<int>(corners.size()), corners);
    nodes_[index].is_closed = piece.is_closed;
    nodes_[index].box = piece.box;
    return index;
  }
  Eigen::AlignedBox3d centres;
  for (int i = begin; i < end; ++i)
    centres.extend(pieces[i].box.center());
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(pieces.begin() + begin, pieces.begin() + middle, pieces.begin() + end,
                   [axis](const Piece& a, const Piece& b) {
                     return a.box.center()[axis] < b.box.center()[axis];
                   });
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  const int left = buildPieces(pieces, begin, middle, corners);
  Node node;
  node.right = buildPieces(pieces, middle, end, corners);
  node.begin = first;
  node.end = static_cast<int>(corners.size());
  measure(corners, node);
  node.is_closed = nodes_[left].is_closed && nodes_[node.right].is_closed;
  node.box = nodes_[left].box.merged(nodes_[node.right].box);
  nodes_[index] = node;
  return index;
}

void WindingNumber::measure(const Corners& corners, Node& node) {
  Eigen::AlignedBox3d box;
  double area = 0.0;
  for (int f = node.begin; f < node.end; ++f) {
    const Eigen::Vector3d vector = areaVector(corners[f]);
    const Eigen::Vector3d middle = corners[f].rowwise().mean();
    box.extend(middle);
    node.dipole += vector;
    node.centre += vector.norm() * middle;
    area += vector.norm();
  }
  node.centre = area > 0.0 ? Eigen::Vector3d(node.centre / area) : box.center();
  for (int f = node.begin; f < node.end; ++f)
    node.radius =
        std::max(node.radius, (corners[f].colwise() - node.centre).colwise().norm().maxCoeff());
}

int WindingNumber::build(int begin, int end, Corners& corners) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.begin = begin;
  node.end = end;
  measure(corners, node);
  if (end - begin > kLeafFaces) {
    Eigen::AlignedBox3d middles;
    for (int f = begin; f < end; ++f)
      middles.extend(Eigen::Vector3d(corners[f].rowwise().mean()));
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(corners.begin() + begin, corners.begin() + middle, corners.begin() + end,
                     [axis](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
                       return a.row(axis).sum() < b.row(axis).sum();
                     });
    build(begin, middle, corners);
    node.right = build(middle, end, corners);
  }
  nodes_[index] = node;
  return index;
}

WindingNumber::Four WindingNumber::fourOf(const Corners& corners, int begin, int end) {
  Four four{};
  for (int lane = 0; lane < 4; ++lane) {
    // What fills up the last ones is one point and has no angle.
    const bool fills = begin + lane >= end;
    const Eigen::Matrix3d& face = corners[fills ? begin : begin + lane];
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        four.at[corner][axis][lane] = face(axis, fills ? 0 : corner);
  }
  return four;
}

void WindingNumber::pack(const Corners& corners) {
  for (Node& node : nodes_) {
    if (node.right >= 0) continue;
    const auto first = static_cast<int>(fours_.size());
    for (int f = node.begin; f < node.end; f += 4)
      fours_.push_back(fourOf(corners, f, node.end));
    node.begin = first;
    node.end = static_cast<int>(fours_.size());
  }
}

/// Adds half the solid angles of faces seen from `p`, positive from inside.
HANDGRAFT_WIDE void WindingNumber::addHalves(const Four* begin,
                                             const Four* end,
                                             const Eigen::Vector3d& p,
                                             Angles& angles) {
  const Lanes zero = {};
  const Lanes one = {1.0, 1.0, 1.0, 1.0};
  Lanes sum_x = *reinterpret_cast<const StoredLanes*>(angles.x);
  Lanes sum_y = *reinterpret_cast<const StoredLanes*>(angles.y);
  Lanes turns = *reinterpret_cast<const StoredLanes*>(angles.turns);
  for (const Four* four = begin; four != end; ++four) {
    Lanes way[3][3];
    Lanes length[3];
    for (int corner = 0; corner < 3; ++corner) {
      for (int axis = 0; axis < 3; ++axis)
        way[corner][axis] =
            *reinterpret_cast<const StoredLanes*>(four->at[corner][axis]) - p[axis];

      const Lanes* w = way[corner];
      const Lanes squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
      for (int lane = 0; lane < 4; ++lane)
        length[corner][lane] = std::sqrt(squared[lane]);
    }
    const auto& [a, b, c] = way;
    const Lanes size = length[0] * length[1] * length[2];
    const Lanes below = size + (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * length[2] +
                        (b[0] * c[0] + b[1] * c[1] + b[2] * c[2]) * length[0] +
                        (c[0] * a[0] + c[1] * a[1] + c[2] * a[2]) * length[1];
    const Lanes across = a[0] * (b[1] * c[2] - b[2] * c[1]) +
                         a[1] * (b[2] * c[0] - b[0] * c[2]) +
                         a[2] * (b[0] * c[1] - b[1] * c[0]);
    // Scaled, lest the product leave what a double holds. On a corner there is no angle.
    const Lanes scale = one / (size == 0.0 ? one : size);
    const Lanes y = scale * across;
    Lanes x = scale * below;
    x = x == 0.0 && y == 0.0 ? one : x;
    const Lanes turned = sum_x * y + sum_y * x + 0.0;  // no zero below 0
    // Two angles of one sign whose sum has the other one went past half a turn.
    turns += sum_y >= 0.0 && y >= 0.0 && turned < 0.0 ? one : zero;
    turns -= sum_y < 0.0 && y < 0.0 && turned >= 0.0 ? one : zero;
    sum_x = sum_x * x - sum_y * y;
    sum_y = turned;
  }
  const Lanes wide = sum_x < 0.0 ? -sum_x : sum_x;
  const Lanes high = sum_y < 0.0 ? -sum_y : sum_y;
  const Lanes larger = wide < high ? high : wide;
  const Lanes scale = one / (larger == 0.0 ? one : larger);
  sum_x *= scale;
  sum_y *= scale;
  *reinterpret_cast<StoredLanes*>(angles.x) = sum_x;
  *reinterpret_cast<StoredLanes*>(angles.y) = sum_y;
  *reinterpret_cast<StoredLanes*>(angles.turns) = turns;
}

double WindingNumber::at(const Eigen::Vector3d& p) const {
  if (nodes_.empty()) return 0.0;
  Angles halves;     // of solid angles
  double sum = 0.0;  // of the others'
  int waiting[64];   // each level leaves one node waiting: 64 hold any mesh
  int count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const int index = waiting[--count];
    const Node& node = nodes_[index];
    if (node.is_closed && !node.box.contains(p)) continue;
    const Eigen::Vector3d way = node.centre - p;
    const double distance_squared = way.squaredNorm();
    if (distance_squared > kFar * kFar * node.radius * node.radius) {
      sum += node.dipole.dot(way) / (distance_squared * std::sqrt(distance_squared));
    } else if (node.right < 0) {
      addHalves(fours_.data() + node.begin, fours_.data() + node.end, p, halves);
    } else {
      waiting[count++] = node.right;
      waiting[count++] = index + 1;
    }
  }
  return (2.0 * halves.sum() + sum) / (4.0 * std::numbers::pi);
}

}  // namespace handgraft::geometry
