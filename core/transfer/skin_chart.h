#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "core/geometry/log_mapper.h"
#include "core/transfer/patch_placement.h"

namespace handgraft::transfer {

/// The skin about a root, ready to look up places by their log coordinates. Immutable, and
/// the same for every direction at its place (but where several fans meet, see referenceAxis).
class SkinChart {
 public:
  /// A chart of all coordinates up to `reach`.
  ///
  /// Errors: InvalidInput for a direction along the normal and for heat methods that cannot use
  /// the surface. Cost: a log map.
  SkinChart(std::shared_ptr<const geometry::LogMapper> skin_S,
            const PatchPlacement& placement,
            double reach,
            geometry::LogMapMethod method);

  /// Whether this is the chart for that root, too. Charts come in steps of reach, so that a
  /// patch that grows a little keeps its own.
  [[nodiscard]] bool answers(const geometry::LogMapper& skin_S,
                             const PatchPlacement& placement,
                             double reach,
                             geometry::LogMapMethod method) const;

  /// A root in the chart, and the angle of its direction against the chart's x axis,
  /// counter-clockwise.
  struct View {
    Eigen::Vector2d root_T = Eigen::Vector2d::Zero();
    double direction_angle = 0.0;
  };

  /// Of the chart's own root, or of a place near it; nothing where the chart has none.
  [[nodiscard]] std::optional<View> viewFrom(const PatchPlacement& placement) const;

  /// The place at log coordinates about the chart's x axis.
  [[nodiscard]] geometry::LogMapInverse::Place at(const Eigen::Vector2d& uv_T) const {
    return inverse_->at(uv_T);
  }

  /// That made the log map; never kAuto.
  [[nodiscard]] geometry::LogMapMethod method() const { return method_; }

 private:
  std::shared_ptr<const geometry::LogMapper> skin_S_;
  geometry::SurfacePoint root_S_;
  Eigen::Vector3d axis_S_;  ///< the x axis
  double radius_;
  geometry::LogMapMethod asked_;
  geometry::LogMapMethod method_ = geometry::LogMapMethod::kFast;
  std::optional<geometry::LogMapInverse> inverse_;  ///< always set
};

}  // namespace handgraft::transfer
