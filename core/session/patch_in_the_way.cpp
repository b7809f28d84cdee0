#include "core/session/patch_in_the_way.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/diagnosis.h"
#include "core/session/derived_state.h"

namespace handgraft::session {
namespace {

constexpr int kFewestMissed = 2;  // where one is missed, it is that one
constexpr std::size_t kMostAsked = 12;
// Of recorded grasps the short search has the right one among these (DECISIONS.md).
constexpr std::size_t kMostTried = 6;

/// Patches that a pose reaches, as its verdicts tell them.
int countReached(const optimize::PoseProblem& problem,
                 const optimize::SolveReport& report,
                 const std::vector<int>& never_reached) {
  std::set<int> reached;
  for (const optimize::PointPair& pair : problem.pairs)
    if (pair.patch >= 0 && pair.weight > 0.0) reached.insert(pair.patch);
  for (const int patch : optimize::missedPatches(problem, report))
    reached.erase(patch);
  for (const int patch : never_reached)
    reached.erase(patch);
  return static_cast<int>(reached.size());
}

/// Solves of documents that differ by what is switched off.
class Tries {
 public:
  Tries(const Session& session,
        const std::vector<int>& never_reached,
        int threads,
        const Progress& progress)
      : derived_(session.aside()),
        in_full_(session.document().solving),
        after_edit_(afterEdit(in_full_)),
        never_reached_(never_reached),
        threads_(threads),
        progress_(progress, {}) {
    // From more than by default no fewer are reached (DerivedState::solve); they may take
    // minutes.
    for (SolverSettings* solving : {&in_full_, &after_edit_})
      solving->starts = std::min(solving->starts, optimize::kDefaultStarts);
  }

  /// As what somebody asks for, or nothing where no patch has a point.
  std::optional<Solution> solve(const Document& document) {
    return solve(document, in_full_, false);
  }

  /// As what answers an edit.
  std::optional<Solution> solveAfterEdit(const Document& document) {
    const bool follows = document.start_is_known;
    return solve(document, follows ? after_edit_ : in_full_, follows);
  }

  /// None where the hand ended inside of the object.
  [[nodiscard]] int reachedBy(const std::optional<Solution>& solution) const {
    if (!solution) return 0;
    const optimize::SolveReport& report = solution->report;
    if (failedPatches(solution->problem, report) == std::ssize(report.patches)) return 0;
    return countReached(solution->problem, report, never_reached_);
  }

 private:
  std::optional<Solution> solve(const Document& document,
                                const SolverSettings& solving,
                                bool places_stay) {
    progress_.checkpoint();
    derived_.follow(document, progress_);
    SolveRun run;
    run.threads = threads_;
    run.places_stay = places_stay;
    try {
      return derived_.solve(solving, run, progress_);
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
  }

  DerivedState derived_;
  SolverSettings in_full_;
  SolverSettings after_edit_;
  const std::vector<int>& never_reached_;
  int threads_;
  const Progress progress_;  ///< tells nobody: whoever waits knows of one pose alone
};

/// A patch switched off, and what follows that edit.
struct WithoutOne {
  int patch = -1;
  Document document;
  Document answered;  ///< by the short search
  int reached = 0;
  double objective = 0.0;
};

std::vector<WithoutOne> withoutEach(const Document& document,
                                    const std::vector<int>& asked,
                                    Tries& tries) {
  std::vector<WithoutOne> all;
  for (const int patch : asked) {
    WithoutOne one;
    one.patch = patch;
    one.document = document;
    one.document.patches[static_cast<std::size_t>(patch)].enabled = false;
    one.document.is_solved = false;
    std::optional<Solution> solution = tries.solveAfterEdit(one.document);
    if (!solution) continue;
    one.reached = tries.reachedBy(solution);
    one.objective = solution->report.terms.objective;
    one.answered = std::move(solution->document);
    all.push_back(std::move(one));
  }
  std::stable_sort(all.begin(), all.end(), [](const WithoutOne& a, const WithoutOne& b) {
    return std::pair(-a.reached, a.objective) < std::pair(-b.reached, b.objective);
  });
  if (all.size() > kMostTried) all.resize(kMostTried);
  return all;
}

}  // namespace

PatchInTheWay patchInTheWay(const Session& session,
                            const optimize::PoseProblem& problem,
                            const optimize::SolveReport& report,
                            const std::vector<int>& never_reached,
                            int threads,
                            const Progress& progress) {
  if (report.outcome == optimize::Outcome::kInfeasible) return {};  // whoever is asked
  std::vector<int> asked;
  for (std::size_t i = 0; i < session.patches().size(); ++i) {
    const SessionPatch& item = session.patches()[i];
    if (item.placement && item.patch.weight > 0.0) asked.push_back(static_cast<int>(i));
  }
  const auto asked_count = static_cast<int>(asked.size());
  const int now = countReached(problem, report, never_reached);
  if (asked_count - now < kFewestMissed || asked.size() > kMostAsked) return {};

  PatchInTheWay best;
  Tries tries(session, never_reached, threads, progress);
  // What a solve with all of them brings as well is nobody's fault: the pose may be the answer
  // to an edit, and a second search goes on where the first one ended.
  best.reached = std::max(now, tries.reachedBy(tries.solve(session.document())));
  best.others = asked_count - 1;
  if (best.reached >= best.others) return {};
  for (const WithoutOne& one : withoutEach(session.document(), asked, tries)) {
    int reached = tries.reachedBy(tries.solve(one.document));
    // Whoever switches it off sees the answer to that edit first, and a solve goes on there.
    if (reached > best.reached)
      reached = std::min(reached, tries.reachedBy(tries.solve(one.answered)));
    if (reached <= best.reached) continue;
    best.patch = one.patch;
    best.reached = reached;
    if (reached == best.others) break;
  }
  return best.patch < 0 ? PatchInTheWay() : best;
}

}  // namespace handgraft::session
