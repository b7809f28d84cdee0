#include "core/quality/wall_penetration.h"

#include <algorithm>
#include <limits>

namespace handgraft::quality {

namespace {

using Eigen::Vector3d;
using geometry::WallSample;
using hand::LinkSolid;

// m; less is grid's rounding.
constexpr double kThrough = 3e-4;

// m; a contact speaks for the wall so far about it: about a finger's width.
constexpr double kOwnWall = 0.015;

// Cosine; directions that differ by less are one.
constexpr double kSameWay = 0.97;

// m; between looks on the way out.
constexpr double kLeastStep = 2e-4;

/// How far the link reaches from a place inside it.
double reachOf(const LinkSolid& link, const Vector3d& p_L, const Vector3d& way_L) {
  double reach = 0.0;
  while (reach < 2.0 * link.radius) {
    const double distance = link.distance(p_L + reach * way_L);
    if (distance >= 0.0) return std::max(0.0, reach - distance);
    reach += std::max(-distance, kLeastStep);
  }
  return reach;
}

/// The greatest depth of the link in the object and of the walls in the link.
double worstAt(const LinkSolid& link, const geometry::Solid& object_O, const Pose& X_OL) {
  double worst = 0.0;
  link.fine.visit(
      [&](const Vector3d& centre_L, double radius) {
        return object_O.grid().isClear(X_OL * centre_L, radius);
      },
      [&](const hand::SurfaceSample& sample) {
        worst = std::max(worst, -object_O.grid().at(X_OL * sample.p_L));
      });
  const Pose X_LO = inverse(X_OL);
  object_O.walls().visitNear(X_OL * link.centre_L, link.radius, [&](const WallSample& sample) {
    worst = std::max(worst, -link.distance(X_LO * sample.p));
  });
  return worst;
}

double separationAlong(const LinkSolid& link,
                       const geometry::Solid& object_O,
                       const Pose& X_OL,
                       const Vector3d& way_O,
                       double longest) {
  Pose X = X_OL;
  for (double way = 0.0; way < longest;) {
    X.translation() = X_OL.translation() + way * way_O;
    const double worst = worstAt(link, object_O, X);
    if (worst < kLeastStep) return way + worst;
    way += worst;  // no way out is shorter
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

WallPenetration wallPenetration(const LinkSolid& link,
                                const geometry::Walls& walls,
                                const Pose& X_OL) {
  const Pose X_LO = inverse(X_OL);
  WallPenetration found;
  double deepest_through = 0.0;
  walls.visitNear(X_OL * link.centre_L, link.radius, [&](const WallSample& sample) {
    const Vector3d p_L = X_LO * sample.p;
    if (link.grid_L->isClear(p_L, 0.0)) return;
    Vector3d slope_L;
    double depth = -link.distance(p_L, slope_L);
    // The grid rounds the corners of links: it only has to find what may be deepest.
    const double rounding = link.grid_L->spacing();
    if (depth > found.depth_m - rounding && depth > -rounding)
      depth = -link.grid_L->exact().at(p_L).distance - link.skin_offset;
    if (depth > found.depth_m) {
      found.depth_m = depth;
      // The link goes the other way.
      found.slope_O = -(X_OL.linear() * slope_L).normalized();
    }
    if (depth <= std::max(kThrough, deepest_through)) return;
    if (sample.thickness_m > geometry::Walls::kThin) return;
    if (reachOf(link, p_L, -(X_LO.linear() * sample.n)) <= sample.thickness_m + kThrough)
      return;
    deepest_through = depth;
    found.goes_through = true;
    found.p_O = sample.p;
    found.n_O = sample.n;
  });
  return found;
}

double wallSeparation(const LinkSolid& link,
                      const geometry::Solid& object_O,
                      const Pose& X_OL,
                      const WallPenetration& wall,
                      const std::vector<ContactSide>& sides) {
  Vector3d own_side = Vector3d::Zero();
  for (const ContactSide& side : sides) {
    if (side.link != link.link || (side.p_O - wall.p_O).norm() > kOwnWall) continue;
    own_side += side.n_O;
  }
  std::vector<Vector3d> ways;
  const auto consider = [&](const Vector3d& way) {
    if (!(way.norm() > 0.5)) return;
    const bool leads_away = way.dot(own_side) < -0.1 * own_side.norm();
    const bool is_known = std::any_of(ways.begin(), ways.end(), [&](const Vector3d& other) {
      return other.dot(way) > kSameWay;
    });
    if (!leads_away && !is_known) ways.push_back(way);
  };
  consider(wall.n_O);
  consider(-wall.n_O);
  consider(wall.slope_O);
  consider(own_side.normalized());
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3d& way : ways)
    least = std::min(
        least, separationAlong(link, object_O, X_OL, way, std::min(least, 2.0 * link.radius)));
  return least;
}

}  // namespace handgraft::quality
