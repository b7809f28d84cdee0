#include "core/manipulation/band_system.h"

#include <cmath>

#include "core/geometry/wide.h"

namespace handgraft::manipulation {

namespace {

using Eigen::Index;
using geometry::Lanes;

constexpr Index kLanes = 4;

/// The same in memory, wherever it begins. No memcpy: what that copies by halves is waited for.
using LanesThere = double __attribute__((vector_size(32), aligned(8), may_alias));

/// c -= a b^T: four columns of c, as many times four rows as kStrips says. All three are parts
/// of matrices by columns, `stride` apart.
template <int kStrips>
[[gnu::always_inline]] inline void subtractStrips(
    const double* a, const double* b, double* c, Index depth, Index stride) {
  Lanes sums[kLanes][kStrips];
#pragma GCC unroll 4
  for (int j = 0; j < kLanes; ++j)
#pragma GCC unroll 2
    for (int i = 0; i < kStrips; ++i)
      sums[j][i] = reinterpret_cast<const LanesThere*>(c + j * stride)[i];
  for (Index k = 0; k < depth; ++k) {
    const auto* const of_a = reinterpret_cast<const LanesThere*>(a + k * stride);
    const double* const of_b = b + k * stride;
#pragma GCC unroll 4
    for (int j = 0; j < kLanes; ++j)
#pragma GCC unroll 2
      for (int i = 0; i < kStrips; ++i)
        sums[j][i] -= of_a[i] * of_b[j];
  }
#pragma GCC unroll 4
  for (int j = 0; j < kLanes; ++j)
#pragma GCC unroll 2
    for (int i = 0; i < kStrips; ++i)
      reinterpret_cast<LanesThere*>(c + j * stride)[i] = sums[j][i];
}

/// The same for so many rows, a multiple of four.
HANDGRAFT_WIDE void subtractProduct(
    const double* a, const double* b, double* c, Index rows, Index depth, Index stride) {
  Index row = 0;
  for (; row + 2 * kLanes <= rows; row += 2 * kLanes)
    subtractStrips<2>(a + row, b, c + row, depth, stride);
  if (row < rows) subtractStrips<1>(a + row, b, c + row, depth, stride);
}

/// The panel's own columns of L. False unless its upper square is positive definite.
bool factorise(double* panel, Index columns, Index rows) {
  for (Index first = 0; first < columns; first += kLanes) {
    double* const block = panel + first * rows + first;
    subtractProduct(panel + first, panel + first, block, rows - first, first, rows);
    for (Index j = 0; j < kLanes; ++j) {
      Eigen::Map<Eigen::VectorXd> column(block + j * rows, rows - first);
      for (Index k = 0; k < j; ++k)
        column -= block[k * rows + j] *
                  Eigen::Map<const Eigen::VectorXd>(block + k * rows, rows - first);
      const double pivot = column[j];
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
      column /= std::sqrt(pivot);
    }
  }
  return true;
}

/// block += the coupling, as a matrix.
template <class Block>
void addTo(Block&& block, const Coupling& coupling) {
  block.template topLeftCorner<3, 3>() += coupling.turn;
  block.diagonal().tail(coupling.others.size()) += coupling.others;
}

/// From a frame's panel what the two before it leave there.
template <class Panel>
void subtractFramesBefore(const Panel& panel, std::size_t k, Index columns, Index rows) {
  for (Index first = 0; first < columns; first += kLanes) {
    double* const own = panel(k) + first * rows + first;
    if (k >= 1) {
      const double* const before = panel(k - 1) + columns + first;
      subtractProduct(before, before, own, 2 * columns - first, columns, rows);
    }
    if (k >= 2) {
      const double* const before = panel(k - 2) + 2 * columns + first;
      subtractProduct(before, before, own, columns - first, columns, rows);
    }
  }
}

}  // namespace

BandSystem::BandSystem(std::size_t frames, int dofs)
    : own(frames, Eigen::MatrixXd::Zero(dofs, dofs)),
      next(frames, Coupling(dofs)),
      after_next(frames, Coupling(dofs)),
      right(frames, Eigen::VectorXd::Zero(dofs)) {}

bool BandCholesky::solve(const BandSystem& system, std::vector<Eigen::VectorXd>& solution) {
  solution = system.right;
  if (solution.empty()) return true;
  const std::size_t frames = system.own.size();
  const Index dofs = system.own.front().rows();
  const Index columns = (dofs + kLanes - 1) / kLanes * kLanes;
  const Index rows = 3 * columns;
  const auto panel = [&](std::size_t frame) {
    return panels_.data() + static_cast<Index>(frame) * rows * columns;
  };
  // L of frame `row` by frame `column`, at most two behind.
  const auto block = [&](std::size_t row, std::size_t column) {
    return Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
        panel(column) + static_cast<Index>(row - column) * columns, dofs, dofs,
        Eigen::OuterStride<>(rows));
  };
  panels_.assign(frames * static_cast<std::size_t>(rows * columns), 0.0);

  for (std::size_t k = 0; k < frames; ++k) {
    block(k, k) = system.own[k];
    for (Index pad = dofs; pad < columns; ++pad)
      panel(k)[pad * rows + pad] = 1.0;
    if (k + 1 < frames) addTo(block(k + 1, k), system.next[k]);
    if (k + 2 < frames) addTo(block(k + 2, k), system.after_next[k]);
    subtractFramesBefore(panel, k, columns, rows);
    if (!factorise(panel(k), columns, rows)) return false;
    if (k >= 1) solution[k].noalias() -= block(k, k - 1) * solution[k - 1];
    if (k >= 2) solution[k].noalias() -= block(k, k - 2) * solution[k - 2];
    block(k, k).triangularView<Eigen::Lower>().solveInPlace(solution[k]);
  }
  for (std::size_t k = frames; k-- > 0;) {
    if (k + 1 < frames) solution[k].noalias() -= block(k + 1, k).transpose() * solution[k + 1];
    if (k + 2 < frames) solution[k].noalias() -= block(k + 2, k).transpose() * solution[k + 2];
    block(k, k).triangularView<Eigen::Lower>().transpose().solveInPlace(solution[k]);
  }
  return true;
}

}  // namespace handgraft::manipulation
