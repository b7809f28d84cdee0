#include <cmath>

#include <nlohmann/json.hpp>

#include "tests/bench/retargeting/retargeting_summary.h"

namespace handgraft::bench {

namespace {

using Json = nlohmann::ordered_json;

Json numberOrNull(double value) {
  return std::isnan(value) ? Json(nullptr) : Json(value);
}

Json toJson(const MethodSummary& method) {
  return {{"method", method.method},
          {"grasps", method.grasps},
          {"patches_asked", method.asked},
          {"patches_reached", method.reached},
          {"grasps_with_all_reached", method.whole},
          {"mean_mm", method.mean_mm},
          {"normals_deg", method.facing_deg},
          {"gap_mm", method.gap_mm},
          {"shared_cm3", method.shared_cm3},
          {"deepest_median_mm", numberOrNull(method.deepest_median_mm)},
          {"deepest_worst_mm", numberOrNull(method.deepest_worst_mm)},
          {"grasps_past_2mm", method.past_2mm},
          {"self_median_mm", numberOrNull(method.self_median_mm)},
          {"self_worst_mm", numberOrNull(method.self_worst_mm)},
          {"solve_median_ms", numberOrNull(method.solve_median_ms)},
          {"solve_p95_ms", numberOrNull(method.solve_p95_ms)}};
}

Json toJson(const HandSummary& hand) {
  Json baselines = Json::array();
  for (const MethodSummary& method : hand.baselines)
    if (method.grasps > 0) baselines.push_back(toJson(method));
  return {{"hand", hand.hand},
          {"dofs", hand.dofs},
          {"refused", hand.refused},
          {"patches_dropped", hand.dropped},
          {"ours", toJson(hand.ours)},
          {"transfer_median_ms", numberOrNull(hand.transfer_median_ms)},
          {"transfer_p95_ms", numberOrNull(hand.transfer_p95_ms)},
          {"pose_median_ms", numberOrNull(hand.pose_median_ms)},
          {"pose_p95_ms", numberOrNull(hand.pose_p95_ms)},
          {"told_median_mm", numberOrNull(hand.told_median_mm)},
          {"told_worst_mm", numberOrNull(hand.told_worst_mm)},
          {"joints_off_four_digits_mm", numberOrNull(hand.joints_four_mm)},
          {"joints_off_mm", numberOrNull(hand.joints_all_mm)},
          {"baselines", baselines}};
}

Json toJson(const Retargeted& result) {
  const ExactPenetration& depth = result.measure.penetration;
  return {{"mean_mm", result.measure.mean_mm},
          {"normals_deg", result.measure.facing_deg},
          {"gap_mm", result.measure.gap_mm},
          {"reached", result.measure.reached},
          {"hand_in_object_mm", 1e3 * depth.hand_in_object_m},
          {"object_in_hand_mm", 1e3 * depth.object_in_hand_m},
          {"deepest_link", depth.deepest_link},
          {"shared_cm3", 1e6 * depth.volume_m3},
          {"self_mm", 1e3 * depth.self_m},
          {"self_links", depth.self_links},
          {"ms", result.ms}};
}

Json toJson(const RetargetedGrasp& grasp) {
  Json row{{"hand", grasp.hand}, {"grasp", grasp.grasp}, {"refused", grasp.refused}};
  if (!grasp.refused.empty()) return row;
  row["digits_touching"] = grasp.digits_touching;
  row["asked"] = grasp.asked;
  row["ours"] = toJson(grasp.ours);
  row["transfer_ms"] = grasp.ms_transfer;
  row["told_mm"] = 1e3 * grasp.told_depth_m;
  row["told_self_mm"] = 1e3 * grasp.told_self_m;
  row["joints_at_limits"] = grasp.joints_at_limits;
  if (grasp.joints_mm) row["joints_off_mm"] = *grasp.joints_mm;
  if (grasp.fingertips) row["fingertip_kinematics"] = toJson(*grasp.fingertips);
  if (grasp.dex_pilot) row["dex_pilot"] = toJson(*grasp.dex_pilot);
  row["patches"] = Json::array();
  for (std::size_t i = 0; i < grasp.patches.size(); ++i) {
    const RetargetedPatch& patch = grasp.patches[i];
    Json entry{{"name", patch.name}, {"site", patch.site}, {"dropped", patch.dropped}};
    for (const PatchMeasure& measure : grasp.ours.measure.patches) {
      if (measure.patch != static_cast<int>(i)) continue;
      entry["mean_mm"] = measure.mean_mm;
      entry["normals_deg"] = measure.facing_deg;
      entry["gap_mm"] = measure.gap_mm;
      entry["reached"] = measure.reached;
    }
    row["patches"].push_back(entry);
  }
  return row;
}

}  // namespace

std::string jsonOf(const std::vector<HandSummary>& hands,
                   const std::vector<RetargetedGrasp>& grasps) {
  Json document{{"hands", Json::array()}, {"grasps", Json::array()}};
  for (const HandSummary& hand : hands)
    document["hands"].push_back(toJson(hand));
  for (const RetargetedGrasp& grasp : grasps)
    document["grasps"].push_back(toJson(grasp));
  return document.dump();
}

}  // namespace handgraft::bench
