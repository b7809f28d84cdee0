#pragma once

#include <vector>

#include <Eigen/Core>

namespace handgraft::optimize {

/// Cholesky factor of a symmetric positive definite matrix whose rows begin late, in memory
/// taken once.
///
/// Row i holds nothing before column first[i]; the factor keeps that envelope. With the joints
/// of a hand ordered finger by finger, tips first, and the root last, a finger's rows hold that
/// finger alone: 26 degrees of freedom cost a fifth of a dense factor.
class EnvelopeCholesky {
 public:
  explicit EnvelopeCholesky(int capacity);

  /// Begins a matrix of `size` rows; `first` and `at` give each row's first column and an entry
  /// of the lower triangle, `at(i, j)`, first[i] <= j <= i.
  ///
  /// False unless every pivot exceeds `kSmallestPivot` of its diagonal entry: the matrix is not
  /// positive definite, or not by enough to be solved with.
  template <class Entry>
  [[nodiscard]] bool factor(int size, const std::vector<int>& first, const Entry& at) {
    size_ = size;
    first_ = first.data();
    for (int i = 0; i < size; ++i) {
      double* row = rowOf(i);
      for (int j = first[static_cast<std::size_t>(i)]; j <= i; ++j)
        row[j] = at(i, j);
      if (!eliminate(i)) return false;
    }
    return true;
  }

  /// Solves in place; as many entries as the matrix has rows.
  void solve(double* x) const;

  static constexpr double kSmallestPivot = 1e-12;

 private:
  [[nodiscard]] bool eliminate(int row_index);

  double* rowOf(int i) { return rows_.data() + static_cast<std::ptrdiff_t>(i) * capacity_; }

  [[nodiscard]] const double* rowOf(int i) const {
    return rows_.data() + static_cast<std::ptrdiff_t>(i) * capacity_;
  }

  int capacity_ = 0;
  int size_ = 0;
  const int* first_ = nullptr;
  std::vector<double> rows_;
  std::vector<double> inverse_;  ///< of the diagonal
};

}  // namespace handgraft::optimize
