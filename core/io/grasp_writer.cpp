#include "core/io/grasp_writer.h"

#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

/// YAML's double-quoted style takes JSON's escapes.
std::string quotedName(const std::string& text) {
  return json(text).dump(-1, ' ', true, json::error_handler_t::replace);
}

OrderedJson poseJson(const Pose& X) {
  const Eigen::Vector3d p = X.translation();
  const Eigen::Vector4d q = quaternionOf(X);
  return {{"p_m", {p[0], p[1], p[2]}}, {"q_wxyz", {q[0], q[1], q[2], q[3]}}};
}

OrderedJson termsJson(const optimize::Terms& terms) {
  return {{"distance_m2", terms.distance},
          {"normal", terms.normal},
          {"prior", terms.prior},
          {"objective", terms.objective}};
}

void addSolved(OrderedJson& document, const hand::HandModel& model, const SolvedGrasp& solved) {
  const optimize::SolveReport& report = solved.report;
  document["outcome"] = std::string(nameOf(report.outcome));
  document["solver"] = report.solver;
  document["evaluations"] = report.evaluations;
  document["terms"] = termsJson(report.terms);
  OrderedJson limits = OrderedJson::array();
  for (const optimize::ActiveLimit& limit : report.active_limits)
    limits.push_back(model.dofJoint(limit.dof).name + (limit.upper ? " upper" : " lower"));
  document["joints_at_limit"] = limits;
  OrderedJson patches = OrderedJson::array();
  for (const optimize::PatchFit& fit : report.patches) {
    const auto index = static_cast<std::size_t>(fit.patch);
    HANDGRAFT_REQUIRE(index < solved.patch_names.size());
    patches.push_back({{"name", solved.patch_names[index]},
                       {"point_count", fit.point_count},
                       {"mean_mm", fit.mean_mm},
                       {"rms_mm", fit.rms_mm},
                       {"max_mm", fit.max_mm},
                       {"normal_deg", fit.normal_mean_deg},
                       {"within_2mm", fit.within_2mm},
                       {"within_5mm", fit.within_5mm}});
  }
  document["patches"] = patches;
}

}  // namespace

std::string jointCsv(const PosedGrasp& grasp) {
  std::string text = "name,value,unit\n";
  const auto out = std::back_inserter(text);
  for (const JointValue& joint : jointValues(*grasp.model, grasp.pose.q)) {
    fmt::format_to(out, "{},{},{}\n", csvField(joint.name), joint.value,
                   joint.prismatic ? "m" : "rad");
  }
  const Eigen::Vector3d p = grasp.pose.X_WH.translation();
  const Eigen::Vector4d q = quaternionOf(grasp.pose.X_WH);
  fmt::format_to(out, "X_WH.x,{},m\nX_WH.y,{},m\nX_WH.z,{},m\n", p[0], p[1], p[2]);
  fmt::format_to(out, "X_WH.qw,{},1\nX_WH.qx,{},1\nX_WH.qy,{},1\nX_WH.qz,{},1\n", q[0], q[1],
                 q[2], q[3]);
  return text;
}

std::string graspJson(const PosedGrasp& grasp, const SolvedGrasp* solved) {
  const hand::HandModel& model = *grasp.model;
  OrderedJson document = {{"format", "handgraft-grasp/1"},
                          {"hand", grasp.hand},
                          {"object", grasp.object},
                          {"X_WH", poseJson(grasp.pose.X_WH)},
                          {"X_WO", poseJson(grasp.X_WO)}};
  OrderedJson joints = OrderedJson::object();
  for (const JointValue& joint : jointValues(model, grasp.pose.q)) {
    if (!joint.follows) joints[joint.name] = joint.value;
  }
  document["joints"] = joints;
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, grasp.pose);
  OrderedJson links = OrderedJson::object();
  for (std::size_t i = 0; i < X_WL.size(); ++i)
    links[model.links()[i].name] = poseJson(X_WL[i]);
  document["links_X_WL"] = links;
  if (solved) addSolved(document, model, *solved);
  return document.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string isaacGraspYaml(const PosedGrasp& grasp, double confidence) {
  HANDGRAFT_REQUIRE(confidence >= 0.0 && confidence <= 1.0);
  const hand::HandModel& model = *grasp.model;
  const Pose X_OH = inverse(grasp.X_WO) * grasp.pose.X_WH;
  const Eigen::Vector3d p = X_OH.translation();
  const Eigen::Vector4d q = quaternionOf(X_OH);
  std::string text = "format: isaac_grasp\nformat_version: 1.0\n\n";
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "object_frame_link: {}\ngripper_frame_link: {}\n\ngrasps:\n",
                 quotedName(grasp.object), quotedName(model.links().front().name));
  fmt::format_to(out, "  {}:\n    confidence: {:.12f}\n",
                 quotedName(grasp.hand + "_" + grasp.object), confidence);
  fmt::format_to(out, "    position: [{:.12f}, {:.12f}, {:.12f}]\n", p[0], p[1], p[2]);
  fmt::format_to(out, "    orientation: {{w: {:.12f}, xyz: [{:.12f}, {:.12f}, {:.12f}]}}\n",
                 q[0], q[1], q[2], q[3]);
  const auto addJoints = [&](const char* key, const Eigen::VectorXd& values) {
    fmt::format_to(out, "    {}:{}\n", key, model.dofCount() == 0 ? " {}" : "");
    for (int dof = 0; dof < model.dofCount(); ++dof) {
      fmt::format_to(out, "      {}: {:.12f}\n", quotedName(model.dofJoint(dof).name),
                     values[dof]);
    }
  };
  addJoints("cspace_position", grasp.pose.q);
  addJoints("pregrasp_cspace_position", model.restPose());
  return text;
}

double confidenceOf(const optimize::SolveReport& report) {
  double within = 0.0;
  double points = 0.0;
  for (const optimize::PatchFit& fit : report.patches) {
    within += fit.point_count * fit.within_5mm;
    points += fit.point_count;
  }
  return points > 0.0 ? std::min(1.0, within / points) : 0.0;
}

}  // namespace handgraft::io
