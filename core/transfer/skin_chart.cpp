#include "core/transfer/skin_chart.h"

#include <cmath>
#include <utility>

#include "core/geometry/reference_axis.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMapMethod;
using geometry::LogMapper;

constexpr double kStepsPerDoubling = 8.0;  // a step is 9 % of reach
constexpr double kRounding = 1.0 + 1e-6;

/// The smallest step that holds `reach`; some disk where every point lies on the root.
double radiusFor(const LogMapper& skin_S, double reach) {
  if (!(reach > 0.0)) return skin_S.mesh().meanEdgeLength();
  return std::exp2(std::ceil(kStepsPerDoubling * std::log2(kRounding * reach)) /
                   kStepsPerDoubling);
}

}  // namespace

SkinChart::SkinChart(std::shared_ptr<const LogMapper> skin_S,
                     const PatchPlacement& placement,
                     double reach,
                     LogMapMethod method)
    : skin_S_(std::move(skin_S)),
      root_S_(placement.root_S),
      axis_S_(
          geometry::referenceAxis(skin_S_->mesh(), root_S_, placement.direction_S).direction),
      radius_(radiusFor(*skin_S_, reach)),
      asked_(method) {
  const geometry::LogMap map = skin_S_->map(root_S_, axis_S_, radius_, asked_);
  method_ = map.method;
  inverse_.emplace(skin_S_->mesh(), map);
}

bool SkinChart::answers(const LogMapper& skin_S,
                        const PatchPlacement& placement,
                        double reach,
                        LogMapMethod method) const {
  return &skin_S == skin_S_.get() && method == asked_ &&
         placement.root_S.face == root_S_.face &&
         placement.root_S.barycentric == root_S_.barycentric &&
         radiusFor(skin_S, reach) == radius_ &&
         geometry::referenceAxis(skin_S.mesh(), root_S_, placement.direction_S).direction ==
             axis_S_;
}

double SkinChart::directionAngle(const Eigen::Vector3d& direction_S) const {
  return geometry::referenceAxis(skin_S_->mesh(), root_S_, direction_S).angle;
}

}  // namespace handgraft::transfer
