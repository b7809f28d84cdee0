#include "core/quality/penetration.h"

#include <algorithm>
#include <cmath>

namespace handgraft::quality {

namespace {

using Eigen::Vector3d;
using geometry::DistanceGrid;
using hand::LinkSolid;

// A depth below it is rounding of a touch.
constexpr double kTouch = 1e-6;  // m

/// Sums over what lies inside.
struct Inside {
  double area = 0.0;
  double depth_area = 0.0;
};

/// Calls `take(sample, p_O, guess)` for what of a link is not far outside; the grid's guess
/// rounds edges by half a spacing.
template <class Take>
void visitNear(const LinkSolid& solid,
               const DistanceGrid& object_O,
               const Pose& X_OL,
               const Take& take) {
  const Eigen::Matrix3d R_OL = X_OL.linear();
  const Vector3d p_OL = X_OL.translation();
  solid.fine.visit(
      [&](const Vector3d& centre_L, double radius) {
        return object_O.isClear(p_OL + R_OL.lazyProduct(centre_L), radius);
      },
      [&](const hand::SurfaceSample& sample) {
        const Vector3d p_O = p_OL + R_OL.lazyProduct(sample.p_L);
        if (object_O.isClear(p_O, object_O.spacing())) return;
        const double guess = object_O.at(p_O);
        if (guess <= object_O.spacing()) take(sample, p_O, guess);
      });
}

/// How deep a place lies in the object, exact; 0 if not deeper than `least`.
double depthAt(const Vector3d& p_O,
               double guess,
               double least,
               const DistanceGrid& object_O,
               const Progress& progress) {
  progress.checkpoint();
  const double depth = object_O.exact().distance(p_O);
  if (depth <= std::max(least, kTouch)) return 0.0;
  // So far inside that the exact sign, which costs as much again, is known.
  const bool is_inside = guess < -2.0 * object_O.spacing() || object_O.exact().contains(p_O);
  return is_inside ? depth : 0.0;
}

/// The deepest of a link's samples, and sums over all that lie inside.
double depthOfAll(const LinkSolid& solid,
                  const DistanceGrid& object_O,
                  const Pose& X_OL,
                  Inside& inside,
                  const Progress& progress) {
  double deepest = 0.0;
  visitNear(solid, object_O, X_OL,
            [&](const hand::SurfaceSample& sample, const Vector3d& p_O, double guess) {
              const double depth = depthAt(p_O, guess, 0.0, object_O, progress);
              if (depth <= 0.0) return;
              deepest = std::max(deepest, depth);
              inside.area += sample.area_m2;
              inside.depth_area += sample.area_m2 * depth;
            });
  return deepest;
}

/// The deepest of a link's samples; 0 if none is deeper than `least`. Of most of them the grid
/// tells that they are not, once one is known that is deep.
double depthOfDeepest(const LinkSolid& solid,
                      const DistanceGrid& object_O,
                      const Pose& X_OL,
                      double least,
                      const Progress& progress) {
  struct Near {
    Vector3d p_O;
    double guess;
  };

  std::vector<Near> near;
  visitNear(solid, object_O, X_OL,
            [&](const hand::SurfaceSample&, const Vector3d& p_O, double guess) {
              near.push_back({p_O, guess});
            });
  std::stable_sort(near.begin(), near.end(), [](const Near& a, const Near& b) {
    return a.guess < b.guess;
  });
  double deepest = 0.0;
  for (const Near& one : near) {
    const double known = std::max({deepest, least, kTouch});
    if (object_O.atLeast(one.p_O) >= -known) continue;
    deepest = std::max(deepest, depthAt(one.p_O, one.guess, known, object_O, progress));
  }
  return deepest;
}

/// The same where the object's walls are thinner than the link; `depth` if that is more.
double withWalls(double depth,
                 const LinkSolid& solid,
                 const geometry::Solid& object_O,
                 const Pose& X_OL,
                 const std::vector<ContactSide>& sides,
                 const Progress& progress) {
  const WallPenetration wall = wallPenetration(solid, object_O.walls(), X_OL);
  if (wall.depth_m > kTouch) depth = std::max(depth, wall.depth_m);
  progress.checkpoint();
  if (wall.goes_through) {
    const double way = wallSeparation(solid, object_O, X_OL, wall, sides);
    if (std::isfinite(way)) depth = std::max(depth, way);
  }
  return depth;
}

/// How much of a cell lies in two solids, of which it lies in each by `a` and `b`, and whose
/// borders' normals have the cosine `c`: planes that face each other share what is more than
/// the whole cell, planes alike the less of both, planes at right angles the product.
double sharedBy(double a, double b, double c) {
  const double facing = c < 0.0 ? std::max(0.0, a + b - 1.0) : std::min(a, b);
  return a * b + std::min(1.0, std::abs(c)) * (facing - a * b);
}

/// What the link and the object both fill, and how deep in both one place of it lies.
struct Shared {
  double volume_m3 = 0.0;
  double depth_m = 0.0;
};

Shared sharedWith(const LinkSolid& solid, const DistanceGrid& object_O, const Pose& X_OL) {
  // A plane is shared out over one cell's width, whichever way it lies.
  const double h = solid.grid_L->spacing();
  const Eigen::Matrix3d R_OL = X_OL.linear();
  const Vector3d p_OL = X_OL.translation();
  Shared shared;
  // Cells lie in rows: one that is far off says as much of those beside it.
  Vector3d clear_L = Vector3d::Zero();
  double clear_m = 0.0;
  for (const DistanceGrid::Cell& cell : solid.cells_L) {
    if ((cell.p - clear_L).squaredNorm() < clear_m * clear_m) continue;
    const Vector3d p_O = p_OL + R_OL * cell.p;
    const double clearance = object_O.clearance(p_O, 0.5 * h, 0.0);
    if (clearance > 0.0) {
      clear_L = cell.p;
      clear_m = clearance;
      continue;
    }
    const double distance = object_O.at(p_O);
    const double inside = std::min(1.0, 0.5 - distance / h);
    if (inside <= 0.0) continue;
    if (cell.share == 1.0 && -distance > shared.depth_m)
      shared.depth_m = std::max(shared.depth_m, std::min(-distance, -solid.distance(cell.p)));
    if (cell.share == 1.0 || inside == 1.0) {
      shared.volume_m3 += cell.share * inside;
      continue;
    }
    Vector3d slope_O;
    Vector3d slope_L;
    static_cast<void>(object_O.at(p_O, slope_O));
    static_cast<void>(solid.grid_L->at(cell.p, slope_L));
    shared.volume_m3 += sharedBy(cell.share, inside, slope_O.dot(R_OL * slope_L));
  }
  shared.volume_m3 *= h * h * h;
  return shared;
}

/// The deepest pair of links in each other, if any.
struct SelfDepth {
  double depth_m = 0.0;
  std::array<int, 2> links = {-1, -1};
};

SelfDepth measureItself(const hand::HandSolid& hand, const hand::LinkPoses& X_OL) {
  SelfDepth result;
  for (const auto& [i, j] : hand.collisionPairs()) {
    const LinkSolid& a = hand.links()[static_cast<std::size_t>(i)];
    const LinkSolid& b = hand.links()[static_cast<std::size_t>(j)];
    const Pose& X_OA = X_OL[static_cast<std::size_t>(a.link)];
    const Pose& X_OB = X_OL[static_cast<std::size_t>(b.link)];
    if ((X_OA * a.centre_L - X_OB * b.centre_L).norm() > a.radius + b.radius) continue;
    const Pose X_BA = inverse(X_OB) * X_OA;
    const double depth = std::max(depthOf(a, b, X_BA), depthOf(b, a, inverse(X_BA)));
    if (depth > std::max(kTouch, result.depth_m)) result = {depth, {a.link, b.link}};
  }
  return result;
}

}  // namespace

Penetration measurePenetration(const hand::HandModel& model,
                               const hand::HandSolid& hand,
                               const geometry::Solid& object_O,
                               const Pose& X_WO,
                               const hand::HandPose& pose,
                               const std::vector<ContactSide>& sides,
                               const Progress& progress) {
  hand::LinkPoses X_OL;
  hand::forwardKinematics(model, inverse(X_WO) * pose.X_WH, pose.q, X_OL);
  Penetration result;
  Inside inside;
  for (const LinkSolid& solid : hand.links()) {
    const Pose& X = X_OL[static_cast<std::size_t>(solid.link)];
    if (object_O.grid().isClear(X * solid.centre_L, solid.radius)) continue;
    const double at_surface = withWalls(depthOfAll(solid, object_O.grid(), X, inside, progress),
                                        solid, object_O, X, sides, progress);
    progress.checkpoint();
    const Shared shared = sharedWith(solid, object_O.grid(), X);
    result.volume_m3 += shared.volume_m3;
    // An object within a link, where none of the link's surface is in it.
    const double depth = std::max(at_surface, shared.depth_m);
    if (depth > 0.0) result.links.push_back({solid.link, depth});
  }
  std::stable_sort(result.links.begin(), result.links.end(),
                   [](const LinkDepth& a, const LinkDepth& b) {
                     return a.depth_m > b.depth_m;
                   });
  if (!result.links.empty()) result.max_depth_m = result.links.front().depth_m;
  if (inside.area > 0.0) result.mean_depth_m = inside.depth_area / inside.area;
  const SelfDepth self = measureItself(hand, X_OL);
  result.self_depth_m = self.depth_m;
  result.self_links = self.links;
  return result;
}

Depths deeperOf(const Depths& a, const Depths& b) {
  return {std::max(a.object_m, b.object_m), std::max(a.self_m, b.self_m)};
}

namespace {

double depthOfLinks(const hand::HandSolid& hand,
                    const geometry::Solid& object_O,
                    const hand::LinkPoses& X_OL,
                    const Progress& progress,
                    const std::vector<ContactSide>& sides) {
  double deepest = 0.0;
  for (const LinkSolid& solid : hand.links()) {
    const Pose& X = X_OL[static_cast<std::size_t>(solid.link)];
    if (object_O.grid().isClear(X * solid.centre_L, solid.radius)) continue;
    const double here = depthOfDeepest(solid, object_O.grid(), X, deepest, progress);
    deepest = withWalls(std::max(deepest, here), solid, object_O, X, sides, progress);
  }
  return deepest;
}

}  // namespace

double measureDepth(const hand::HandModel& model,
                    const hand::HandSolid& hand,
                    const geometry::Solid& object_O,
                    const hand::HandPose& X_OH,
                    const Progress& progress,
                    const std::vector<ContactSide>& sides) {
  hand::LinkPoses X_OL;
  hand::forwardKinematics(model, X_OH.X_WH, X_OH.q, X_OL);
  return depthOfLinks(hand, object_O, X_OL, progress, sides);
}

Depths measureDepths(const hand::HandModel& model,
                     const hand::HandSolid& hand,
                     const geometry::Solid& object_O,
                     const hand::HandPose& X_OH,
                     const Progress& progress,
                     const std::vector<ContactSide>& sides) {
  hand::LinkPoses X_OL;
  hand::forwardKinematics(model, X_OH.X_WH, X_OH.q, X_OL);
  return {depthOfLinks(hand, object_O, X_OL, progress, sides),
          measureItself(hand, X_OL).depth_m};
}

}  // namespace handgraft::quality
