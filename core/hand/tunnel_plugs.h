#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::hand {

/// Sheets that shut the through-holes of a surface.
struct TunnelPlugs {
  geometry::TriangleMesh sheets_S;  ///< open triangles whose rims lie inside the surface
  int count = 0;                    ///< of separate sheets
  double area_m2 = 0.0;             ///< of all sheets, one side, to some 20 %
};

/// Finds where a closed surface has tunnels wider than about `step_m` and spans a sheet over
/// each, at its narrowest place; none for a ball-like surface.
///
/// Takes the tunnels shut on a grid of voxels `step_m` wide; sheets are smoothed, so they are
/// as thin as a triangle. A set of triangles that holds them, wrapped, has lost these tunnels.
/// Requires a mesh that is closed, oriented and free of self-intersections.
/// Deterministic. Cost: about 1 s for a hand.
TunnelPlugs findTunnelPlugs(const geometry::TriangleMesh& surface_S, double step_m);

/// The same ahead of wrapping `triangles_S` (with `wrapped`, skin_wrap.h): finds the tunnels
/// that the wrap would have, by a ball that rolls around the triangles. May find some that it
/// would not have, whose sheets then lie inside it, and miss narrow ones. None where the
/// triangles are of several pieces that no ball of that size would join.
TunnelPlugs findTunnelPlugsOfWrap(const geometry::TriangleMesh& triangles_S,
                                  double alpha_m,
                                  double offset_m,
                                  double step_m);

}  // namespace handgraft::hand
