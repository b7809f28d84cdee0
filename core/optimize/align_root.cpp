#include <algorithm>

#include <Eigen/SVD>

#include "core/base/error.h"
#include "core/optimize/solver.h"

namespace handgraft::optimize {

namespace {

/// The proper rotation R that maximises <R, B>.
/// Source: Umeyama 1991, "Least-squares estimation of transformation parameters".
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& B) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

bool isLocked(const PoseProblem& problem, int dof) {
  return !problem.locked.empty() && problem.locked[static_cast<std::size_t>(dof)];
}

}  // namespace

Pose alignRoot(const PoseProblem& problem, const Eigen::VectorXd& q, double normal_length_m) {
  if (!(normal_length_m >= 0.0)) {
    rejectInput("alignment: the normals' length {} m must be at least 0", normal_length_m);
  }
  hand::LinkPoses X_HL;
  forwardKinematics(*problem.model, Pose::Identity(), q, X_HL);

  // === Weighted centroids of both sides
  double weight = 0.0;
  Eigen::Vector3d center_H = Eigen::Vector3d::Zero();
  Eigen::Vector3d center_W = Eigen::Vector3d::Zero();
  for (const PointPair& pair : problem.pairs) {
    HANDGRAFT_REQUIRE(pair.link >= 0 && pair.link < problem.model->linkCount());
    weight += pair.weight;
    center_H += pair.weight * (X_HL[static_cast<std::size_t>(pair.link)] * pair.p_L);
    center_W += pair.weight * pair.p_W;
  }
  Pose X_WH = problem.start.X_WH;
  if (weight <= 0.0) return X_WH;
  center_H /= weight;
  center_W /= weight;

  // === Rotation, unless part of it is held
  if (!isLocked(problem, 0) && !isLocked(problem, 1) && !isLocked(problem, 2)) {
    const double normal_weight = normal_length_m * normal_length_m;
    Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
    for (const PointPair& pair : problem.pairs) {
      const Pose& X = X_HL[static_cast<std::size_t>(pair.link)];
      const Eigen::Vector3d arm_H = X * pair.p_L - center_H;
      B += pair.weight * (pair.p_W - center_W) * arm_H.transpose();
      B -= pair.weight * normal_weight * pair.n_W * (X.linear() * pair.n_L).transpose();
    }
    // What the pairs leave open stays as it is at the start: a pull too weak to be felt
    // otherwise.
    constexpr double kPull = 1e-10;
    const double scale = std::max(B.norm(), weight * 1e-12);
    X_WH.linear() = nearestRotation(B + kPull * scale * problem.start.X_WH.linear());
  }

  // === Translation brings the centroids together, as far as bounds and locks allow
  const Eigen::Vector3d wanted = center_W - X_WH.linear() * center_H;
  for (int i = 0; i < 3; ++i) {
    if (isLocked(problem, 3 + i) || problem.root_lower[i] > problem.root_upper[i]) continue;
    X_WH.translation()[i] = std::clamp(wanted[i], problem.root_lower[i], problem.root_upper[i]);
  }
  return X_WH;
}

}  // namespace handgraft::optimize
