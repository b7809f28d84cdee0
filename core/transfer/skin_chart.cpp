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

/// The smallest step that holds `reach`; some disk where every point lies on the station.
double radiusFor(const LogMapper& skin_S, double reach) {
  if (!(reach > 0.0)) return skin_S.mesh().meanEdgeLength();
  return std::exp2(std::ceil(kStepsPerDoubling * std::log2(kRounding * reach)) /
                   kStepsPerDoubling);
}

}  // namespace

SkinChart::SkinChart(std::shared_ptr<const LogMapper> skin_S,
                     const Station& station_S,
                     double reach,
                     LogMapMethod method)
    : skin_S_(std::move(skin_S)),
      point_(station_S.point),
      axis_(geometry::referenceAxis(skin_S_->mesh(), point_, station_S.direction).direction),
      radius_(radiusFor(*skin_S_, reach)),
      asked_(method) {
  const geometry::LogMap map = skin_S_->map(point_, axis_, radius_, asked_);
  method_ = map.method;
  inverse_.emplace(skin_S_->mesh(), map);
}

bool SkinChart::answers(const LogMapper& skin_S,
                        const Station& station_S,
                        double reach,
                        LogMapMethod method) const {
  return &skin_S == skin_S_.get() && method == asked_ && station_S.point.face == point_.face &&
         station_S.point.barycentric == point_.barycentric &&
         radiusFor(skin_S, reach) == radius_ &&
         geometry::referenceAxis(skin_S.mesh(), point_, station_S.direction).direction == axis_;
}

double SkinChart::directionAngle(const Eigen::Vector3d& direction_S) const {
  return geometry::referenceAxis(skin_S_->mesh(), point_, direction_S).angle;
}

}  // namespace handgraft::transfer
