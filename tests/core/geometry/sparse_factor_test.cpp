#include "core/geometry/sparse_factor.h"

#include <complex>
#include <random>

#include <Eigen/Dense>

#include <gtest/gtest.h>

namespace handgraft::geometry {
namespace {

using Complex = std::complex<double>;

/// A random sparse Hermitian matrix with a heavy diagonal; dense, for the oracle.
Eigen::MatrixXcd makeHermitian(int n) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Zero(n, n);
  for (int entry = 0; entry < 3 * n; ++entry) {
    const auto i = static_cast<int>(random() % n);
    const auto j = static_cast<int>(random() % n);
    if (i == j) continue;
    matrix(i, j) = Complex(uniform(random), uniform(random));
    matrix(j, i) = std::conj(matrix(i, j));
  }
  for (int i = 0; i < n; ++i)
    matrix(i, i) = 1.0 + matrix.col(i).cwiseAbs().sum();
  return matrix;
}

TEST(SparseFactor, SolvesWhereItIsAsked) {
  constexpr int kSize = 60;
  const Eigen::MatrixXcd matrix = makeHermitian(kSize);
  SparseFactor<Complex> factor;
  const Eigen::MatrixXcd lower = matrix.triangularView<Eigen::Lower>();
  ASSERT_TRUE(factor.factor(lower.sparseView()));
  Eigen::VectorXcd b = Eigen::VectorXcd::Zero(kSize);
  b[7] = Complex(1.0, 2.0);
  b[31] = Complex(-0.5, 0.25);
  const Eigen::VectorXcd truth = matrix.ldlt().solve(b);
  EXPECT_LT((factor.solve(b) - truth).norm(), 1e-13);
  for (int wanted = 0; wanted < kSize; ++wanted) {
    std::vector<char> one(kSize, 0);
    one[wanted] = 1;
    EXPECT_LT(std::abs(factor.solve(b, one)[wanted] - truth[wanted]), 1e-13) << wanted;
  }
}

TEST(SparseFactor, GivesZeroForZero) {
  SparseFactor<double> factor;
  Eigen::SparseMatrix<double> identity(4, 4);
  identity.setIdentity();
  ASSERT_TRUE(factor.factor(identity));
  EXPECT_TRUE(factor.solve(Eigen::VectorXd::Zero(4)).isZero(0.0));
}

TEST(SparseFactor, TellsWhatIsNotPositiveDefinite) {
  SparseFactor<double> factor;
  Eigen::SparseMatrix<double> matrix(3, 3);
  matrix.insert(0, 0) = 1.0;
  matrix.insert(1, 1) = -1.0;
  matrix.insert(2, 2) = 1.0;
  EXPECT_FALSE(factor.factor(matrix));
}

}  // namespace
}  // namespace handgraft::geometry
