#include "core/contact/axis.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/straight_way.h"
#include "core/geometry/tangent_direction.h"

namespace handgraft::contact {
namespace {

using geometry::LogMap;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr int kMostGrowths = 12;  // times 1.5 each

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Some direction that is not the normal at the root, the same for the same mesh.
Eigen::Vector3d referenceAt(const TriangleMesh& mesh, const SurfacePoint& root) {
  int axis = 0;
  normalOf(mesh, root).cwiseAbs().minCoeff(&axis);
  return Eigen::Vector3d::Unit(axis);
}

/// A patch's outline in the tangent plane at its root.
class Outline {
 public:
  Outline(const TriangleMesh& mesh, const Patch& patch)
      : mesh_(mesh), patch_(patch), reference_(referenceAt(mesh, patch.root)) {
    layFlat();
    measure();
  }

  [[nodiscard]] PatchShape shape() const {
    PatchShape shape;
    shape.length_m = high_ - low_;
    shape.width_m = shape.length_m > 0.0 ? area_ / shape.length_m : 0.0;
    shape.long_direction_O =
        turnedDirection(mesh_, patch_.root, reference_, std::atan2(long_T_.y(), long_T_.x()));
    return shape;
  }

  /// From the root to the end in the long direction, and to the other end.
  [[nodiscard]] double ahead() const { return high_; }

  [[nodiscard]] double behind() const { return -low_; }

  /// The middle of the widest part of the slice at `along` of the long direction.
  [[nodiscard]] std::optional<SurfacePoint> middleAt(double along) const {
    const Eigen::Vector2d side_T(-long_T_.y(), long_T_.x());
    std::vector<double> cuts;
    for (std::size_t i = 0; i < points_T_.size(); ++i) {
      const Eigen::Vector2d& a = points_T_[i];
      const Eigen::Vector2d& b = points_T_[(i + 1) % points_T_.size()];
      const double s_a = long_T_.dot(a) - along;
      const double s_b = long_T_.dot(b) - along;
      if ((s_a < 0.0) == (s_b < 0.0)) continue;
      cuts.push_back(side_T.dot(a + s_a / (s_a - s_b) * (b - a)));
    }
    std::sort(cuts.begin(), cuts.end());
    double widest = 0.0;
    double middle = 0.0;
    for (std::size_t i = 0; i + 1 < cuts.size(); i += 2) {
      if (cuts[i + 1] - cuts[i] <= widest) continue;
      widest = cuts[i + 1] - cuts[i];
      middle = 0.5 * (cuts[i] + cuts[i + 1]);
    }
    if (!(widest > 0.0)) return std::nullopt;
    const auto place = inverse_->at(along * long_T_ + middle * side_T);
    return place.point.valid() ? std::optional(place.point) : std::nullopt;
  }

 private:
  void layFlat() {
    const Eigen::Vector3d p_root = positionOf(mesh_, patch_.root);
    double radius = 2.0 * mesh_.meanEdgeLength();
    for (const SurfacePoint& point : patch_.interpolation_boundary)
      radius = std::max(radius, 1.2 * (positionOf(mesh_, point) - p_root).norm());
    std::size_t reached = 0;
    for (int growth = 0;; ++growth) {
      const LogMap map = computeLogMap(mesh_, patch_.root, reference_, radius);
      points_T_.clear();
      for (const SurfacePoint& point : patch_.interpolation_boundary) {
        const Eigen::Vector2d uv = logCoordinates(mesh_, map, point);
        if (uv.allFinite()) points_T_.push_back(uv);
      }
      const bool complete = points_T_.size() == patch_.interpolation_boundary.size();
      const bool exhausted = growth > 0 && map.vertices.size() == reached;
      if (complete || exhausted || growth == kMostGrowths) {
        inverse_.emplace(mesh_, map);
        break;
      }
      reached = map.vertices.size();
      radius *= 1.5;
    }
    if (points_T_.size() < kFewestInterpolationPoints) {
      rejectInput("patch {}: only {} of its {} boundary points can be reached from the root",
                  quoted(patch_.name), points_T_.size(), patch_.interpolation_boundary.size());
    }
  }

