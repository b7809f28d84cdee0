#pragma once

#include <string>
#include <vector>

#include "core/geometry/log_map.h"
#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::bench {

/// Least time per root, then over roots: median and the tenth and ninetieth percent.
struct Times {
  double median_ms = 0.0;
  double low_ms = 0.0;
  double high_ms = 0.0;
};

Times timesOf(const std::vector<double>& per_root_ms);

/// One method on disks of one radius.
struct DiskSpeed {
  std::string surface;
  int vertices = 0;
  double radius_m = 0.0;
  std::string method;  ///< ours, or "cgal exact", "cgal exact cut", "cgal heat"
  double setup_ms = 0.0;
  int roots = 0;
  double reached = 0.0;  ///< median over roots
  Times times;
  /// Largest difference of r to our `exact` over vertices in both disks, metres; 0 for itself.
  double r_difference_m = 0.0;
  int exact_maps = 0;  ///< of roots: what `auto` took
};

/// Roots with directions, timed one after another on one thread.
struct DiskTask {
  std::string surface;
  const geometry::TriangleMesh* mesh = nullptr;
  std::vector<geometry::SurfacePoint> roots;
  double radius_m = 0.0;
  int repeats = 5;
};

/// Errors: InvalidInput as the log maps.
DiskSpeed measureDisk(const DiskTask& task, geometry::LogMapMethod method);

/// CGAL's exact distances over the whole mesh: time to build the tree of one source.
DiskSpeed measureCgalWhole(const DiskTask& task);

/// The same on the disk alone, cut out of the mesh beforehand (twice as large across as the
/// paths that matter would need; cutting is not timed): the kinder baseline, since CGAL knows
/// no radius.
DiskSpeed measureCgalCut(const DiskTask& task);

/// CGAL's heat method from the nearest vertex, factored beforehand (`setup_ms`).
DiskSpeed measureCgalHeat(const DiskTask& task);

/// Slope of log y over log x by least squares; 0 for fewer than two points.
double growthExponent(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace handgraft::bench
