#include "core/manipulation/patch_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/tangent.h"

namespace handgraft::manipulation {

namespace {

using contact::Patch;
using geometry::SurfacePoint;

constexpr int kWayPlaces = 65;
constexpr double kReachShare = 1.2;   // of a patch's own reach: how far its log map goes
constexpr double kLeastReach = 1e-3;  // m

Eigen::Vector3d directionOf(const Patch& patch) {
  if (!patch.direction_O)
    rejectInput("patch {}: has no direction; a patch that moves needs one", quoted(patch.name));
  return *patch.direction_O;
}

double reachOf(const geometry::TriangleMesh& mesh, const Patch& patch) {
  const Eigen::Vector3d root = positionOf(mesh, patch.root);
  double reach = kLeastReach;
  for (const SurfacePoint& point : patch.interpolation_boundary)
    reach = std::max(reach, (positionOf(mesh, point) - root).norm());
  return reach;
}

/// The outline about the root, x along the direction; points that the log map does not reach
/// as the tangent plane sees them.
Eigen::Matrix2Xd outlineOf(const geometry::TriangleMesh& mesh, const Patch& patch) {
  const Eigen::Vector3d direction = directionOf(patch);
  const geometry::LogMap map = geometry::computeLogMap(
      mesh, patch.root, direction, 2.0 * reachOf(mesh, patch), geometry::LogMapMethod::kAuto);
  const Eigen::Vector3d n = normalOf(mesh, patch.root);
  const Eigen::Vector3d x = (direction - direction.dot(n) * n).normalized();
  const Eigen::Vector3d root = positionOf(mesh, patch.root);
  Eigen::Matrix2Xd outline(2, static_cast<Eigen::Index>(patch.interpolation_boundary.size()));
  for (std::size_t i = 0; i < patch.interpolation_boundary.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    outline.col(column) = logCoordinates(mesh, map, patch.interpolation_boundary[i]);
    if (outline.col(column).allFinite()) continue;
    const Eigen::Vector3d arm = positionOf(mesh, patch.interpolation_boundary[i]) - root;
    outline.col(column) = Eigen::Vector2d(arm.dot(x), arm.dot(n.cross(x)));
  }
  return outline;
}

/// Lays an outline about a root.
void layOutline(const geometry::TriangleMesh& mesh,
                const geometry::SurfaceLocator& locator,
                const Eigen::Matrix2Xd& outline_T,
                Patch& patch) {
  const double reach = outline_T.cols() == 0 ? 0.0 : outline_T.colwise().norm().maxCoeff();
  const geometry::LogMap map = geometry::computeLogMap(
      mesh, patch.root, *patch.direction_O, std::max(kLeastReach, kReachShare * reach),
      geometry::LogMapMethod::kAuto);
  const geometry::LogMapInverse inverse_map(mesh, map);
  const Eigen::Vector3d n = normalOf(mesh, patch.root);
  const Eigen::Vector3d x = *patch.direction_O;
  const Eigen::Vector3d root = positionOf(mesh, patch.root);
  patch.interpolation_boundary.clear();
  patch.boundary.clear();
  for (Eigen::Index i = 0; i < outline_T.cols(); ++i) {
    const Eigen::Vector2d uv = outline_T.col(i);
    const auto place = inverse_map.at(uv);
    patch.interpolation_boundary.push_back(
        place.point.valid() ? place.point
                            : locator.nearest(root + uv.x() * x + uv.y() * n.cross(x)).point);
  }
}

double turnAbout(const Eigen::Vector3d& n, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(n.dot(a.cross(b)), a.dot(b));
}

}  // namespace

PatchPath::PatchPath(const geometry::TriangleMesh& mesh, const Patch& from, const Patch& to)
    : mesh_(mesh), from_(from), to_(to), locator_(mesh) {
  if (from.interpolation_boundary.size() != to.interpolation_boundary.size()) {
    rejectInput("patch {}: has {} points at first and {} at last; they must be as many",
                quoted(from.name), from.interpolation_boundary.size(),
                to.interpolation_boundary.size());
  }
  from_.direction_O = tangentAt(mesh, from.root, directionOf(from));
  to_.direction_O = tangentAt(mesh, to.root, directionOf(to));
  if (!from_.direction_O || !to_.direction_O)
    rejectInput("patch {}: its direction is its normal", quoted(from.name));
  from_T_ = outlineOf(mesh, from_);
  to_T_ = outlineOf(mesh, to_);

  // === The way of the root: a ray from the first one
  const geometry::LogMap map = geometry::computeLogMap(mesh, from_.root, *from_.direction_O,
                                                       std::numeric_limits<double>::infinity(),
                                                       geometry::LogMapMethod::kFast);
  way_T_ = logCoordinates(mesh, map, to_.root);
  if (!way_T_.allFinite())
    rejectInput("patch {}: no way over the surface leads from its first root to its last",
                quoted(from.name));
  const geometry::LogMapInverse inverse_map(mesh, map);
  const Eigen::Vector3d first = positionOf(mesh, from_.root);
  const Eigen::Vector3d last = positionOf(mesh, to_.root);
  for (int i = 0; i < kWayPlaces; ++i) {
    const double share = static_cast<double>(i) / (kWayPlaces - 1);
    if (i == 0) {
      way_.push_back(from_.root);
    } else if (i == kWayPlaces - 1) {
      way_.push_back(to_.root);
    } else {
      const auto place = inverse_map.at(share * way_T_);
      way_.push_back(place.point.valid()
                         ? place.point
                         : locator_.nearest((1.0 - share) * first + share * last).point);
    }
  }

  // === The direction keeps its angle to the way; what is left at the end is turned by and by
  if (length() < 1e-9) {
    turn_rad_ = turnAbout(normalOf(mesh, to_.root), *from_.direction_O, *to_.direction_O);
    return;
  }
  const double angle = std::atan2(way_T_.y(), way_T_.x());
  const Eigen::Vector3d carried = tangentTurned(mesh, to_.root, headingAt(1.0), -angle);
  turn_rad_ = turnAbout(normalOf(mesh, to_.root), carried, *to_.direction_O);
}

SurfacePoint PatchPath::rootAt(double share) const {
  const double at = share * (kWayPlaces - 1);
  const int i = std::clamp(static_cast<int>(at), 0, kWayPlaces - 2);
  const double rest = at - i;
  const auto index = static_cast<std::size_t>(i);
  if (rest < 1e-9) return way_[index];
  if (rest > 1.0 - 1e-9) return way_[index + 1];
  return locator_
      .nearest((1.0 - rest) * positionOf(mesh_, way_[index]) +
               rest * positionOf(mesh_, way_[index + 1]))
      .point;
}

Eigen::Vector3d PatchPath::headingAt(double share) const {
  const SurfacePoint here = rootAt(share);
  const double step = 0.5 / (kWayPlaces - 1);
  // Ahead, and behind at the end: across an edge the tangent plane tells.
  const bool at_end = share + step > 1.0;
  const Eigen::Vector3d way =
      at_end ? positionOf(mesh_, here) - positionOf(mesh_, rootAt(share - step))
             : positionOf(mesh_, rootAt(share + step)) - positionOf(mesh_, here);
  const auto tangent = tangentAt(mesh_, here, way);
  return tangent ? *tangent : anyTangentAt(mesh_, here);
}

Patch PatchPath::at(double share) const {
  const double s = std::clamp(share, 0.0, 1.0);
  if (s == 0.0) return from_;
  if (s == 1.0) return to_;
  Patch patch = s < 0.5 ? from_ : to_;
  patch.name = from_.name;
  patch.weight = (1.0 - s) * from_.weight + s * to_.weight;
  patch.root = rootAt(s);
  if (length() < 1e-9) {
    patch.direction_O = tangentTurned(mesh_, patch.root, *from_.direction_O, s * turn_rad_);
  } else {
    const double angle = std::atan2(way_T_.y(), way_T_.x());
    patch.direction_O = tangentTurned(mesh_, patch.root, headingAt(s), s * turn_rad_ - angle);
  }
  layOutline(mesh_, locator_, (1.0 - s) * from_T_ + s * to_T_, patch);
  return patch;
}

Patch slid(const geometry::TriangleMesh& mesh,
           const Patch& patch,
           const Eigen::Vector2d& shift_T) {
  const auto direction = tangentAt(mesh, patch.root, directionOf(patch));
  if (!direction) rejectInput("patch {}: its direction is its normal", quoted(patch.name));
  Patch own = patch;
  own.direction_O = direction;
  const Eigen::Matrix2Xd outline_T = outlineOf(mesh, own);
  const geometry::LogMap map = geometry::computeLogMap(
      mesh, own.root, *direction, std::max(kLeastReach, kReachShare * shift_T.norm()),
      geometry::LogMapMethod::kAuto);
  const geometry::LogMapInverse inverse_map(mesh, map);
  const auto place = inverse_map.at(shift_T);
  if (!place.point.valid()) {
    rejectInput("patch {}: no surface {:.1f} mm from its root ({})", quoted(patch.name),
                1e3 * shift_T.norm(), std::string(reasonOf(place.reason)));
  }
  own.root = place.point;
  own.direction_O = tangentCarried(mesh, patch.root, own.root, *direction);
  layOutline(mesh, geometry::SurfaceLocator(mesh), outline_T, own);
  return own;
}

}  // namespace handgraft::manipulation
