#include "core/geometry/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handgraft::geometry {

namespace {

constexpr int kLeafFaces = 8;
constexpr double kFar = 2.0;  // radii; Barill et al. use 2, too

/// Solid angle of a triangle seen from the origin, positive from inside.
double solidAngle(const Eigen::Vector3d& a,
                  const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(a.dot(b.cross(c)), below);
}

Eigen::Vector3d areaVector(const Eigen::Matrix3d& corners) {
  return 0.5 * (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    Eigen::Matrix3d corners;
    for (int i = 0; i < 3; ++i)
      corners.col(i) = mesh.vertex(face[i]);
    corners_.push_back(corners);
  }
  if (!corners_.empty()) build(0, static_cast<int>(corners_.size()));
}

int WindingNumber::build(int begin, int end) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.begin = begin;
  node.end = end;
  Eigen::AlignedBox3d box;
  double area = 0.0;
  for (int f = begin; f < end; ++f) {
    const Eigen::Vector3d vector = areaVector(corners_[f]);
    const Eigen::Vector3d middle = corners_[f].rowwise().mean();
    box.extend(middle);
    node.dipole += vector;
    node.centre += vector.norm() * middle;
    area += vector.norm();
  }
  node.centre = area > 0.0 ? Eigen::Vector3d(node.centre / area) : box.center();
  for (int f = begin; f < end; ++f)
    node.radius = std::max(node.radius,
                           (corners_[f].colwise() - node.centre).colwise().norm().maxCoeff());
  if (end - begin > kLeafFaces) {
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(corners_.begin() + begin, corners_.begin() + middle,
                     corners_.begin() + end,
                     [axis](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
                       return a.row(axis).sum() < b.row(axis).sum();
                     });
    build(begin, middle);
    node.right = build(middle, end);
  }
  nodes_[index] = node;
  return index;
}

double WindingNumber::at(const Eigen::Vector3d& p) const {
  if (nodes_.empty()) return 0.0;
  double sum = 0.0;  // of solid angles
  int waiting[64];   // each level leaves one node waiting: 64 hold any mesh
  int count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const int index = waiting[--count];
    const Node& node = nodes_[index];
    const Eigen::Vector3d way = node.centre - p;
    const double distance_squared = way.squaredNorm();
    if (distance_squared > kFar * kFar * node.radius * node.radius) {
      sum += node.dipole.dot(way) / (distance_squared * std::sqrt(distance_squared));
    } else if (node.right < 0) {
      for (int f = node.begin; f < node.end; ++f)
        sum +=
            solidAngle(corners_[f].col(0) - p, corners_[f].col(1) - p, corners_[f].col(2) - p);
    } else {
      waiting[count++] = node.right;
      waiting[count++] = index + 1;
    }
  }
  return sum / (4.0 * std::numbers::pi);
}

}  // namespace handgraft::geometry
