#include "core/geometry/capsule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace handgraft::geometry {

using Eigen::Vector3d;

Capsule capsuleAround(const Eigen::Matrix3Xd& points) {
  Capsule capsule;
  if (points.cols() == 0) return capsule;
  const Vector3d mean = points.rowwise().mean();
  const Eigen::Matrix3Xd off = points.colwise() - mean;
  // Ascending: the last axis is the longest one.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(off * off.transpose());
  const Eigen::Matrix3Xd own = axes.eigenvectors().transpose() * off;
  const Vector3d middle = 0.5 * (own.rowwise().minCoeff() + own.rowwise().maxCoeff());
  const Eigen::VectorXd across_squared =
      (own.topRows<2>().colwise() - middle.head<2>()).colwise().squaredNorm();
  const double radius_squared = across_squared.maxCoeff();
  // The caps round off what lies near the axis.
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (Eigen::Index i = 0; i < own.cols(); ++i) {
    const double cap = std::sqrt(std::max(0.0, radius_squared - across_squared[i]));
    low = std::min(low, own(2, i) + cap);
    high = std::max(high, own(2, i) - cap);
  }
  // A flat one is a ball, whose caps both ask for room.
  if (low > high) low = high = 0.5 * (low + high);
  const auto on_axis = [&](double along) -> Vector3d {
    return mean + axes.eigenvectors() * Vector3d(middle[0], middle[1], along);
  };
  capsule.a = on_axis(low);
  capsule.b = on_axis(high);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Vector3d p = points.col(i);
    capsule.radius =
        std::max(capsule.radius, std::sqrt(squaredDistance(capsule.a, capsule.b, p, p)));
  }
  return capsule;
}

double squaredDistance(const Vector3d& a,
                       const Vector3d& b,
                       const Vector3d& c,
                       const Vector3d& d) {
  // The square of the distance is convex in both shares of the way: the best share of one
  // segment for the best of the other, each kept on its segment.
  const Vector3d u = b - a;
  const Vector3d v = d - c;
  const Vector3d w = a - c;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double uw = u.dot(w);
  const double vw = v.dot(w);
  const double across = uu * vv - uv * uv;
  double s =
      across > 1e-12 * uu * vv ? std::clamp((uv * vw - vv * uw) / across, 0.0, 1.0) : 0.0;
  double t = vv > 0.0 ? (uv * s + vw) / vv : 0.0;
  if (t < 0.0 || t > 1.0 || vv == 0.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = uu > 0.0 ? std::clamp((uv * t - uw) / uu, 0.0, 1.0) : 0.0;
  }
  return (w + s * u - t * v).squaredNorm();
}

}  // namespace handgraft::geometry
