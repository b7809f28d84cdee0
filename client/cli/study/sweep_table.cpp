#include <fmt/format.h>

#include "client/cli/study/sweep_result.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "core/base/quoting.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

std::string joined(const std::vector<std::string>& items) {
  std::string out;
  for (const std::string& item : items)
    out += (out.empty() ? "" : ";") + item;
  return out;
}

json::Json rowOf(const SweepResult& result, const v1::SweepRow& row) {
  json::Json one = json::jsonOf(row);
  one["grasp"] = result.grasps[row.grasp()].label;
  return one;
}

}  // namespace

std::string csvOf(const SweepResult& result) {
  std::string out = "grasp";
  for (std::size_t a = 0; a < result.axes.size(); ++a)
    out += "," + csvCell(axisLabel(result, a));
  out +=
      ",error,outcome,mean_mm,max_mm,normal_deg,depth_mm,self_depth_mm,patches,reached,points,"
      "objective,distance_m2,normal,prior,joints_at_limit,solve_ms";
  for (const std::string& joint : result.reply.joint_names())
    out += "," + csvCell(joint);
  out += "\n";
  for (const v1::SweepRow& row : result.reply.rows()) {
    out += csvCell(result.grasps[row.grasp()].label);
    for (std::size_t a = 0; a < result.axes.size(); ++a)
      out += fmt::format(",{:.10g}", result.axes[a].shown(row.values()[a]));
    out += "," + csvCell(row.error());
    if (!row.error().empty()) {
      out += std::string(15 + result.reply.joint_names().size(), ',') + "\n";
      continue;
    }
    const v1::Terms& terms = row.terms();
    // A patch that the hand has no place for is nowhere, not at no distance.
    out += "," + std::string(nameOf(row.outcome()));
    out += row.patch_count() == 0 ? ",,,"
                                  : fmt::format(",{:.6g},{:.6g},{:.6g}", row.mean_mm(),
                                                row.max_mm(), row.normal_deg());
    out +=
        fmt::format(",{:.4g},{:.4g},{},{},{},{:.10g},{:.10g},{:.10g},{:.10g},{},{:.4g}",
                    1e3 * row.max_depth_m(), 1e3 * row.self_depth_m(), row.patch_count(),
                    row.reached_count(), row.point_count(), terms.objective(),
                    terms.distance_m2(), terms.normal(), terms.prior(),
                    csvCell(joined(text::limitNames(row.joints_at_limit()))), row.solve_ms());
    for (const double q : row.joint_positions())
      out += fmt::format(",{:.10g}", q);
    if (row.joint_positions().empty())
      out += std::string(result.reply.joint_names().size(), ',');
    out += "\n";
  }
  return out;
}

namespace json {

std::string sweep(const SweepResult& result, int indent) {
  const std::vector<SweepPoint> points = pointsOf(result);
  Json document;
  document["format"] = "handgraft-sweep/1";
  document["hand"] = result.hand;
  document["grasps"] = Json::array();
  for (const StudyGrasp& grasp : result.grasps)
    document["grasps"].push_back({{"name", grasp.label},
                                  {"contacts", grasp.contacts.string()},
                                  {"object", grasp.object},
                                  {"motion", grasp.motion},
                                  {"patch", grasp.patch}});
  document["axes"] = Json::array();
  for (const StudyAxis& axis : result.axes)
    document["axes"].push_back({{"name", axis.name}, {"values", axis.axis.values()}});
  document["joint_names"] = result.reply.joint_names();
  if (!points.empty()) {
    const SweepPoint& best = points[bestOf(points)];
    document["best"] = {{"values", best.values},
                        {"mean_mm", best.mean_mm},
                        {"max_depth_m", 1e-3 * best.deepest_mm},
                        {"self_depth_m", 1e-3 * best.self_mm},
                        {"patch_count", best.patches},
                        {"reached_count", best.reached}};
  }
  document["notes"] = result.notes;
  document["rows"] = Json::array();
  for (const v1::SweepRow& row : result.reply.rows())
    document["rows"].push_back(rowOf(result, row));
  document["total_ms"] = result.reply.total_ms();
  return written(document, indent);
}

}  // namespace json

}  // namespace handgraft::client
