#include "core/optimize/search_chart.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "core/base/error.h"

namespace handgraft::optimize {

SearchChart makeSearchChart(const Eigen::VectorXd& center,
                            const Eigen::MatrixXd& H,
                            const Eigen::VectorXd& lower,
                            const Eigen::VectorXd& upper,
                            double objective) {
  const Eigen::Index count = center.size();
  HANDGRAFT_REQUIRE(H.rows() == count && H.cols() == count);
  HANDGRAFT_REQUIRE(lower.size() == count && upper.size() == count);

  // Share of a coordinate's own stiffness that is added to it: keeps what no pair holds in
  // reach.
  constexpr double kRegularisation = 1e-6;
  const double floor = std::max(1e-9 * H.diagonal().maxCoeff(), 1e-12);
  Eigen::MatrixXd K = H;
  K.diagonal() = H.diagonal().cwiseMax(floor) * (1.0 + kRegularisation);

  std::vector<Eigen::Index> unbounded;
  std::vector<Eigen::Index> bounded;
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool open = std::isinf(lower[i]) && std::isinf(upper[i]);
    (open ? unbounded : bounded).push_back(i);
  }
  const double scale = std::sqrt(objective);

  SearchChart chart;
  chart.center = center;
  chart.basis = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd follow(unbounded.size(), bounded.size());  // H_UU^-1 H_UB
  Eigen::MatrixXd K_BB = K(bounded, bounded);
  if (!unbounded.empty()) {
    // Unit diagonal first: metres and radians differ by orders of magnitude.
    const Eigen::VectorXd unit = K.diagonal()(unbounded).cwiseSqrt().cwiseInverse();
    const Eigen::LLT<Eigen::MatrixXd> factor(unit.asDiagonal() * K(unbounded, unbounded) *
                                             unit.asDiagonal());
    HANDGRAFT_REQUIRE(factor.info() == Eigen::Success);
    const Eigen::MatrixXd whitened =
        factor.matrixU().solve(Eigen::MatrixXd::Identity(factor.rows(), factor.cols()));
    chart.basis(unbounded, unbounded) = scale * (unit.asDiagonal() * whitened);
    if (!bounded.empty()) {  // Eigen's solve of no column at all touches a null pointer
      follow =
          unit.asDiagonal() * factor.solve(unit.asDiagonal() * K(unbounded, bounded)).eval();
      K_BB -= K(bounded, unbounded) * follow;
    }
  }
  for (std::size_t b = 0; b < bounded.size(); ++b) {
    const auto column = static_cast<Eigen::Index>(b);
    // Of what stays when the root follows; the difference may cancel to nothing.
    const double stiffness =
        std::max({K_BB(column, column), kRegularisation * K(bounded[b], bounded[b]), floor});
    const double step = scale / std::sqrt(stiffness);
    chart.basis(bounded[b], bounded[b]) = step;
    for (std::size_t u = 0; u < unbounded.size(); ++u) {
      chart.basis(unbounded[u], bounded[b]) =
          -step * follow(static_cast<Eigen::Index>(u), column);
    }
  }

  chart.lower = lower - center;
  chart.upper = upper - center;
  for (const Eigen::Index i : bounded) {
    chart.lower[i] = std::min(0.0, chart.lower[i] / chart.basis(i, i));
    chart.upper[i] = std::max(0.0, chart.upper[i] / chart.basis(i, i));
  }
  return chart;
}

}  // namespace handgraft::optimize
