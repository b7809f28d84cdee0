#pragma once

#include <cstddef>
#include <set>
#include <string>

namespace handgraft::bridge {

/// Sessions of other hands that a bridge does not follow, as it tells of them.
class PassedOver {
 public:
  /// Whether that has to be said: once, since each edit there publishes its session anew.
  bool see(const std::string& text) {
    last_ = text;
    if (told_.size() >= kMost) told_.clear();
    return told_.insert(text).second;
  }

  /// Since the last pose; empty: none.
  [[nodiscard]] const std::string& last() const { return last_; }

  void forget() { last_.clear(); }

 private:
  static constexpr std::size_t kMost = 256;

  std::set<std::string> told_;
  std::string last_;
};

}  // namespace handgraft::bridge
