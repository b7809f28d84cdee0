#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/contact/patch.h"
#include "core/geometry/log_mapper.h"
#include "core/geometry/reference_axis.h"
#include "core/transfer/patch_transfer.h"
#include "core/transfer/spine.h"

namespace handgraft::transfer {

/// A place of a patch, measured from one of its stations.
struct ChartPoint {
  int station = -1;                                ///< of the spine; -1: reached from none
  Eigen::Vector2d uv_T = Eigen::Vector2d::Zero();  ///< log coordinates about it
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
  bool folded = false;  ///< several sheets of the object cover the coordinates
};

/// A copy of the boundary, drawn towards the stations: `share` of the way out, on the surface.
struct ChartRing {
  double share = 1.0;
  std::vector<ChartPoint> points;  ///< one per point of the interpolation boundary
};

/// A patch in the tangent planes of its stations, seen from outside the object: the half of a
/// transfer that the object decides. Immutable.
///
/// It does not depend on the patch's direction (but for roots where several fans of the surface
/// meet, see referenceAxis): coordinates about the root are measured from a reference axis, and
/// `directionAngle` says how to turn them.
class PatchChart {
 public:
  /// Errors: InvalidInput as contact::validate, for a direction along the normal and for heat
  /// methods that cannot use the surface. `patch.direction_O` must be set (BrokenContract).
  /// Cost: a log map for each station, O(n log n) in its part of the patch.
  PatchChart(std::shared_ptr<const geometry::LogMapper> object_O,
             const contact::Patch& patch,
             const TransferOptions& options);

  /// Whether this is the chart of that patch, too: same mesh, places and options.
  [[nodiscard]] bool answers(const geometry::LogMapper& object_O,
                             const contact::Patch& patch,
                             const TransferOptions& options) const;

  /// The stations, the root first; its direction is the reference axis.
  [[nodiscard]] const Spine& spine() const { return spine_; }

  /// Angle of `direction_O` at the root against the reference axis, counter-clockwise.
  [[nodiscard]] double directionAngle(const Eigen::Vector3d& direction_O) const;

  [[nodiscard]] const std::vector<ChartPoint>& boundary() const { return boundary_; }

  /// Rings that show how well shapes are kept, the innermost first, and those that the options
  /// ask for.
  [[nodiscard]] const std::vector<ChartRing>& fidelityRings() const { return fidelity_rings_; }

  [[nodiscard]] const std::vector<ChartRing>& interiorRings() const { return interior_rings_; }

  /// Distance of the farthest boundary point measured from a station.
  [[nodiscard]] double reach(std::size_t station) const { return reaches_[station]; }

  [[nodiscard]] const geometry::LogMapper& object() const { return *object_O_; }

  /// That made the log map about the root.
  [[nodiscard]] geometry::LogMapMethod method() const { return method_; }

 private:
  void measure(const std::vector<geometry::LogMap>& maps);
  void drawRings(const std::vector<geometry::LogMap>& maps, int interior_rings);

  std::shared_ptr<const geometry::LogMapper> object_O_;
  // What it answers.
  geometry::SurfacePoint root_;
  std::vector<geometry::SurfacePoint> places_;
  TransferOptions options_;

  Spine spine_;
  std::vector<ChartPoint> boundary_;
  std::vector<ChartRing> fidelity_rings_;
  std::vector<ChartRing> interior_rings_;
  std::vector<double> reaches_;
  geometry::LogMapMethod method_ = geometry::LogMapMethod::kFast;
};

}  // namespace handgraft::transfer
