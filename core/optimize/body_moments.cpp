#include "core/optimize/body_moments.h"

#include <algorithm>

namespace handgraft::optimize {

namespace {

using Eigen::Matrix3d;
using Vector9d = Eigen::Matrix<double, 9, 1>;

/// tr(A) I - A: the inertia that belongs to second moments A.
Matrix3d inertiaOf(const Matrix3d& A) {
  Matrix3d result = -A;
  result.diagonal().array() += A.trace();
  return result;
}

/// Gauss-Newton matrix of sum w (1 + n.Rm)^2 by a turn, without the factor of two.
Matrix3d cosineInertia(const BodyMoments& moments, const Matrix3d& R) {
  // Column i: the change of vec(R) by a turn about axis i.
  Eigen::Matrix<double, 9, 3> turns;
  for (Eigen::Index j = 0; j < 3; ++j) {
    const Eigen::Vector3d r = R.col(j);
    turns.block<3, 3>(3 * j, 0) << 0.0, r.z(), -r.y(), -r.z(), 0.0, r.x(), r.y(), -r.x(), 0.0;
  }
  Eigen::Matrix<double, 9, 3> turn_stiffness;
  turn_stiffness.noalias() = moments.normal_normal.lazyProduct(turns);
  return turns.transpose().lazyProduct(turn_stiffness);
}

}  // namespace

void addAboutCentroids(const PointPair& pair, const Pose& X_BL, BodyMoments& moments) {
  const double w = pair.weight;
  const Eigen::Vector3d p = X_BL * pair.p_L - moments.p_B;
  const Eigen::Vector3d x = pair.p_W - moments.x_W;
  const Eigen::Vector3d m = X_BL.linear() * pair.n_L;
  moments.spread += w * (x.squaredNorm() + p.squaredNorm());
  moments.cross += w * x * p.transpose();
  moments.points += w * p * p.transpose();
  if (!pair.has_normals) return;
  moments.normal_weight += w;
  moments.squares += w * (pair.n_W.squaredNorm() + m.squaredNorm());
  moments.normals += w * m * m.transpose();
  const Matrix3d nm = pair.n_W * m.transpose();
  const Eigen::Map<const Vector9d> v(nm.data());
  moments.normal += w * nm;
  moments.normal_normal += w * v * v.transpose();
}

BodyTerms evaluate(const BodyMoments& moments,
                   const Matrix3d& R_WB,
                   const Eigen::Vector3d& centroid_W,
                   NormalForm form) {
  BodyTerms terms;
  // Eq. 3: W |c - x|^2 + sum w |x~ - R p~|^2. Sums of squares that rounding may push below
  // zero.
  terms.gap_W = centroid_W - moments.x_W;
  const double overlap = moments.cross.cwiseProduct(R_WB).sum();
  terms.distance = moments.weight * terms.gap_W.squaredNorm() +
                   std::max(0.0, moments.spread - 2.0 * overlap);

  const double cosines = moments.normal.cwiseProduct(R_WB).sum();
  if (form == NormalForm::kSum) {
    terms.normal = std::max(0.0, moments.squares + 2.0 * cosines);
    terms.normal_pull = moments.normal + R_WB.lazyProduct(moments.normals);
    return terms;
  }
  // Eq. 4: sum w (1 + <n m^T, R>)^2.
  const Eigen::Map<const Vector9d> r(R_WB.data());
  Eigen::Map<Vector9d> pull(terms.normal_pull.data());
  pull.noalias() = moments.normal_normal.lazyProduct(r);
  terms.normal = std::max(0.0, moments.normal_weight + 2.0 * cosines + pull.dot(r));
  terms.normal_pull += moments.normal;
  return terms;
}

BodyPull pullOf(const BodyMoments& moments,
                const Matrix3d& R_WB,
                const BodyTerms& terms,
                const Weights& weights,
                NormalForm form,
                bool with_inertia) {
  const double two_d = 2.0 * weights.distance;
  const double two_n = 2.0 * weights.normal;
  BodyPull pull;
  pull.force = two_d * moments.weight * terms.gap_W;

  // f of a point is 2 lambda_d w (R p~ - x~), of a normal 2 lambda_n w (1 + n.Rm) n or
  // 2 lambda_n w (Rm + n).
  const Matrix3d f_p =
      two_d * (R_WB.lazyProduct(moments.points) - moments.cross) + two_n * terms.normal_pull;
  pull.virial.noalias() = R_WB.lazyProduct(f_p.transpose());
  if (!with_inertia) return pull;

  Matrix3d in_B = two_d * inertiaOf(moments.points);
  if (form == NormalForm::kSum) in_B += two_n * inertiaOf(moments.normals);
  pull.inertia.noalias() = R_WB.lazyProduct((in_B.lazyProduct(R_WB.transpose())).eval());
  if (form == NormalForm::kCosine) pull.inertia += two_n * cosineInertia(moments, R_WB);
  return pull;
}

}  // namespace handgraft::optimize
