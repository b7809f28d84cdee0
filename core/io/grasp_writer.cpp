#include "core/io/grasp_writer.h"

#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/quoting.h"

namespace handgraft::io {

namespace {

using nlohmann::json;

const std::string isaac_note = "# note: ";

}  // namespace

std::string yamlName(const std::string& name) {
  return json(name).dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string jointCsv(const PosedGrasp& grasp) {
  std::string text = "name,value,unit\n";
  const auto out = std::back_inserter(text);
  for (const JointValue& joint : jointValues(*grasp.model, grasp.pose.q)) {
    fmt::format_to(out, "{},{},{}\n", csvCell(joint.name), joint.value,
                   joint.prismatic ? "m" : "rad");
  }
  const Eigen::Vector3d p = grasp.pose.X_WH.translation();
  const Eigen::Vector4d q = quaternionOf(grasp.pose.X_WH);
  fmt::format_to(out, "X_WH.x,{},m\nX_WH.y,{},m\nX_WH.z,{},m\n", p[0], p[1], p[2]);
  fmt::format_to(out, "X_WH.qw,{},1\nX_WH.qx,{},1\nX_WH.qy,{},1\nX_WH.qz,{},1\n", q[0], q[1],
                 q[2], q[3]);
  return text;
}

std::string isaacGraspYaml(const PosedGrasp& grasp,
                           double confidence,
                           const Eigen::VectorXd& q_before,
                           const std::vector<std::string>& notes) {
  HANDGRAFT_REQUIRE(q_before.size() == grasp.pose.q.size());
  HANDGRAFT_REQUIRE(confidence >= 0.0 && confidence <= 1.0);
  const hand::HandModel& model = *grasp.model;
  const Pose X_OH = inverse(grasp.X_WO) * grasp.pose.X_WH;
  const Eigen::Vector3d p = X_OH.translation();
  const Eigen::Vector4d q = quaternionOf(X_OH);
  std::string text = "format: isaac_grasp\nformat_version: 1.0\n\n";
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "object_frame_link: {}\ngripper_frame_link: {}\n\ngrasps:\n",
                 yamlName(grasp.object), yamlName(model.links().front().name));
  fmt::format_to(out, "  {}:\n    confidence: {:.12f}\n",
                 yamlName(grasp.hand + "_" + grasp.object), confidence);
  fmt::format_to(out, "    position: [{:.12f}, {:.12f}, {:.12f}]\n", p[0], p[1], p[2]);
  fmt::format_to(out, "    orientation: {{w: {:.12f}, xyz: [{:.12f}, {:.12f}, {:.12f}]}}\n",
                 q[0], q[1], q[2], q[3]);
  const auto add_joints = [&](const char* key, const Eigen::VectorXd& values) {
    fmt::format_to(out, "    {}:{}\n", key, model.dofCount() == 0 ? " {}" : "");
    for (int dof = 0; dof < model.dofCount(); ++dof) {
      fmt::format_to(out, "      {}: {:.12f}\n", yamlName(model.dofJoint(dof).name),
                     values[dof]);
    }
  };
  add_joints("cspace_position", grasp.pose.q);
  add_joints("pregrasp_cspace_position", q_before);
  for (const std::string& note : notes)
    text += isaac_note + note + "\n";
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
