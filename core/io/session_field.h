#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/io/session_spelling.h"

namespace handgraft::io {

/// A value inside the text of a session and the way to it, for messages. Every call checks what
/// it reads. Errors of every call: InvalidInput naming the way.
class SessionField {
 public:
  SessionField(const nlohmann::ordered_json& value, std::string path)
      : value_(value), path_(std::move(path)) {}

  template <class... Args>
  [[noreturn]] void reject(fmt::format_string<Args...> format, Args&&... args) const {
    rejectInput("session: {}: {}", path_.empty() ? "the whole" : quoted(path_),
                fmt::format(format, std::forward<Args>(args)...));
  }

  [[nodiscard]] const SessionField* itselfIfObject() const {
    if (!value_.is_object()) reject("is {}; it must be an object", value_.type_name());
    return this;
  }

  [[nodiscard]] bool has(const char* key) const {
    return itselfIfObject()->value_.contains(key);
  }

  [[nodiscard]] SessionField operator[](const char* key) const {
    if (!has(key)) reject("has no field '{}'", key);
    return {value_[key], path_.empty() ? key : path_ + "." + key};
  }

  /// All fields of an object, in the order of the text.
  template <class Visitor>
  void each(const Visitor& visit) const {
    requireSize(itselfIfObject()->value_.size());
    for (const auto& [key, value] : value_.items())
      visit(key, SessionField(value, path_ + "." + key));
  }

  void requireOnly(const std::vector<std::string>& permitted) const {
    for (const auto& [key, value] : itselfIfObject()->value_.items()) {
      if (std::find(permitted.begin(), permitted.end(), key) == permitted.end()) {
        reject("field {} is unknown; permitted are {}", quoted(key), fmt::join(permitted, " "));
      }
    }
  }

  [[nodiscard]] std::size_t size() const {
    if (!value_.is_array()) reject("is {}; it must be a list", value_.type_name());
    requireSize(value_.size());
    return value_.size();
  }

  [[nodiscard]] SessionField at(std::size_t index) const {
    return {value_[index], fmt::format("{}[{}]", path_, index)};
  }

  [[nodiscard]] std::string text(std::size_t longest = kLongestText) const {
    if (!value_.is_string()) reject("is {}; it must be a string", value_.type_name());
    const auto& text = value_.get_ref<const std::string&>();
    if (text.size() > longest) reject("has {} bytes; permitted are {}", text.size(), longest);
    return text;
  }

  void read(bool& value) const {
    if (!value_.is_boolean()) reject("is {}; it must be true or false", value_.type_name());
    value = value_.get<bool>();
  }

  void read(double& value) const {
    if (value_.is_string() && (value_ == "inf" || value_ == "-inf")) {
      value = value_ == "inf" ? std::numeric_limits<double>::infinity()
                              : -std::numeric_limits<double>::infinity();
      return;
    }
    if (!value_.is_number()) reject("is {}; it must be a number", value_.type_name());
    value = value_.get<double>();
  }

  template <std::integral T>
  void read(T& value) const {
    const bool fits = value_.is_number_unsigned()
                          ? value_.get<std::uint64_t>() <=
                                static_cast<std::uint64_t>(std::numeric_limits<T>::max())
                          : value_.is_number_integer() && std::is_signed_v<T> &&
                                value_.get<std::int64_t>() >=
                                    static_cast<std::int64_t>(std::numeric_limits<T>::min());
    if (!fits) reject("is {}; it must be a whole number in range", shownValue());
    value = value_.get<T>();
  }

  void read(std::string& value) const { value = text(); }

  void read(session::Side& side) const { readEnumerator(kSides, side); }

  void read(optimize::NormalForm& form) const { readEnumerator(kNormalForms, form); }

  void read(optimize::Solver& solver) const { solver = optimize::solverFrom(text()); }

  void read(geometry::LogMapMethod& method) const {
    method = geometry::logMapMethodFrom(text());
  }

