#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/contact/patch.h"
#include "core/geometry/log_mapper.h"
#include "core/geometry/reference_axis.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::transfer {

/// A place of a patch, measured from its root.
struct ChartPoint {
  bool reached = false;                            ///< the root has a way to it
  Eigen::Vector2d uv_T = Eigen::Vector2d::Zero();  ///< log coordinates
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
  bool folded = false;  ///< several sheets of the object cover the coordinates
};

/// A copy of the boundary, drawn towards the root: `share` of the way out, on the surface.
struct ChartRing {
  double share = 1.0;
  std::vector<ChartPoint> points;  ///< one per point of the interpolation boundary
};

/// A patch in the tangent plane at its root, seen from outside the object: the half of a
/// transfer that the object decides. Immutable.
///
/// It does not depend on the patch's direction (but for roots where several fans of the surface
/// meet, see referenceAxis): coordinates are measured from a reference axis, and
/// `directionAngle` says how to turn them.
class PatchChart {
 public:
  /// Errors: InvalidInput as contact::validate, for a direction along the normal and for heat
  /// methods that cannot use the surface. `patch.direction_O` must be set (BrokenContract).
  /// Cost: a log map, O(n log n) in the patch.
  PatchChart(std::shared_ptr<const geometry::LogMapper> object_O,
             const contact::Patch& patch,
             const TransferOptions& options);

  /// Whether this is the chart of that patch, too: same mesh, places and options.
  [[nodiscard]] bool answers(const geometry::LogMapper& object_O,
                             const contact::Patch& patch,
                             const TransferOptions& options) const;

  /// Angle of `direction_O` at the root against the reference axis, counter-clockwise.
  [[nodiscard]] double directionAngle(const Eigen::Vector3d& direction_O) const;

  [[nodiscard]] const std::vector<ChartPoint>& boundary() const { return boundary_; }

  /// Rings that show how well shapes are kept, the innermost first, and those that the options
  /// ask for.
  [[nodiscard]] const std::vector<ChartRing>& fidelityRings() const { return fidelity_rings_; }

  [[nodiscard]] const std::vector<ChartRing>& interiorRings() const { return interior_rings_; }

  /// False where the boundary does not go round the root.
  [[nodiscard]] bool surroundsRoot() const;

  /// Distance of the farthest boundary point that is reached.
  [[nodiscard]] double reach() const { return reach_; }

  [[nodiscard]] const geometry::SurfacePoint& root() const { return root_; }

  [[nodiscard]] const geometry::LogMapper& object() const { return *object_O_; }

  /// That made the log map.
  [[nodiscard]] geometry::LogMapMethod method() const { return method_; }

 private:
  void measure(const geometry::LogMap& map);
  void drawRings(const geometry::LogMap& map);

  std::shared_ptr<const geometry::LogMapper> object_O_;
  // What it answers.
  geometry::SurfacePoint root_;
  std::vector<geometry::SurfacePoint> places_;  ///< the interpolation boundary
  TransferOptions options_;

  Eigen::Vector3d axis_O_;  ///< the reference axis at the root
  std::vector<ChartPoint> boundary_;
  std::vector<ChartRing> fidelity_rings_;
  std::vector<ChartRing> interior_rings_;
  double reach_ = 0.0;
  geometry::LogMapMethod method_ = geometry::LogMapMethod::kFast;
};

}  // namespace handgraft::transfer
