#pragma once

#include <chrono>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "core/base/error.h"

namespace handgraft::config {

/// Everything that is wrong with a file, each with its key and what is permitted.
using Problems = std::vector<std::string>;

/// A map in a YAML file, read key by key. What is wrong is noted and reading goes on with a
/// value that is permitted, so that one run tells everything. `finish` names the keys that
/// nobody asked for: a misspelt key must not count as an absent one.
class Section {
 public:
  /// `path` is what problems call it; empty for the file itself. `node` may be anything.
  Section(const YAML::Node& node, std::string path, Problems& problems);

  /// The whole text of a file. Notes a syntax error as a problem.
  static Section parse(const std::string& text, Problems& problems);

  [[nodiscard]] bool has(const std::string& key);

  /// A finite number in [least, most]; without a `standard` the key must be there.
  double number(const std::string& key,
                double least,
                double most,
                std::optional<double> standard = std::nullopt);
  int integer(const std::string& key,
              int least,
              int most,
              std::optional<int> standard = std::nullopt);

  /// Whole milliseconds.
  std::chrono::milliseconds duration(const std::string& key,
                                     int least,
                                     int most,
                                     std::chrono::milliseconds standard) {
    return std::chrono::milliseconds(
        integer(key, least, most, static_cast<int>(standard.count())));
  }

  std::string text(const std::string& key,
                   const std::optional<std::string>& standard = std::nullopt);
  bool flag(const std::string& key, bool standard);
  /// `count` numbers; any number of them if it is 0.
  std::vector<double> numbers(const std::string& key,
                              std::size_t count,
                              double least,
                              double most);

  template <class Value>
  Value choice(const std::string& key,
               const std::vector<std::pair<const char*, Value>>& choices,
               std::optional<Value> standard = std::nullopt) {
    std::string names;
    const std::optional<std::string> chosen = scalar(key, !standard.has_value());
    for (const auto& [name, value] : choices) {
      if (chosen == name) return value;
      names += (names.empty() ? "" : ", ") + std::string(name);
    }
    if (chosen) object(key, handgraft::quoted(*chosen) + " is not one of " + names);
    return standard ? *standard : choices.begin()->second;
  }

  /// A map; an empty one if it is absent and may be.
  Section section(const std::string& key, bool is_required);
  /// A list of `least` to `most` maps.
  std::vector<Section> list(const std::string& key, std::size_t least, std::size_t most);

  /// Whether `key` was noted as wrong or missing.
  [[nodiscard]] bool isWrong(const std::string& key) const;

  /// Notes that `key` is wrong.
  void object(const std::string& key, const std::string& what);

  /// Keys that may be there though nobody asks for them: what they mean is not known.
  void allow(std::initializer_list<const char*> keys) {
    asked_.insert(keys.begin(), keys.end());
  }

  /// Notes every key that was not asked for.
  void finish();

 private:
  [[nodiscard]] std::string pathOf(const std::string& key) const;
  std::optional<YAML::Node> find(const std::string& key, bool is_required);
  std::optional<std::string> scalar(const std::string& key, bool is_required);
  static std::string quotedText(const std::string& text);

  YAML::Node node_;
  std::string path_;
  Problems* problems_;
  std::set<std::string> asked_;
};

}  // namespace handgraft::config
