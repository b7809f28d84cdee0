#pragma once

#include "client/link/grasp_result.h"

namespace handgraft::client {

inline v1::Pose poseAt(double x) {
  v1::Pose X;
  X.p_m() = {x, 0.0, 0.0};
  X.q_wxyz() = {1.0, 0.0, 0.0, 0.0};
  return X;
}

inline v1::Mesh triangle() {
  v1::Mesh mesh;
  mesh.vertices_m() = {0, 0, 0, 0.1F, 0, 0, 0, 0.1F, 0};
  mesh.triangles() = {0, 1, 2};
  return mesh;
}

/// One joint, two links, a patch that was placed and one that was dropped.
inline GraspResult exampleGrasp() {
  GraspResult result;
  result.session.hand("claw");
  result.session.object("plate");
  result.session.contacts("plate_2");
  v1::JointInfo joint;
  joint.name("bend");
  result.hand.joints().push_back(joint);
  for (const char* name : {"base", "tip"}) {
    v1::LinkInfo link;
    link.name(name);
    link.surface_L() = triangle();
    result.hand.links().push_back(link);
  }
  v1::PatchReport placed;
  placed.name("thumb");
  placed.placed(true);
  v1::LostPoint lost;
  lost.index(3);
  lost.reason("off the surface");
  placed.lost().push_back(lost);
  placed.point_count(3);
  placed.boundary_count(3);
  placed.fidelity().distance_mean(0.031);
  placed.fidelity().angle_mean_rad(0.1);
  placed.fidelity().area_ratio(0.95);
  placed.method_O(v1::LOG_MAP_EXACT);
  placed.method_S(v1::LOG_MAP_FAST);
  v1::PatchReport dropped;
  dropped.name("ring");
  dropped.placed(false);
  dropped.reason("the hand has no finger 'ring'");
  result.transfer.patches() = {placed, dropped};
  v1::PatchFit fit;
  fit.name("thumb");
  fit.point_count(3);
  fit.mean_mm(1.25);
  fit.diagnosis().verdict(v1::VERDICT_AT_LIMIT);
  fit.max_mm(2.5);
  fit.normal_deg(4.0);
  fit.within_2mm(0.5);
  fit.within_5mm(1.0);
  fit.object_W_m() = {0, 0, 0, 0.01, 0, 0, 0, 0.01, 0};
  fit.hand_W_m() = {0, 0, 0.001, 0.01, 0, 0.001, 0, 0.01, 0.001};
  v1::PoseSolution& solution = result.solution;
  solution.session_id(9);
  solution.is_final(true);
  solution.solver("mma");
  solution.X_WH() = poseAt(0.1);
  solution.X_WO() = poseAt(0.2);
  solution.joint_positions() = {0.5};
  solution.X_WL() = {poseAt(0.1), poseAt(0.3)};
  solution.patches() = {fit};
  solution.joints_at_limit().emplace_back();
  solution.joints_at_limit().back().joint("bend");
  solution.joints_at_limit().back().side(v1::LIMIT_UPPER);
  solution.terms().objective(0.25);
  v1::StageTime stage;
  stage.stage("solve");
  stage.duration_ms(12.0);
  solution.times() = {stage};
  return result;
}

}  // namespace handgraft::client
