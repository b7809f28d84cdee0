#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace handgraft::manipulation {

/// How two frames meet in the Hessian of a motion: joint by joint and axis by axis, but for the
/// root's rotation, whose three turn together.
struct Coupling {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();  ///< later frame x earlier one
  Eigen::VectorXd others;                          ///< of the degrees of freedom behind

  explicit Coupling(int dofs = 3) : others(Eigen::VectorXd::Zero(dofs - 3)) {}

  void reset() {
    turn.setZero();
    others.setZero();
  }
};

/// A symmetric system in which each frame meets the next two: blocks of `dofs` rows a frame.
struct BandSystem {
  BandSystem(std::size_t frames, int dofs);

  std::vector<Eigen::MatrixXd> own;    ///< of each frame, both triangles
  std::vector<Coupling> next;          ///< entry k: frame k + 1 by frame k
  std::vector<Coupling> after_next;    ///< entry k: frame k + 2 by frame k
  std::vector<Eigen::VectorXd> right;  ///< what it is to equal
};

/// Solves such systems by a block Cholesky factorisation, and keeps its scratch memory.
///
/// A frame's columns of L are one panel: its own block, the next frame's, that of the one after
/// next, one below the other, each padded to a multiple of four.
/// Cost: about 3 dofs^3 multiplications a frame, and memory for 3 blocks of dofs^2; both linear
/// in the frames.
class BandCholesky {
 public:
  /// False unless `system` is positive definite. `solution` has an entry a frame.
  [[nodiscard]] bool solve(const BandSystem& system, std::vector<Eigen::VectorXd>& solution);

 private:
  std::vector<double> panels_;  ///< by columns
};

}  // namespace handgraft::manipulation
