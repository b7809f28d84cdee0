#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/session/edit.h"
#include "core/session/history.h"

namespace handgraft::session {

/// A solve whose answer was taken: the change it made, by value, so that playing the log needs
/// no clock and no solver, and with what it was asked for, so that it can be solved again.
struct CommittedSolve {
  SolverSettings solving;
  double objective = 0.0;
  DocumentChange change;
  /// Whether it is a step to undo (History::commit). Missing in logs of before this was asked:
  /// there it is one where it comes before any edit.
  std::optional<bool> is_step;
};

/// A solve that ended without an answer; it changed nothing.
struct CancelledSolve {};

/// The session's motion was solved so; the answer is none of the document's. Who opens the
/// session again solves it again.
struct FollowedMotion {
  bool causal = false;
  double smoothness = 0.0;
  double fade_s = 0.0;
  double acceleration_limit = 0.0;  ///< 0: none
  int starts = 0;
  unsigned seed = 0;
};

using LogEntry =
    std::variant<Edit, std::shared_ptr<const CommittedSolve>, CancelledSolve, FollowedMotion>;

/// Where a log begins.
struct LogStart {
  History history;
  unsigned long long revision = 0;
};

/// What happened in a session, in order: at least the last kMostEntries / 2 things, since its
/// beginning where that is not longer ago. Kept as bytes: a few hundred an edit and its solve.
class Log {
 public:
  Log() = default;

  explicit Log(LogStart first) : first_(std::move(first)) {}

  Log(LogStart first, const std::vector<LogEntry>& entries);

  /// `after` is where the session stands now: a long log goes on from there.
  void add(const LogEntry& entry, const History& after, unsigned long long revision);

  [[nodiscard]] const LogStart& first() const { return first_; }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }

  /// All of them, made of their bytes.
  [[nodiscard]] std::vector<LogEntry> entries() const;

 private:
  LogStart first_;
  std::deque<std::string> entries_;  ///< by `packed`
  LogStart middle_;                  ///< the state after the first `middle_count_` entries
  std::size_t middle_count_ = 0;     ///< 0: none yet
};

inline constexpr std::size_t kMostEntries = 1024;

}  // namespace handgraft::session
