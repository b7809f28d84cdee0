#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/optimize/avoidance.h"

namespace handgraft::optimize {

struct Weights {
  /// Default units: 1e4 / m^2 makes 1 cm of distance weigh as much as a right angle between the
  /// normals (each 1 per point); the prior only breaks ties among poses that fit equally well.
  double distance = 1e4;
  double normal = 1.0;
  double prior = 1e-3;
};

/// What the normals' term of Eq. 2 sums.
enum class NormalForm {
  kCosine,  ///< (1 + n_h.n_o)^2, Eq. 4 of the paper; without slope where a hand is flipped
  kSum,     ///< |n_h + n_o|^2 = 2 (1 + n_h.n_o): a slope everywhere but exactly there
};

/// A pair of points to bring together, hand side in its link, object side in W.
struct PointPair {
  int link = 0;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::Zero();
  double weight = 1.0;
  int patch = -1;           ///< for reports; -1 when patches are not known
  bool has_normals = true;  ///< false: the normals count for nothing, and may be any
};

/// Everything Eq. 2-5 of the paper need.
///
/// Degrees of freedom are ordered root rotation (3), root translation (3), then the hand's
/// dofs. The root's bounds are infinite unless someone asks; bounds on its rotation are not
/// supported. A locked rotation about one or two axes holds those coordinates of the rotation
/// vector.
struct PoseProblem {
  std::shared_ptr<const hand::HandModel> model;
  std::vector<PointPair> pairs;
  Weights weights;
  NormalForm normal_form = NormalForm::kCosine;
  hand::HandPose start;
  hand::HandPose prior;
  Eigen::VectorXd lower;  ///< of the hand's dofs
  Eigen::VectorXd upper;
  Eigen::Vector3d root_lower =
      Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Vector3d root_upper =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  /// Multiplies the prior per degree of freedom, 6 + dofs entries; empty means all 1. The three
  /// of the rotation weigh the geodesic angle by their mean.
  Eigen::VectorXd prior_weights;
  /// Degrees of freedom held at the start, 6 + dofs flags; empty means none.
  std::vector<bool> locked;
  /// Missing: penetration costs nothing, as in the paper.
  std::shared_ptr<const Avoidance> avoidance;

  [[nodiscard]] int dofCount() const { return 6 + model->dofCount(); }
};

/// A problem of a hand without contacts yet: bounds from the model, start and prior at rest.
PoseProblem makeProblem(std::shared_ptr<const hand::HandModel> model);

/// Sizes, finiteness, start inside its bounds within 1e-9, links in range, normals of unit
/// length within 1e-3, weights >= 0. InvalidInput names what is wrong. Bounds that contradict
/// each other are no fault of form: `boundsContradict` tells, and a solve answers that it is
/// infeasible.
void validate(const PoseProblem& problem);

/// Some lower bound lies above its upper one: there is no pose to find.
bool boundsContradict(const PoseProblem& problem);

/// Name of a degree of freedom as problem files spell it: root_rx ... root_tz, then the joints.
std::string dofName(const PoseProblem& problem, int dof);

}  // namespace handgraft::optimize
