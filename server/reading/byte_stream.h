#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "core/base/error.h"

namespace handgraft::server {

/// Bytes of plain values one after another, for the same program on the same machine: no
/// alignment, no byte order.
class ByteWriter {
 public:
  template <class Number>
  void number(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    numbers(&value, 1);
  }

  template <class Number>
  void numbers(const Number* values, std::size_t count) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of plain numbers
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(Number));
  }

  void count(std::size_t things) { number(static_cast<std::uint64_t>(things)); }

  void text(std::string_view text) {
    count(text.size());
    bytes_.append(text);
  }

  /// Its columns, behind their number.
  template <class Matrix>
  void columns(const Matrix& matrix) {
    count(static_cast<std::size_t>(matrix.cols()));
    numbers(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// The way back, from bytes that nobody vouches for: every size is compared with what is left
/// before memory is taken. Errors of all methods: InvalidInput.
class ByteReader {
 public:
  /// `bytes` must outlive the reader.
  ByteReader(std::string_view bytes, int form) : left_(bytes), form_(form) {}

  /// Of what is read, which those who read it give numbers.
  [[nodiscard]] int form() const { return form_; }

  template <class Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>);
    Number value{};
    numbers(&value, 1);
    return value;
  }

  double finite() {
    const double value = number<double>();
    if (!(std::abs(value) <= std::numeric_limits<double>::max())) fail("a number not finite");
    return value;
  }

  bool flag() {
    const auto value = number<std::uint8_t>();
    if (value > 1) fail("a flag other than 0 and 1");
    return value == 1;
  }

  /// An enumerator from 0 to `last`.
  template <class Enumerator>
  Enumerator one(Enumerator last) {
    const auto value = number<std::uint8_t>();
    if (value > static_cast<std::uint8_t>(last)) fail("an enumerator that does not exist");
    return static_cast<Enumerator>(value);
  }

  /// A number of things, each of which takes at least `bytes_each` of what is left.
  std::size_t count(std::size_t most, std::size_t bytes_each) {
    const auto things = number<std::uint64_t>();
    if (things > most) fail("a list that is too long");
    if (things > left_.size() / bytes_each) fail("a list longer than what is left");
    return static_cast<std::size_t>(things);
  }

  std::string text(std::size_t most = std::numeric_limits<std::size_t>::max()) {
    const std::size_t size = count(most, 1);
    std::string text(left_.substr(0, size));
    left_.remove_prefix(size);
    return text;
  }

  template <class Number>
  void numbers(Number* values, std::size_t count) {
    if (count > left_.size() / sizeof(Number)) fail("an early end");
    if (count > 0) std::memcpy(values, left_.data(), count * sizeof(Number));
    left_.remove_prefix(count * sizeof(Number));
  }

  /// At most `most` columns of a matrix with a fixed number of rows, or entries of a vector
  /// that was written with its size.
  template <class Matrix>
  Matrix columns(std::size_t most) {
    using Number = typename Matrix::Scalar;
    constexpr int kRows = Matrix::RowsAtCompileTime;
    static_assert(kRows > 0);
    const std::size_t cols = count(most, kRows * sizeof(Number));
    Matrix matrix(kRows, static_cast<Eigen::Index>(cols));
    numbers(matrix.data(), static_cast<std::size_t>(matrix.size()));
    return matrix;
  }

  Eigen::Vector3d point() {
    Eigen::Vector3d p;
    for (double& coordinate : p)
      coordinate = finite();
    return p;
  }

  /// That what came is as it should be.
  static void require(bool fine, const char* what) {
    if (!fine) fail(what);
  }

  void requireEnd() const {
    if (!left_.empty()) fail("more than it should hold");
  }

 private:
  [[noreturn]] static void fail(const char* what) {
    rejectInput("what the reader sent is damaged: {}", what);
  }

  std::string_view left_;
  int form_;
};

}  // namespace handgraft::server
