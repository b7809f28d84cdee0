#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/session/edit.h"
#include "core/session/history.h"

namespace handgraft::session {

/// A solve whose answer was taken: the change it made, by value, so that playing the log needs
/// no clock and no solver, and with what it was asked for, so that it can be solved again.
struct CommittedSolve {
  Solving solving;
  double objective = 0.0;
  DocumentChange change;
};

/// A solve that ended without an answer; it changed nothing.
struct CancelledSolve {};

using LogEntry = std::variant<Edit, std::shared_ptr<const CommittedSolve>, CancelledSolve>;

/// Where a log begins.
struct LogStart {
  History history;
  unsigned long long revision = 0;
};

/// What happened in a session, in order: at least the last kMostEntries / 2 things, since its
/// beginning where that is not longer ago.
class Log {
 public:
  Log() = default;

  explicit Log(LogStart first) : first_(std::move(first)) {}

  Log(LogStart first, std::vector<LogEntry> entries);

  /// `after` is where the session stands now: a long log goes on from there.
  void add(LogEntry entry, const History& after, unsigned long long revision);

  [[nodiscard]] const LogStart& first() const { return first_; }

  [[nodiscard]] const std::vector<LogEntry>& entries() const { return entries_; }

 private:
  LogStart first_;
  std::vector<LogEntry> entries_;
  LogStart middle_;               ///< the state after the first `middle_count_` entries
  std::size_t middle_count_ = 0;  ///< 0: none yet
};

inline constexpr std::size_t kMostEntries = 1024;

}  // namespace handgraft::session
