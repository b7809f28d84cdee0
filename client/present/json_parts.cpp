#include "client/present/json_parts.h"

#include <algorithm>

#include "client/present/minima_text.h"

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

Json minima(const v1::PoseSolution& solution, const v1::HandDescription& hand) {
  Json list = Json::array();
  for (const v1::MinimumInfo& minimum : solution.minima()) {
    const PoseGap gap = gapBetween(solution.minima().front(), minimum, hand);
    Json joints = Json::object();
    for (std::size_t j = 0;
         j < std::min(minimum.joint_positions().size(), hand.joints().size()); ++j)
      joints[hand.joints()[j].name()] = minimum.joint_positions()[j];
    list.push_back({{"rank", list.size() + 1},
                    {"taken", list.size() == solution.chosen_minimum()},
                    {"solver", minimum.solver()},
                    {"objective", minimum.terms().objective()},
                    {"distance_m2", minimum.terms().distance_m2()},
                    {"normal", minimum.terms().normal()},
                    {"prior", minimum.terms().prior()},
                    {"hits", minimum.hits()},
                    {"start", minimum.start()},
                    {"moved_mm", gap.moved_mm},
                    {"turned_deg", gap.turned_deg},
                    {"X_WH", pose(minimum.X_WH())},
                    {"joints", joints}});
  }
  return list;
}

}  // namespace handgraft::client::json
