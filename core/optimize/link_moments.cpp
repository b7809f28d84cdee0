#include "core/optimize/link_moments.h"

#include <algorithm>

namespace handgraft::optimize {

namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

/// sum_j R_j x G_j over columns: the moment of a function of R whose derivative by R is G.
Eigen::Vector3d momentOf(const Eigen::Matrix3d& R, const Eigen::Matrix3d& G) {
  return R.col(0).cross(G.col(0)) + R.col(1).cross(G.col(1)) + R.col(2).cross(G.col(2));
}

}  // namespace

std::vector<LinkMoments> collectMoments(const PoseProblem& problem) {
  std::vector<LinkMoments> by_link(static_cast<std::size_t>(problem.model->linkCount()));
  for (const PointPair& pair : problem.pairs) {
    LinkMoments& m = by_link[static_cast<std::size_t>(pair.link)];
    m.weight += pair.weight;
    m.p_L += pair.weight * pair.p_L;
    m.x_W += pair.weight * pair.p_W;
  }
  for (std::size_t link = 0; link < by_link.size(); ++link) {
    LinkMoments& m = by_link[link];
    m.link = static_cast<int>(link);
    if (m.weight <= 0.0) continue;
    m.p_L /= m.weight;
    m.x_W /= m.weight;
  }
  for (const PointPair& pair : problem.pairs) {
    LinkMoments& m = by_link[static_cast<std::size_t>(pair.link)];
    const double w = pair.weight;
    const Eigen::Vector3d p = pair.p_L - m.p_L;
    const Eigen::Vector3d x = pair.p_W - m.x_W;
    m.spread += w * (x.squaredNorm() + p.squaredNorm());
    m.cross += w * x * p.transpose();
    m.inertia += w * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
    const Eigen::Matrix3d nm = pair.n_W * pair.n_L.transpose();
    const Eigen::Map<const Vector9d> v(nm.data());
    m.normal += w * nm;
    m.normal_normal += w * v * v.transpose();
  }
  std::erase_if(by_link, [](const LinkMoments& m) {
    return m.weight <= 0.0;
  });
  return by_link;
}

LinkTerms evaluate(const LinkMoments& moments, const Pose& X_WL, const Weights& weights) {
  const Eigen::Matrix3d R = X_WL.linear();
  LinkTerms terms;
  terms.centroid_W = X_WL * moments.p_L;

  // Eq. 3: W |c - x|^2 + sum w |x~ - R p~|^2. Sums of squares that rounding may push below
  // zero.
  const Eigen::Vector3d gap = terms.centroid_W - moments.x_W;
  const double overlap = moments.cross.cwiseProduct(R).sum();
  terms.distance =
      moments.weight * gap.squaredNorm() + std::max(0.0, moments.spread - 2.0 * overlap);

  // Eq. 4: sum w (1 + <n m^T, R>)^2.
  const Eigen::Map<const Vector9d> r(R.data());
  Eigen::Matrix3d K_R;
  Eigen::Map<Vector9d> k(K_R.data());
  k.noalias() = moments.normal_normal * r;
  terms.normal =
      std::max(0.0, moments.weight + 2.0 * moments.normal.cwiseProduct(R).sum() + k.dot(r));

  terms.force = 2.0 * weights.distance * moments.weight * gap;
  const Eigen::Matrix3d G =
      -2.0 * weights.distance * moments.cross + 2.0 * weights.normal * (moments.normal + K_R);
  terms.moment = momentOf(R, G);
  return terms;
}

Matrix6d gaussNewtonOf(const LinkMoments& moments, const Pose& X_WL, const Weights& weights) {
  const Eigen::Matrix3d R = X_WL.linear();
  // Column i: the change of vec(R) by a turn about axis i.
  Eigen::Matrix<double, 9, 3> turns;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Matrix3d change = crossMatrix(Eigen::Vector3d::Unit(i)) * R;
    turns.col(i) = Eigen::Map<const Vector9d>(change.data());
  }
  Matrix6d H = Matrix6d::Zero();
  H.topLeftCorner<3, 3>() =
      2.0 * weights.distance * R * moments.inertia * R.transpose() +
      2.0 * weights.normal * turns.transpose() * moments.normal_normal * turns;
  H.bottomRightCorner<3, 3>().diagonal().setConstant(2.0 * weights.distance * moments.weight);
  return H;
}

}  // namespace handgraft::optimize
