#include "client/json_parts.h"

namespace handgraft::client::json {

std::string written(const Json& document, int indent) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json pose(const v1::Pose& X) {
  return {{"p_m", listOf(X.p_m())}, {"q_wxyz", listOf(X.q_wxyz())}};
}

Json points(const std::vector<double>& xyz) {
  Json list = Json::array();
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    list.push_back({xyz[i], xyz[i + 1], xyz[i + 2]});
  }
  return list;
}

Json surfacePoint(const v1::SurfacePoint& point) {
  return {{"face", point.face()}, {"barycentric", listOf(point.barycentric())}};
}

Json fidelity(const v1::Fidelity& fidelity) {
  return {{"distance_mean", fidelity.distance_mean()},
          {"distance_max", fidelity.distance_max()},
          {"angle_mean_rad", fidelity.angle_mean_rad()},
          {"angle_max_rad", fidelity.angle_max_rad()},
          {"area_ratio", fidelity.area_ratio()},
          {"projection_mean_m", fidelity.projection_mean_m()},
          {"projection_max_m", fidelity.projection_max_m()}};
}

Json lostPoints(const std::vector<v1::LostPoint>& lost) {
  Json list = Json::array();
  for (const v1::LostPoint& point : lost) {
    list.push_back(
        {{"index", point.index()}, {"ring", point.ring()}, {"reason", point.reason()}});
  }
  return list;
}

}  // namespace handgraft::client::json
