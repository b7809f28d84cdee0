#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::io {

/// A hand at an object, as it is written for other programs.
struct PosedGrasp {
  std::string hand;  ///< names, for people
  std::string object;
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  hand::HandPose pose;
  Pose X_WO = Pose::Identity();
};

/// A movable joint and where it stands, rad or m.
struct JointValue {
  std::string name;
  double value = 0.0;
  bool prismatic = false;
  bool follows = false;  ///< mimics another one
};

/// The independent joints in the hand's own order, then those that mimic them, in the file's.
/// Errors: BrokenContract unless q has dofCount() entries.
std::vector<JointValue> jointValues(const hand::HandModel& model, const Eigen::VectorXd& q);

/// One solid of the scene: a link's whole surface, or the object.
struct ScenePart {
  std::string name;
  std::array<float, 3> color;  ///< linear red, green, blue in [0, 1]
  geometry::TriangleMesh mesh_P;
  Pose X_WP = Pose::Identity();
};

/// The links that have a surface, in the model's order, then the object, named `object NAME`.
/// Errors: as above. Cost: O(faces).
std::vector<ScenePart> partsOf(const PosedGrasp& grasp);

/// The poses of these alone, in their order.
std::vector<Pose> partPoses(const PosedGrasp& grasp);

}  // namespace handgraft::io
