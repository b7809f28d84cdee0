#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace handgraft::bench {

/// What a command measured: times by what they are of, and figures; told as a table or as one
/// JSON line.
class LiveReport {
 public:
  /// `name` is that of the command.
  explicit LiveReport(std::string name) : name_(std::move(name)) {}

  /// Begins a block of times; what follows belongs to it.
  void begin(const std::string& block);
  /// In ms; nothing if there are none.
  void times(const std::string& what, const std::vector<double>& ms);
  void figure(const std::string& what, double value, const std::string& unit = "");
  /// Such as a count of refusals by their message.
  void counts(const std::string& what, const std::map<std::string, long>& of);

  void print(bool as_json) const;

 private:
  std::string name_;
  std::string block_;
  std::string text_;
  nlohmann::ordered_json json_;
};

}  // namespace handgraft::bench
