#pragma once

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// All point pairs of one rigid body (a link and what is fixed to it), collapsed:
/// its points move together, so that the sums of Eq. 3 and 4 over them are polynomials in the
/// body's pose whose coefficients never change.
///
/// With pair weights w, hand side p, m (point, normal, in B), object side x, n (in W); the
/// second moments are taken about the weighted centroids, which keeps all digits where the fit
/// is good.
struct BodyMoments {
  int body = 0;
  double weight = 0.0;                                ///< sum w
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();      ///< centroid of p
  Eigen::Vector3d x_W = Eigen::Vector3d::Zero();      ///< centroid of x
  double spread = 0.0;                                ///< sum w (|x~|^2 + |p~|^2), m^2
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();    ///< sum w x~ p~^T
  Eigen::Matrix3d points = Eigen::Matrix3d::Zero();   ///< sum w p~ p~^T
  double normal_weight = 0.0;                         ///< sum w of the pairs with normals
  double squares = 0.0;                               ///< sum w (|n|^2 + |m|^2)
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();   ///< sum w n m^T
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();  ///< sum w m m^T
  /// sum w vec(n m^T) vec(n m^T)^T, columns first.
  Eigen::Matrix<double, 9, 9> normal_normal = Eigen::Matrix<double, 9, 9>::Zero();
};

/// One pair's part of the sums whose centroids are known already.
void addAboutCentroids(const PointPair& pair, const Pose& X_BL, BodyMoments& moments);

/// One body's part of Eq. 3 and 4, unweighted, and what their derivatives are made of.
struct BodyTerms {
  double distance = 0.0;
  double normal = 0.0;
  Eigen::Vector3d gap_W =
      Eigen::Vector3d::Zero();  ///< from the object's centroid to the hand's
  /// sum w r m^T with half the derivative r of `normal` by each turned normal Rm:
  /// (1 + n.Rm) n, or Rm + n.
  Eigen::Matrix3d normal_pull = Eigen::Matrix3d::Zero();
};

/// `centroid_W` is that of the hand's points. Cost: about 150 multiplications, whatever
/// the number of pairs.
BodyTerms evaluate(const BodyMoments& moments,
                   const Eigen::Matrix3d& R_WB,
                   const Eigen::Vector3d& centroid_W,
                   NormalForm form);

/// First and second derivatives of one body's weighted part of Eq. 3 and 4, about its centroid,
/// in W. With f the derivative by each point's position (or normal), a the point (or normal):
struct BodyPull {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< sum f
  Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();  ///< sum a f^T
  /// Gauss-Newton matrix of a turn about the centroid. That of a shift is
  /// 2 lambda_d weight times the identity, and the two are independent.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// sum a x f of the points whose sum a f^T is given.
inline Eigen::Vector3d torqueOf(const Eigen::Matrix3d& virial) {
  return {virial(1, 2) - virial(2, 1), virial(2, 0) - virial(0, 2),
          virial(0, 1) - virial(1, 0)};
}

BodyPull pullOf(const BodyMoments& moments,
                const Eigen::Matrix3d& R_WB,
                const BodyTerms& terms,
                const Weights& weights,
                NormalForm form,
                bool with_inertia);

}  // namespace handgraft::optimize
