#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// All point pairs of one link, collapsed (DESIGN 3.3): its points move together, so that the
/// sums of Eq. 3 and 4 over them are polynomials in the link's pose whose coefficients never
/// change.
///
/// With pair weights w, hand side p, m (point, normal, in L), object side x, n (in W); the
/// second moments are taken about the weighted centroids, which keeps all digits where the fit
/// is good.
struct LinkMoments {
  int link = 0;
  double weight = 0.0;                                ///< sum w
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();      ///< centroid of p
  Eigen::Vector3d x_W = Eigen::Vector3d::Zero();      ///< centroid of x
  double spread = 0.0;                                ///< sum w (|x~|^2 + |p~|^2), m^2
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();    ///< sum w x~ p~^T
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< sum w (|p~|^2 I - p~ p~^T), in L
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();   ///< sum w n m^T
  /// sum w vec(n m^T) vec(n m^T)^T, columns first.
  Eigen::Matrix<double, 9, 9> normal_normal = Eigen::Matrix<double, 9, 9>::Zero();
};

/// The moments of every link that has pairs of positive weight, by rising link number.
/// Cost: O(pairs + links).
std::vector<LinkMoments> collectMoments(const PoseProblem& problem);

/// One link's part of Eq. 3 and 4, unweighted, and the wrench that its weighted sum exerts: the
/// derivative by the link's position (`force`) and by a turn about its centroid (`moment`), in
/// W.
struct LinkTerms {
  double distance = 0.0;
  double normal = 0.0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Vector3d centroid_W = Eigen::Vector3d::Zero();
};

/// Cost: about 200 multiplications, whatever the number of pairs.
LinkTerms evaluate(const LinkMoments& moments, const Pose& X_WL, const Weights& weights);

/// Gauss-Newton matrix of one link's weighted part of Eq. 3 and 4: rows and columns 0-2 a turn
/// about its centroid, 3-5 its position, both in W. Positive semidefinite.
using Matrix6d = Eigen::Matrix<double, 6, 6>;
Matrix6d gaussNewtonOf(const LinkMoments& moments, const Pose& X_WL, const Weights& weights);

}  // namespace handgraft::optimize
