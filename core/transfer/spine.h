#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/contact/patch.h"
#include "core/geometry/surface_point.h"

namespace handgraft::transfer {

/// A place that points of a patch are measured from, with its x axis.
struct Station {
  geometry::SurfacePoint point;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< its part along the surface counts
};

/// A straight way from one station to another: leave at `heading`, counter-clockwise seen from
/// outside against the station's direction, walk `length`, turn by `turn`; that is the next
/// station's direction. Angles are those of log maps (core/geometry).
struct SpineLeg {
  int from = 0;
  double heading = 0.0;  ///< rad
  double length = 0.0;   ///< m
  double turn = 0.0;     ///< rad
};

/// The root of a patch, and, where the patch carries an axis, samples along it: what is needed
/// to lay the same figure onto another surface.
struct Spine {
  std::vector<Station> stations;  ///< the root first
  std::vector<SpineLeg> legs;     ///< legs[i] leads to stations[i + 1], from one before it
};

/// The spine of a patch whose root has the direction `direction_O`. One station if it has no
/// axis; else the root, the knots on one side of it, those on the other, and samples between
/// knots that are farther apart than the patch is wide.
///
/// The root's direction is carried along without turning, so that coordinates about all
/// stations lie alike.
/// Errors: InvalidInput if no straight way leads from one knot to the next (another component,
/// a
///   notch of the surface's edge between them). Cost: a log map of a leg's length for each leg.
Spine spineOf(const geometry::TriangleMesh& object_O,
              const contact::Patch& patch,
              const Eigen::Vector3d& direction_O);

/// The legs of the same figure, had its root the direction turned by `angle` (rad).
std::vector<SpineLeg> turnedLegs(std::vector<SpineLeg> legs, double angle);

/// The same figure on another surface, seen face to face: headings and turns change sign.
///
/// Stations that a leg cannot reach because the surface ends are missing, and so are those
/// behind them. Shapes: one entry a station, the root first. Cost: O(1) a face crossed.
std::vector<std::optional<Station>> retraceMirrored(const geometry::TriangleMesh& skin_S,
                                                    const Station& root_S,
                                                    const std::vector<SpineLeg>& legs);

}  // namespace handgraft::transfer
