#include "core/optimize/align_root.h"

#include <algorithm>

#include <Eigen/SVD>

#include "core/base/error.h"

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

/// `wanted` as far as bounds and locks allow.
Eigen::Vector3d centeredRoot(const PoseProblem& problem, const Eigen::Vector3d& wanted) {
  Eigen::Vector3d root_W = problem.start.X_WH.translation();
  for (int i = 0; i < 3; ++i) {
    if (isLocked(problem, 3 + i) || problem.root_lower[i] > problem.root_upper[i]) continue;
    root_W[i] = std::clamp(wanted[i], problem.root_lower[i], problem.root_upper[i]);
  }
  return root_W;
}

}  // namespace

Pose alignRoot(const PoseProblem& problem,
               const MomentTree& tree,
               const Eigen::VectorXd& q,
               double normal_length_m) {
  if (!(normal_length_m >= 0.0)) {
    rejectInput("alignment: the normals' length {} m must be at least 0", normal_length_m);
  }
  HANDGRAFT_REQUIRE(q.size() == problem.model->dofCount());
  std::vector<BodyPlace> places(static_cast<std::size_t>(tree.bodyCount()));
  placeBodies(tree, Eigen::Matrix3d::Identity(), q, places);
  const auto centroid_of = [&places](const BodyMoments& moments) -> Eigen::Vector3d {
    const BodyPlace& place = places[static_cast<std::size_t>(moments.body)];
    return place.p_HB_W + place.R_WB * moments.p_B;
  };

  // === Weighted centroids of both sides
  double weight = 0.0;
  Eigen::Vector3d center_H = Eigen::Vector3d::Zero();
  Eigen::Vector3d center_W = Eigen::Vector3d::Zero();
  for (const BodyMoments& moments : tree.moments) {
    weight += moments.weight;
    center_H += moments.weight * centroid_of(moments);
    center_W += moments.weight * moments.x_W;
  }
  Pose X_WH = problem.start.X_WH;
  if (weight <= 0.0) return X_WH;
  center_H /= weight;
  center_W /= weight;

  // === Rotation, unless part of it is held
  if (!isLocked(problem, 0) && !isLocked(problem, 1) && !isLocked(problem, 2)) {
    const double normal_weight = normal_length_m * normal_length_m;
    Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
    for (const BodyMoments& moments : tree.moments) {
      const Eigen::Matrix3d& R_HB = places[static_cast<std::size_t>(moments.body)].R_WB;
      const Eigen::Vector3d arm_H = centroid_of(moments) - center_H;
      B += moments.weight * (moments.x_W - center_W) * arm_H.transpose();
      B += (moments.cross - normal_weight * moments.normal) * R_HB.transpose();
    }
    // What the pairs leave open stays as it is at the start: a pull too weak to be felt
    // otherwise.
    constexpr double kPull = 1e-10;
    const double scale = std::max(B.norm(), weight * 1e-12);
    X_WH.linear() = nearestRotation(B + kPull * scale * problem.start.X_WH.linear());
  }
  X_WH.translation() = centeredRoot(problem, center_W - X_WH.linear() * center_H);
  return X_WH;
}

Pose alignRoot(const PoseProblem& problem, const Eigen::VectorXd& q, double normal_length_m) {
  return alignRoot(problem, makeMomentTree(problem), q, normal_length_m);
}

Pose turnRoot(const PoseProblem& problem,
              const MomentTree& tree,
              const Pose& X_WH,
              const Eigen::Matrix3d& R) {
  if (isLocked(problem, 0) || isLocked(problem, 1) || isLocked(problem, 2)) return X_WH;
  double weight = 0.0;
  Eigen::Vector3d center_W = Eigen::Vector3d::Zero();
  for (const BodyMoments& moments : tree.moments) {
    weight += moments.weight;
    center_W += moments.weight * moments.x_W;
  }
  if (weight <= 0.0) return X_WH;
  center_W /= weight;
  Pose turned = X_WH;
  turned.linear() = R * X_WH.linear();
  turned.translation() = centeredRoot(problem, center_W + R * (X_WH.translation() - center_W));
  return turned;
}

}  // namespace handgraft::optimize
