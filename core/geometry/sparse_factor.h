#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/SparseCholesky>

namespace handgraft::geometry {

/// A Hermitian positive definite matrix A as L D L^H, kept so that a solution is computed only
/// where it is asked for: a sparse right-hand side reaches, and an entry of the solution
/// depends on, nothing but ancestors in the elimination tree of L.
///
/// Source: Gilbert & Peierls 1988, "Sparse Partial Pivoting in Time Proportional to Arithmetic
///   Operations"; Davis 2006, "Direct Methods for Sparse Linear Systems", section 3.2.
template <class Scalar>
class SparseFactor {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// Reads the lower triangle; false if A is not positive definite within rounding.
  bool factor(const Matrix& lower) {
    Eigen::SimplicialLDLT<Matrix> factor(lower);
    if (factor.info() != Eigen::Success) return false;
    lower_ = factor.matrixL().nestedExpression();
    lower_.makeCompressed();
    place_of_ = factor.permutationP().indices();
    diagonal_ = factor.vectorD().real();
    return diagonal_.allFinite() && (diagonal_.array() > 0.0).all();
  }

  /// x with A x = b at the entries `wanted` (all of them if it is empty); zero elsewhere, but
  /// for entries that were computed on the way. Cost: the columns of L above nonzeros of b and
  /// above wanted entries.
  [[nodiscard]] Vector solve(const Vector& b, const std::vector<char>& wanted = {}) const {
    const Eigen::Index n = lower_.cols();
    Vector x = Vector::Zero(n);
    std::vector<char> marks(static_cast<std::size_t>(n), 0);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (b[i] == Scalar(0)) continue;
      x[place_of_[i]] = b[i];
      markAncestors(place_of_[i], marks);
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      if (!marks[j]) continue;
      const Scalar known = x[j];
      for (typename Matrix::InnerIterator entry(lower_, j); entry; ++entry)
        x[entry.row()] -= entry.value() * known;
      x[j] = known / diagonal_[j];
    }

    std::fill(marks.begin(), marks.end(), wanted.empty() ? 1 : 0);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (wanted[i]) markAncestors(place_of_[i], marks);
    }
    for (Eigen::Index j = n - 1; j >= 0; --j) {
      if (!marks[j]) continue;
      Scalar sum = x[j];
      for (typename Matrix::InnerIterator entry(lower_, j); entry; ++entry)
        sum -= Eigen::numext::conj(entry.value()) * x[entry.row()];
      x[j] = sum;
    }
    Vector result(n);
    for (Eigen::Index i = 0; i < n; ++i)
      result[i] = marks[place_of_[i]] ? x[place_of_[i]] : Scalar(0);
    return result;
  }

 private:
  /// A column's parent in the elimination tree is its first row below the diagonal.
  void markAncestors(int j, std::vector<char>& marks) const {
    while (!marks[j]) {
      marks[j] = 1;
      const auto first = lower_.outerIndexPtr()[j];
      if (first == lower_.outerIndexPtr()[j + 1]) return;
      j = lower_.innerIndexPtr()[first];
    }
  }

  Matrix lower_;  ///< L without its unit diagonal
  Eigen::VectorXi place_of_;
  Eigen::VectorXd diagonal_;
};

}  // namespace handgraft::geometry
