#include "core/geometry/main_extent.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/Geometry>

namespace handgraft::geometry {

namespace {

/// Of the surface, that may lie beyond the box on each of its sides.
constexpr double kBeyond = 0.005;
/// A box so much shorter than that of everything leaves out what is no part of the thing; tips
/// and handles do less.
constexpr double kMuchShorter = 1.5;

/// Diagonal of the box between the quantiles of the points by `weight`.
double diagonalOfMost(const Eigen::Matrix3Xd& points, const Eigen::VectorXd& weight) {
  std::vector<int> order(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), 0);
  const double beyond = kBeyond * weight.sum();
  Eigen::Vector3d extent;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      return points(axis, a) < points(axis, b);
    });
    const auto end_of = [&](auto begin, auto end) {
      double passed = 0.0;
      for (auto at = begin; at != end; ++at) {
        passed += weight[*at];
        if (passed > beyond) return points(axis, *at);
      }
      return points(axis, *begin);
    };
    extent[axis] = end_of(order.rbegin(), order.rend()) - end_of(order.begin(), order.end());
  }
  return extent.norm();
}

double extentOf(const Eigen::Matrix3Xd& points, const Eigen::VectorXd& weight) {
  if (points.cols() == 0) return 0.0;
  if (!points.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const double whole = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  const double most = diagonalOfMost(points, weight);
  return most > 0.0 && whole > kMuchShorter * most ? most : whole;
}

}  // namespace

double mainExtent(const TriangleMesh& mesh) {
  const Eigen::Matrix3Xd& points = mesh.vertices();
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(points.cols());
  for (int face = 0; face < mesh.faceCount(); ++face) {
    const auto corners = mesh.face(face);
    const Eigen::Vector3d a = points.col(corners[0]);
    const double area =
        0.5 * (points.col(corners[1]) - a).cross(points.col(corners[2]) - a).norm();
    for (const int corner : corners)
      weight[corner] += area / 3.0;
  }
  if (!(weight.sum() > 0.0)) weight.setOnes();
  return extentOf(points, weight);
}

double mainExtent(const Eigen::Matrix3Xd& points) {
  return extentOf(points, Eigen::VectorXd::Ones(points.cols()));
}

}  // namespace handgraft::geometry
