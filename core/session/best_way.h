#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/progress.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

struct Solution;

/// Tries ways to lay a document's patches: which of them lacks least when it is solved, that is
/// fewest patches dropped or missed, of as many fewest dropped, then the least objective; of a
/// motion at all of its frames that count. Ways are documents of the same hand, object and
/// contacts.
///
/// What a full search finds is kept: a way that is asked about again is not solved again, and
/// the one that is taken need not be solved once more. Deterministic, whatever was tried before
/// and on any number of threads (Models::threads). Errors: Cancelled on wish. Cost: 10 to 20 ms
/// a short search, a full one as a solve.
class WayTrials {
 public:
  /// `models` must outlive it.
  explicit WayTrials(const Models& models);
  ~WayTrials();

  WayTrials(const WayTrials&) = delete;
  WayTrials& operator=(const WayTrials&) = delete;

  /// The best by a short search of each, and where none of them reaches all patches by a full
  /// one of each, since the short one is no guide then (DECISIONS.md); `until_all`: until one
  /// does, in the order that the short ones gave.
  std::size_t best(const std::vector<Document>& laid, bool until_all, const Progress& progress);

  /// The same by full searches alone: where ways differ by what they drop, the short one leaves
  /// out what would be reached. A way that cannot lack less than one before it is not looked
  /// at.
  std::size_t bestSolved(const std::vector<Document>& laid, const Progress& progress);

  /// The best of them by short searches alone, best first, `most` at most. To leave ways out
  /// that are not worth a full one.
  std::vector<std::size_t> likely(const std::vector<Document>& laid,
                                  std::size_t most,
                                  const Progress& progress);

  /// Patches that are laid and that a full search misses.
  std::ptrdiff_t missedBySearch(const Document& laid, const Progress& progress);

  /// What a full search of that very document came to; null if there was none, and for motions.
  [[nodiscard]] std::shared_ptr<const Solution> solutionOf(const Document& laid) const;

 private:
  class Problems;

  /// What comes of a way.
  struct Outcome {
    /// Patches that are missed or dropped, those that are dropped, and the objective: less is
    /// better. Of as many, what is missed may be reached yet, what is dropped never.
    std::tuple<std::ptrdiff_t, std::ptrdiff_t, double> lack;
    bool reaches_all = false;                  ///< of what is laid
    std::shared_ptr<const Solution> solution;  ///< null of a motion, or if no point is left
  };

  struct Way {
    std::size_t index = 0;
    const Document* document = nullptr;
    Outcome worst;  ///< nothing of what is laid is reached
    std::optional<Outcome> tried;
    std::string asked_by;  ///< of full searches: all that they depend on
  };

  [[nodiscard]] std::vector<Way> waysOf(std::span<const Document> laid) const;
  template <class Solve>
  Outcome outcomeOf(const Document& laid, const Solve& solve);
  template <class Solve>
  void tryAll(std::vector<Way>& ways, bool until_all, const Solve& solve);
  template <class Solve>
  void judge(std::vector<Way>& ways, bool until_all, const Solve& solve);
  void judgeShortly(std::vector<Way>& ways, const Progress& progress);
  void judgeInFull(std::vector<Way>& ways, bool until_all, const Progress& progress);

  const Models& models_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Problems>> idle_;  ///< that no thread works on
  std::vector<Way> known_;                       ///< by full searches
};

}  // namespace handgraft::session
