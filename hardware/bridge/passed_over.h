#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::bridge {

/// Sessions that a bridge does not follow, as it tells of them.
class PassedOver {
 public:
  static std::string ofAnotherHand(std::uint64_t session,
                                   const std::string& its_hand,
                                   const std::string& ours) {
    return fmt::format(
        "session {} is of hand {}, this one is {}: passed over; if it is the same hand, its "
        "config and its calibration have to say hand: {}",
        session, quoted(its_hand), quoted(ours), quoted(its_hand));
  }

  /// A server took it out of its store.
  static std::string asItWasKept(std::uint64_t session) {
    return fmt::format(
        "session {0} stands as it was kept: passed over until somebody edits, solves or plays "
        "it, or it is named (--session {0})",
        session);
  }

  /// Somebody was followed there, and has gone.
  static std::string leftByDemonstrator(std::uint64_t session) {
    return fmt::format(
        "session {} stands where its demonstrator left it: passed over until somebody follows, "
        "edits, solves or plays it",
        session);
  }

  /// It streams, and began to before the one that is followed.
  static std::string besideAnother(std::uint64_t session, std::uint64_t followed) {
    return fmt::format(
        "session {0} streams, too: passed over, since session {1} began to after it; to follow "
        "it, close session {1} or name it (--session {0})",
        session, followed);
  }

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
