#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::optimize {

struct Weights {
  /// Default units: 1e4 / m^2 makes 1 cm of distance weigh as much as a right angle between the
  /// normals (each 1 per point); the prior only breaks ties among poses that fit equally well.
  double distance = 1e4;
  double normal = 1.0;
  double prior = 1e-3;
};

/// A pair of points to bring together, hand side in its link, object side in W.
struct PointPair {
  int link = 0;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::Zero();
  double weight = 1.0;
  int patch = -1;  ///< for reports; -1 when patches are not known
};

/// Everything Eq. 2-5 of the paper need.
///
/// Degrees of freedom are ordered root rotation (3), root translation (3), then the hand's dofs.
/// The root's bounds are infinite unless someone asks; bounds on its rotation are not supported.
struct PoseProblem {
  std::shared_ptr<const hand::HandModel> model;
  std::vector<PointPair> pairs;
  Weights weights;
  hand::HandPose start;
  hand::HandPose prior;
  Eigen::VectorXd lower;  ///< of the hand's dofs
  Eigen::VectorXd upper;
  Eigen::Vector3d root_lower = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Vector3d root_upper = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  /// Multiplies the prior per degree of freedom, 6 + dofs entries; empty means all 1. The three of
  /// the rotation weigh the geodesic angle by their mean.
  Eigen::VectorXd prior_weights;
  /// Degrees of freedom held at the start, 6 + dofs flags; empty means none.
  std::vector<bool> locked;

  [[nodiscard]] int dofCount() const { return 6 + model->dofCount(); }
};

/// A problem of a hand without contacts yet: bounds from the model, start and prior at rest.
PoseProblem makeProblem(std::shared_ptr<const hand::HandModel> model);

/// Sizes, finiteness, bounds in order, start inside its bounds within 1e-9, links in range,
/// normals of unit length within 1e-3, weights >= 0. InvalidInput names what is wrong.
void validate(const PoseProblem& problem);

}  // namespace handgraft::optimize
