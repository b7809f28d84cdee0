#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/log_mapper.h"

namespace handgraft::bench {

/// What came of some disks: a circle of places a disk, at its radius, looked up by the inverse.
struct DiskTally {
  long disks = 0;
  long refused = 0;  ///< roots without a normal, components that heat cannot use
  long queries = 0;
  long placed = 0;
  long folded = 0;  ///< placed, and said to be covered by several sheets
  long lost_at_edge = 0;
  long lost_at_cut_locus = 0;
  long lost_beyond = 0;
  long not_finite = 0;  ///< coordinates or weights that are no numbers; must be 0
  long faces = 0;
  long turned_over = 0;  ///< faces whose corners go clockwise in T
  long collapsed = 0;    ///< faces that keep less than a tenth of their area, not turned over
  /// Turned over and taken, or placed where several faces lie, and no word about it; must be 0.
  long unreported = 0;
  long fell_back = 0;      ///< disks for which `auto` took another method than exact
  std::vector<double> ms;  ///< log map and inverse, one a disk

  DiskTally& operator+=(const DiskTally& other);

  [[nodiscard]] long lost() const { return lost_at_edge + lost_at_cut_locus + lost_beyond; }

  [[nodiscard]] double medianMs() const;
};

/// One disk, judged by its coordinates alone: every turned-over face has to be left out of the
/// inverse, and a place that several faces cover, on whichever side, has to be `folded`.
DiskTally checkDisk(const geometry::LogMapper& maps,
                    const geometry::SurfacePoint& root,
                    double radius,
                    geometry::LogMapMethod method);

struct Root {
  geometry::SurfacePoint point;
  double radius = 0.0;
};

/// Roots uniform by area, radii 5, 10, 20 and 40 mm in turn. Deterministic. None on a mesh
/// without area.
std::vector<Root> randomRoots(const geometry::TriangleMesh& mesh, int count, unsigned seed);

/// How `broken` damages a mesh.
enum class Damage {
  kNone,
  kDeleted,     ///< a tenth of the faces is gone: holes, loose pieces
  kDuplicated,  ///< a twentieth is there twice: edges with more than two faces
  kFlipped,     ///< a twentieth looks the other way
  kMerged       ///< one vertex in fifty is drawn onto another one nearby: pinches, overlaps
};

inline constexpr Damage kDamages[] = {Damage::kNone, Damage::kDeleted, Damage::kDuplicated,
                                      Damage::kFlipped, Damage::kMerged};

const char* nameOf(Damage damage);

/// Deterministic.
geometry::TriangleMesh broken(const geometry::TriangleMesh& mesh, Damage damage, unsigned seed);

}  // namespace handgraft::bench
