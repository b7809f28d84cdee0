#include "core/optimize/envelope_cholesky.h"

#include <algorithm>
#include <cmath>

namespace handgraft::optimize {

namespace {

/// Four sums at a time, so that they do not wait for one another.
double dot(const double* a, const double* b, int count) {
  double s0 = 0.0;
  double s1 = 0.0;
  double s2 = 0.0;
  double s3 = 0.0;
  int k = 0;
  for (; k + 4 <= count; k += 4) {
    s0 += a[k] * b[k];
    s1 += a[k + 1] * b[k + 1];
    s2 += a[k + 2] * b[k + 2];
    s3 += a[k + 3] * b[k + 3];
  }
  for (; k < count; ++k)
    s0 += a[k] * b[k];
  return (s0 + s1) + (s2 + s3);
}

}  // namespace

EnvelopeCholesky::EnvelopeCholesky(int capacity)
    : capacity_(capacity),
      rows_(static_cast<std::size_t>(capacity) * static_cast<std::size_t>(capacity)),
      inverse_(static_cast<std::size_t>(capacity)) {}

bool EnvelopeCholesky::eliminate(int row_index) {
  double* row = rowOf(row_index);
  const int begin = first_[row_index];
  for (int j = begin; j < row_index; ++j) {
    const int from = std::max(begin, first_[j]);
    const double* other = rowOf(j);
    row[j] = (row[j] - dot(row + from, other + from, j - from)) *
             inverse_[static_cast<std::size_t>(j)];
  }
  const double diagonal = row[row_index];
  const double pivot = diagonal - dot(row + begin, row + begin, row_index - begin);
  // Written so that a NaN fails, too.
  if (!(pivot > kSmallestPivot * diagonal) || !(pivot > 0.0)) return false;
  row[row_index] = std::sqrt(pivot);
  inverse_[static_cast<std::size_t>(row_index)] = 1.0 / row[row_index];
  return true;
}

void EnvelopeCholesky::solve(double* x) const {
  for (int i = 0; i < size_; ++i) {
    const double* row = rowOf(i);
    const int begin = first_[i];
    x[i] =
        (x[i] - dot(row + begin, x + begin, i - begin)) * inverse_[static_cast<std::size_t>(i)];
  }
  for (int i = size_ - 1; i >= 0; --i) {
    const double* row = rowOf(i);
    x[i] *= inverse_[static_cast<std::size_t>(i)];
    for (int j = first_[i]; j < i; ++j)
      x[j] -= row[j] * x[i];
  }
}

}  // namespace handgraft::optimize