  /// The long direction: of the largest second moment of the outline's area.
  void measure() {
    double twice_area = 0.0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < points_T_.size(); ++i) {
      const Eigen::Vector2d& a = points_T_[i];
      const Eigen::Vector2d& b = points_T_[(i + 1) % points_T_.size()];
      const double c = cross(a, b);  // the triangle from the root, doubled
      const Eigen::Vector2d sum = a + b;
      twice_area += c;
      first += c / 3.0 * sum;
      second += c / 12.0 * (a * a.transpose() + b * b.transpose() + sum * sum.transpose());
    }
    area_ = 0.5 * std::abs(twice_area);
    if (twice_area != 0.0) {
      const Eigen::Vector2d centre = first / twice_area;
      second = second / twice_area - centre * centre.transpose();
    }
    long_T_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(second).eigenvectors().col(1);
    if (!long_T_.allFinite()) long_T_ = Eigen::Vector2d::UnitX();
    low_ = high_ = 0.0;
    for (const Eigen::Vector2d& p : points_T_) {
      low_ = std::min(low_, long_T_.dot(p));
      high_ = std::max(high_, long_T_.dot(p));
    }
    // Not a matter of the solver's sign: the farther end is ahead.
    if (-low_ > high_) {
      long_T_ = -long_T_;
      std::swap(low_, high_);
      low_ = -low_;
      high_ = -high_;
    }
  }

  const TriangleMesh& mesh_;
  const Patch& patch_;
  Eigen::Vector3d reference_;
  std::vector<Eigen::Vector2d> points_T_;
  std::optional<geometry::LogMapInverse> inverse_;
  Eigen::Vector2d long_T_ = Eigen::Vector2d::UnitX();
  double low_ = 0.0;
  double high_ = 0.0;
  double area_ = 0.0;
};

/// Middles of slices from the root outwards, as far as each can be walked to from the last.
std::vector<SurfacePoint> knotsTowards(const TriangleMesh& mesh,
                                       const Patch& patch,
                                       const Outline& outline,
                                       double end,
                                       double width) {
  std::vector<SurfacePoint> knots;
  // The end knot stands half a width before the end; none nearer than a quarter to the root.
  const double way = std::abs(end) - 0.5 * width;
  if (way < 0.25 * width) return knots;
  const int count = static_cast<int>(std::ceil(way / width));
  SurfacePoint last = patch.root;
  for (int k = 1; k <= count; ++k) {
    const auto knot = outline.middleAt(std::copysign(way * k / count, end));
    if (!knot || !straightWayTo(mesh, last, referenceAt(mesh, last), *knot)) break;
    knots.push_back(*knot);
    last = *knot;
  }
  return knots;
}

void validate(const AxisOptions& options) {
  if (!(options.shortest_m > 0.0)) {
    rejectInput("shortest patch with an axis is {} m; it must be above 0", options.shortest_m);
  }
  if (!(options.slenderness > 0.0)) {
    rejectInput("slenderness of a patch with an axis is {}; it must be above 0",
                options.slenderness);
  }
}

}  // namespace

PatchShape shapeOf(const TriangleMesh& mesh, const Patch& patch) {
  validate(mesh, patch);
  return Outline(mesh, patch).shape();
}

std::vector<SurfacePoint> makeAxis(const TriangleMesh& mesh,
                                   const Patch& patch,
                                   const AxisOptions& options) {
  validate(options);
  validate(mesh, patch);
  const Outline outline(mesh, patch);
  const PatchShape shape = outline.shape();
  if (!(shape.length_m > options.shortest_m) ||
      !(shape.length_m > options.slenderness * shape.width_m)) {
    return {};
  }
  // Of a sliver, knots a fiftieth of its length apart are plenty.
  const double width = std::max(shape.width_m, 0.02 * shape.length_m);
  std::vector<SurfacePoint> axis = knotsTowards(mesh, patch, outline, -outline.behind(), width);
  std::reverse(axis.begin(), axis.end());
  axis.push_back(patch.root);
  for (const SurfacePoint& knot : knotsTowards(mesh, patch, outline, outline.ahead(), width))
    axis.push_back(knot);
  return axis.size() >= kFewestAxisKnots ? axis : std::vector<SurfacePoint>();
}

}  // namespace handgraft::contact
