#include "core/optimize/envelope_cholesky.h"

#include <limits>
#include <random>

#include <Eigen/Cholesky>

#include <gtest/gtest.h>

namespace handgraft::optimize {
namespace {

/// Positive definite; rows of fingers of four meet their own finger alone, the last six all.
Eigen::MatrixXd handMatrix(int fingers, std::mt19937& random, std::vector<int>& first) {
  const int size = 4 * fingers + 6;
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(size, size);
  first.clear();
  for (int i = 0; i < size; ++i) {
    first.push_back(i < 4 * fingers ? i / 4 * 4 : 0);
    for (int j = first.back(); j <= i; ++j)
      L(i, j) = static_cast<double>(random()) / 4294967296.0 + (i == j ? 1.0 : -0.5);
  }
  return L * L.transpose();
}

TEST(EnvelopeCholesky, SolvesAsADenseFactorDoes) {
  std::mt19937 random(1);
  std::vector<int> first;
  EnvelopeCholesky factor(26);
  for (const int fingers : {0, 1, 5, 3}) {
    const Eigen::MatrixXd A = handMatrix(fingers, random, first);
    ASSERT_TRUE(factor.factor(static_cast<int>(A.rows()), first, [&A](int i, int j) {
      return A(i, j);
    }));
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1.0, 2.0);
    Eigen::VectorXd x = b;
    factor.solve(x.data());
    EXPECT_LE((x - A.llt().solve(b)).norm(), 1e-10 * x.norm()) << fingers;
    EXPECT_LE((A * x - b).norm(), 1e-12 * b.norm() * A.norm());
  }
}

TEST(EnvelopeCholesky, ReadsNothingOutsideTheEnvelope) {
  std::mt19937 random(2);
  std::vector<int> first;
  const Eigen::MatrixXd A = handMatrix(3, random, first);
  EnvelopeCholesky factor(static_cast<int>(A.rows()));
  EXPECT_TRUE(factor.factor(static_cast<int>(A.rows()), first, [&](int i, int j) {
    EXPECT_LE(first[static_cast<std::size_t>(i)], j);
    EXPECT_LE(j, i);
    return A(i, j);
  }));
}

TEST(EnvelopeCholesky, RefusesWhatIsNotPositiveDefinite) {
  const std::vector<int> first = {0, 0};
  EnvelopeCholesky factor(2);
  const auto is_positive = [&](const Eigen::Matrix2d& A) {
    return factor.factor(2, first, [&A](int i, int j) {
      return A(i, j);
    });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(is_positive((Eigen::Matrix2d() << 2, 1, 1, 2).finished()));
  EXPECT_FALSE(is_positive((Eigen::Matrix2d() << 1, 2, 2, 1).finished()));
  EXPECT_FALSE(is_positive((Eigen::Matrix2d() << 1, 1, 1, 1).finished()));
  EXPECT_FALSE(is_positive((Eigen::Matrix2d() << 1, 0, 0, 0).finished()));
  EXPECT_FALSE(is_positive((Eigen::Matrix2d() << 1, 0, 0, nan).finished()));
}

TEST(EnvelopeCholesky, AnswersAnEmptyMatrix) {
  EnvelopeCholesky factor(3);
  EXPECT_TRUE(factor.factor(0, {}, [](int, int) {
    return 0.0;
  }));
  factor.solve(nullptr);
}

}  // namespace
}  // namespace handgraft::optimize
