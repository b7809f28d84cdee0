#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/optimize/body_moments.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The joint that carries body k + 1 of a MomentTree.
struct TreeJoint {
  int parent_body = 0;
  hand::JointType type = hand::JointType::kRevolute;
  int dof = 0;              ///< of the hand
  double multiplier = 1.0;  ///< joint value = multiplier * q[dof] + offset
  double offset = 0.0;
  Eigen::Vector3d axis_P = Eigen::Vector3d::UnitX();  ///< in the parent body
  Eigen::Vector3d p_PB = Eigen::Vector3d::Zero();     ///< at value 0
  /// R_PB = still + sin(value) sine + cos(value) cosine; `still` alone where it slides.
  Eigen::Matrix3d still = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d sine = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d cosine = Eigen::Matrix3d::Zero();
};

/// Where a link went: its body, -1 where none needs it, and its place in there.
struct LinkPlace {
  int body = -1;
  Pose X_BL = Pose::Identity();
};

/// A problem as its objective sees it: bodies (links with all that is fixed to them) that carry
/// point pairs or samples that avoid penetration, or lead to some that do, and their moments.
/// Body 0 is the root, H; bodies are numbered depth first, parents before children.
struct MomentTree {
  std::vector<TreeJoint> joints;     ///< of bodies 1, 2, ...
  std::vector<BodyMoments> moments;  ///< of the bodies that have pairs, by rising number
  std::vector<LinkPlace> links;      ///< of every link of the hand

  [[nodiscard]] int bodyCount() const { return static_cast<int>(joints.size()) + 1; }
};

/// Where a body stands.
struct BodyPlace {
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_HB_W = Eigen::Vector3d::Zero();  ///< from the root's origin
  Eigen::Vector3d axis_W = Eigen::Vector3d::Zero();  ///< of the joint that carries it
};

/// Places all bodies; `places` has as many entries. Cost: O(bodies), allocates nothing.
void placeBodies(const MomentTree& tree,
                 const Eigen::Matrix3d& R_WH,
                 const Eigen::VectorXd& q,
                 std::vector<BodyPlace>& places);

/// Errors: BrokenContract if a pair lies on no link. Cost: O(pairs + links).
MomentTree makeMomentTree(const PoseProblem& problem);

}  // namespace handgraft::optimize
