#include "core/manipulation/band_system.h"

namespace handgraft::manipulation {

namespace {

/// block += the coupling, as a matrix.
void addTo(Eigen::MatrixXd& block, const Coupling& coupling) {
  block.topLeftCorner<3, 3>() += coupling.turn;
  block.diagonal().tail(coupling.others.size()) += coupling.others;
}

}  // namespace

BandSystem::BandSystem(std::size_t frames, int dofs)
    : own(frames, Eigen::MatrixXd::Zero(dofs, dofs)),
      next(frames, Coupling(dofs)),
      after_next(frames, Coupling(dofs)),
      right(frames, Eigen::VectorXd::Zero(dofs)) {}

bool BandCholesky::solve(const BandSystem& system, std::vector<Eigen::VectorXd>& solution) {
  const std::size_t frames = system.own.size();
  factors_.resize(frames);
  by_next_.resize(frames);
  by_after_next_.resize(frames);
  solution = system.right;
  for (std::size_t k = 0; k < frames; ++k) {
    // === A_kk = sum of L_kj L_kj^T over j = k - 2, k - 1, k
    block_ = system.own[k];
    const Eigen::Index dofs = block_.rows();
    if (k >= 1) {
      block_.selfadjointView<Eigen::Lower>().rankUpdate(by_next_[k - 1], -1.0);
      solution[k].noalias() -= by_next_[k - 1] * solution[k - 1];
    }
    if (k >= 2) {
      block_.selfadjointView<Eigen::Lower>().rankUpdate(by_after_next_[k - 2], -1.0);
      solution[k].noalias() -= by_after_next_[k - 2] * solution[k - 2];
    }
    factors_[k].compute(block_);
    if (factors_[k].info() != Eigen::Success) return false;
    const auto lower = factors_[k].matrixL();
    lower.solveInPlace(solution[k]);
    if (k + 1 < frames) {
      Eigen::MatrixXd& below = by_next_[k];
      below.setZero(dofs, dofs);
      if (k >= 1) below.noalias() = -by_after_next_[k - 1] * by_next_[k - 1].transpose();
      addTo(below, system.next[k]);
      lower.transpose().solveInPlace<Eigen::OnTheRight>(below);
    }
    if (k + 2 < frames) {
      Eigen::MatrixXd& below = by_after_next_[k];
      below.setZero(dofs, dofs);
      addTo(below, system.after_next[k]);
      lower.transpose().solveInPlace<Eigen::OnTheRight>(below);
    }
  }
  for (std::size_t k = frames; k-- > 0;) {
    if (k + 1 < frames) solution[k].noalias() -= by_next_[k].transpose() * solution[k + 1];
    if (k + 2 < frames)
      solution[k].noalias() -= by_after_next_[k].transpose() * solution[k + 2];
    factors_[k].matrixU().solveInPlace(solution[k]);
  }
  return true;
}

}  // namespace handgraft::manipulation
