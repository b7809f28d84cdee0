#pragma once

#include <Eigen/Core>

namespace handgraft::optimize {

/// Variables x in which an objective of theta is well conditioned: theta = center + basis x.
///
/// With H the Gauss-Newton matrix at the center, U the unbounded coordinates (the free root)
/// and B the bounded ones (joints), x_B is theta_B scaled by the Schur complement's diagonal,
/// so that boxes stay boxes, and x_U the whitened rest of theta_U after it has followed theta_B
/// as H asks:
///   theta_U = c_U - H_UU^-1 H_UB (theta_B - c_B) + s L^-T x_U,  H_UU = L L^T.
/// Bending a finger then moves the root along with it, which costs nothing; in the coordinates
/// themselves a solver has to crawl along that valley. All is scaled by s = sqrt(objective), so
/// that the function over the objective is of the order of one, with curvature one.
struct SearchChart {
  Eigen::VectorXd center;
  Eigen::MatrixXd basis;
  Eigen::VectorXd lower;  ///< of x, contains 0
  Eigen::VectorXd upper;
};

/// Shapes: all of n entries, H n x n, symmetric, positive semidefinite (it is regularised where
/// it is singular). `center` inside [lower, upper], which may be infinite. Cost: O(n^3).
SearchChart makeSearchChart(const Eigen::VectorXd& center,
                            const Eigen::MatrixXd& H,
                            const Eigen::VectorXd& lower,
                            const Eigen::VectorXd& upper,
                            double objective);

}  // namespace handgraft::optimize
