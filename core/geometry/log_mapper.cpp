#include "core/geometry/log_mapper.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::geometry {

LogMapper::LogMapper(std::shared_ptr<const TriangleMesh> mesh) : mesh_(std::move(mesh)) {
  HANDGRAFT_REQUIRE(mesh_ != nullptr);
}

std::shared_ptr<const LogMapper> LogMapper::borrowing(const TriangleMesh& mesh) {
  return std::make_shared<const LogMapper>(
      std::shared_ptr<const TriangleMesh>(std::shared_ptr<void>(), &mesh));
}

LogMap LogMapper::map(const SurfacePoint& source,
                      const Eigen::Vector3d& direction,
                      double radius,
                      LogMapMethod method) const {
  const bool is_heat = method == LogMapMethod::kSmooth || method == LogMapMethod::kHeat;
  if (!is_heat) return computeLogMap(*mesh_, source, direction, radius, method);
  validate(*mesh_, source, "log map source");
  if (!(radius > 0.0)) rejectInput("log map radius is {} m, it must be positive", radius);
  return method == LogMapMethod::kSmooth ? heat().smooth(source, direction, radius)
                                         : heat().heat(source, direction, radius);
}

const HeatLogMap& LogMapper::heat() const {
  std::call_once(heat_once_, [&] {
    heat_ = std::make_unique<const HeatLogMap>(*mesh_);
  });
  return *heat_;
}

}  // namespace handgraft::geometry
