#pragma once

#include <complex>
#include <vector>

#include "core/geometry/intrinsic_delaunay.h"
#include "core/geometry/log_map_source.h"

namespace handgraft::geometry {

/// A vertex's share in a source of heat, in that vertex's own tangent basis.
struct HeatSeed {
  int vertex = -1;
  double weight = 0.0;
  /// The source's x axis, seen from the vertex: a unit complex number.
  std::complex<double> axis = 1.0;
  /// Where the vertex stands in the source's tangent plane T, metres.
  std::complex<double> p_T = 0.0;
};

/// The source as shares of vertices: itself at a vertex, else the corners of its face with
/// their barycentric weights. Weights are positive and sum to 1, and sum(weight * p_T)
/// vanishes.
std::vector<HeatSeed> cornerSeeds(const TriangleMesh& mesh,
                                  const IntrinsicDelaunay& surface,
                                  const SurfacePoint& source,
                                  const SourceLayout& layout);

/// The same, spread over the apexes of the next faces as well, so that the source is round:
/// sum(weight * p_T^k) is as near to zero as weights that are not negative allow, k = 1 to 3.
///
/// Heat from p_T sees the surface bent by its curvature times p_T^2; a source that is wider one
/// way than the other turns phi by as much (README). Corners come first; places farther apart
/// than `unit_length` (metres, that of the diffusion) are measured in their own distance.
/// Cost: a few systems of at most eight unknowns.
/// Source: non-negative least squares by block pivoting, Portugal, Judice & Vicente 1994.
std::vector<HeatSeed> roundSeeds(const TriangleMesh& mesh,
                                 const IntrinsicDelaunay& surface,
                                 const SurfacePoint& source,
                                 const SourceLayout& layout,
                                 double unit_length);

}  // namespace handgraft::geometry