  void read(Pose& X) const {
    std::vector<double> numbers;
    read(numbers);
    if (numbers.size() != 12) reject("has {} numbers; a pose has 12", numbers.size());
    X = Pose::Identity();
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
    X.translation() = Eigen::Map<const Eigen::Vector3d>(numbers.data() + 9);
  }

  template <int Rows, int Columns>
  void read(Eigen::Matrix<double, Rows, Columns>& matrix) const {
    std::vector<double> numbers;
    read(numbers);
    if constexpr (Rows == Eigen::Dynamic) {
      matrix.resize(static_cast<Eigen::Index>(numbers.size()));
    } else if (numbers.size() != static_cast<std::size_t>(matrix.size())) {
      reject("has {} numbers; it must have {}", numbers.size(), matrix.size());
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto entry = static_cast<Eigen::Index>(i);
      matrix(entry / matrix.cols(), entry % matrix.cols()) = numbers[i];
    }
  }

  template <class T>
  void read(std::vector<T>& list) const {
    list.resize(size());
    for (std::size_t i = 0; i < list.size(); ++i)
      at(i).read(list[i]);
  }

  template <class T>
  void read(std::pair<std::size_t, T>& entry) const {
    if (size() != 2) reject("must be an index and a value");
    at(0).read(entry.first);
    at(1).read(entry.second);
  }

  void read(session::TimedChange& change) const {
    const std::string kind = (*this)["kind"].text();
    const auto found =
        std::find(session::kTimedKinds.begin(), session::kTimedKinds.end(), kind);
    if (found == session::kTimedKinds.end()) {
      (*this)["kind"].reject("is {}; permitted are {}", quoted(kind),
                             fmt::join(session::kTimedKinds, " "));
    }
    readChange<0>(static_cast<std::size_t>(found - session::kTimedKinds.begin()), change);
  }

  template <HasFields T>
  void read(T& value) const {
    std::vector<std::string> keys = {"kind"};  // which an edit has besides
    session::visitFields(value, [&](const char* key, auto& field) {
      keys.emplace_back(key);
      readField(key, field);
    });
    requireOnly(keys);
  }

 private:
  static constexpr std::size_t kMostEntries = 4096;  // of any list
  static constexpr std::size_t kLongestText = 4096;

  template <class T>
  void readField(const char* key, T& field) const {
    (*this)[key].read(field);
  }

  template <class T>
  void readField(const char* key, std::optional<T>& field) const {
    field.reset();
    if (has(key)) (*this)[key].read(field.emplace());
  }

  template <std::size_t Kind>
  void readChange(std::size_t kind, session::TimedChange& change) const {
    if constexpr (Kind < std::variant_size_v<session::TimedChange>) {
      if (kind != Kind) return readChange<Kind + 1>(kind, change);
      std::variant_alternative_t<Kind, session::TimedChange> read_change{};
      read(read_change);
      change = std::move(read_change);
    } else {
      throw BrokenContract("a kind of change that is not known");
    }
  }

  void readField(const char* key, std::vector<session::TimedEdit>& edits) const {
    edits.clear();
    if (has(key)) (*this)[key].read(edits);
  }

  template <class T>
  void readField(const char* key, std::vector<std::pair<std::size_t, T>>& entries) const {
    entries.clear();
    if (has(key)) (*this)[key].read(entries);
  }

  template <class Names, class T>
  void readEnumerator(const Names& names, T& value) const {
    const std::string name = text();
    for (const auto& [enumerator, spelled] : names) {
      if (name != spelled) continue;
      value = enumerator;
      return;
    }
    reject("is {}; permitted are '{}' and '{}'", quoted(name), names[0].second,
           names[1].second);
  }

  void requireSize(std::size_t size) const {
    if (size > kMostEntries) reject("has {} entries; permitted are {}", size, kMostEntries);
  }

  [[nodiscard]] std::string shownValue() const {
    return value_.is_structured() ? value_.type_name() : quoted(value_.dump());
  }

  const nlohmann::ordered_json& value_;
  std::string path_;
};

}  // namespace handgraft::io
