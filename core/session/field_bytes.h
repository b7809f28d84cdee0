#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/session/fields.h"

// Everything that has fields as bytes, and back: compared to the byte, and kept in little room.
// For memory alone: numbers as they lie there, nothing that would tell a wrong reader.
namespace handgraft::session {

/// Bytes that are equal for equal values of a type alone.
class FieldWriter {
 public:
  template <class T>
  void add(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      addRaw(&value, sizeof(value));
    } else {
      visitFields(value, [this](const char*, const auto& field) {
        this->add(field);
      });
    }
  }

  void add(const std::string& text) {
    addCount(text.size());
    bytes_ += text;
  }

  void add(const Pose& X) {
    for (int column = 0; column < 4; ++column)
      addRaw(X.matrix().col(column).data(), 3 * sizeof(double));
  }

  template <int Rows, int Columns>
  void add(const Eigen::Matrix<double, Rows, Columns>& matrix) {
    if constexpr (Rows == Eigen::Dynamic) addCount(static_cast<std::size_t>(matrix.size()));
    addRaw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }

  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }

  template <class T>
  void add(const std::vector<T>& list) {
    addCount(list.size());
    for (const T& entry : list)
      add(entry);
  }

  template <class... Ts>
  void add(const std::variant<Ts...>& value) {
    addCount(value.index());
    std::visit(
        [this](const auto& one) {
          this->add(one);
        },
        value);
  }

  template <class T>
  void add(const std::pair<std::size_t, T>& entry) {
    addCount(entry.first);
    add(entry.second);
  }

  /// In no more room than they take.
  std::string take() {
    bytes_.shrink_to_fit();
    return std::move(bytes_);
  }

 private:
  /// Seven bits a byte, the lowest first; the eighth says that more follow.
  void addCount(std::size_t count) {
    for (; count >= 0x80; count >>= 7U)
      bytes_ += static_cast<char>(0x80 | (count & 0x7F));
    bytes_ += static_cast<char>(count);
  }

  void addRaw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

/// Reads what a FieldWriter wrote, in the same order. Errors: BrokenContract at their end.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void read(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      readRaw(&value, sizeof(value));
    } else {
      visitFields(value, [this](const char*, auto& field) {
        this->read(field);
      });
    }
  }

  void read(std::string& text) {
    const std::size_t size = count();
    HANDGRAFT_REQUIRE(size <= bytes_.size());
    text = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
  }

  void read(Pose& X) {
    X = Pose::Identity();
    for (int column = 0; column < 4; ++column)
      readRaw(X.matrix().col(column).data(), 3 * sizeof(double));
  }

  template <int Rows, int Columns>
  void read(Eigen::Matrix<double, Rows, Columns>& matrix) {
    if constexpr (Rows == Eigen::Dynamic) {
      const std::size_t size = count();
      HANDGRAFT_REQUIRE(size <= bytes_.size() / sizeof(double));
      matrix.resize(static_cast<Eigen::Index>(size));
    }
    readRaw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }

  template <class T>
  void read(std::optional<T>& value) {
    bool is_there = false;
    read(is_there);
    value.reset();
    if (is_there) read(value.emplace());
  }

  template <class T>
  void read(std::vector<T>& list) {
    const std::size_t size = count();
    HANDGRAFT_REQUIRE(size <= bytes_.size());  // none is smaller than a byte
    list.resize(size);
    for (T& entry : list)
      read(entry);
  }

  template <class... Ts>
  void read(std::variant<Ts...>& value) {
    readAlternative<0>(count(), value);
  }

  template <class T>
  void read(std::pair<std::size_t, T>& entry) {
    entry.first = count();
    read(entry.second);
  }

  template <class T>
  T value() {
    T result{};
    read(result);
    return result;
  }

 private:
  template <std::size_t Index, class Variant>
  void readAlternative(std::size_t index, Variant& value) {
    if constexpr (Index < std::variant_size_v<Variant>) {
      if (index != Index) return readAlternative<Index + 1>(index, value);
      read(value.template emplace<Index>());
    } else {
      throw BrokenContract("an alternative that is not there");
    }
  }

  std::size_t count() {
    std::size_t result = 0;
    for (unsigned shift = 0;; shift += 7) {
      const auto byte = value<unsigned char>();
      result |= static_cast<std::size_t>(byte & 0x7FU) << shift;
      if (byte < 0x80) return result;
    }
  }

  void readRaw(void* data, std::size_t size) {
    HANDGRAFT_REQUIRE(size <= bytes_.size());
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
};

}  // namespace handgraft::session
