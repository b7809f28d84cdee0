// How a document is solved: the paper's solve, and what is found anew about it.
#include "core/session/derived_state_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/avoiding_solve.h"
#include "core/optimize/diagnosis.h"
#include "core/optimize/minima.h"
#include "core/optimize/pose_solver.h"
#include "core/placement/hand_pose_guess.h"
#include "core/placement/place_slider.h"
#include "core/placement/solids.h"

namespace handgraft::session {
namespace {

using optimize::Minimum;
using optimize::PoseProblem;
using optimize::SolveOptions;
using optimize::SolveReport;

constexpr std::size_t kTriedPlacements = 4;  // laid out and solved in full
constexpr int kTrialEvaluations = 300;
constexpr int kRefinements = 2;

// Of searches that are begun again where none of the patches is reached.
constexpr int kStartsAnew[] = {8, 32};

constexpr int kAgainFewer = 4;  // starts, of a search that goes where one has been

// Of a patch of which the segment alone is known: so far round it from the pad.
constexpr double kAside = 1.0;  // rad
// Of one whose direction nobody knows: so far from where the first search began with it.
constexpr double kTurns[] = {0.5 * std::numbers::pi, -0.5 * std::numbers::pi,
                             std::numbers::pi};  // rad

// An answer of another beginning must not be deeper inside than this, unless the first one is.
constexpr double kDeep = 0.0015;  // m

// Drafts are laid in full once they are chosen: until then, steps that promise less than this
// share of the objective are not worth their while.
constexpr double kDraftPromise = 1e-4;

// Square root of the charged sum of squared depths. A hand that only presses on comes to less;
// a finger through a wall, or a hand on its wrong side, to 2.4 mm and more.
constexpr double kInside = 0.002;  // m

// Of each stage of a step on the way that is not the last one (optimize/avoiding_solve.h).
constexpr int kStepEvaluations = 8;

/// A whole search, not what follows an edit.
bool searchesWidely(const SolveOptions& options) {
  return options.starts > optimize::kFewStarts;
}

}  // namespace

SolveOptions stepOf(SolveOptions options) {
  options.starts = 1;
  options.max_evaluations = std::min(options.max_evaluations, kStepEvaluations);
  return options;
}

bool isInside(const SolveReport& solved) {
  return solved.terms.penetration > kInside * kInside;
}

std::ptrdiff_t failedPatches(const PoseProblem& posed, const SolveReport& solved) {
  const auto all = std::ssize(solved.patches);
  if (isInside(solved)) return all;
  return std::ssize(optimize::missedPatches(posed, solved));
}

bool reachesNothing(const PoseProblem& posed, const SolveReport& solved) {
  std::set<int> asked;
  for (const optimize::PointPair& pair : posed.pairs)
    if (pair.patch >= 0 && pair.weight > 0.0) asked.insert(pair.patch);
  if (asked.empty()) return false;
  for (const int missed : optimize::missedPatches(posed, solved))
    asked.erase(missed);
  return asked.empty();
}

std::pair<std::ptrdiff_t, double> worthOf(const Solution& solution) {
  const auto dropped = std::count_if(solution.patches.begin(), solution.patches.end(),
                                     [](const SessionPatch& item) {
                                       return !item.placement && item.patch.weight > 0.0;
                                     });
  return {dropped + failedPatches(solution.problem, solution.report),
          costOf(solution.problem, solution.report)};
}

/// While it lives, patches are laid as drafts: half of a slide's time went into exact charts.
struct DerivedState::Drafts {
  explicit Drafts(DerivedState& owner) : derived(owner) { derived.uses_drafts_ = true; }

  ~Drafts() { derived.uses_drafts_ = false; }

  Drafts(const Drafts&) = delete;
  Drafts& operator=(const Drafts&) = delete;

  DerivedState& derived;
};

/// The same search from other roots and directions: where the slides end depends on where they
/// began.
struct DerivedState::NewBeginnings {
  DerivedState& derived;
  const Search& as_it_was;
  const SolverSettings& solving;
  const SolveOptions& options;
  const Progress& progress;

  /// What the best answer by now is worth, itself, and the minima from which it went on.
  struct Best {
    Worth worth;
    SolveReport& report;
    std::vector<Minimum>& found;
  };

  /// Puts a better answer, if there is one, in place of the report and what it was found from.
  void improve(SolveReport& report, std::vector<Minimum>& found) const {
    Best best{derived.worthOf(report, solving), report, found};
    beginElsewhere(std::max(optimize::kFewStarts + 1, options.starts / kAgainFewer), best);
    // Among many starts those that touch through walls crowd out others: fewer find what more
    // have lost.
    for (const int starts : kStartsAnew) {
      if (best.worth.first < std::ssize(report.patches)) break;
      if (starts >= options.starts) continue;
      beginAgain(
          [](const std::vector<int>&) {
            return true;
          },
          starts, best);
      beginElsewhere(starts, best);
    }
  }

 private:
  void beginElsewhere(int starts, Best& best) const {
    beginAgain(
        [&](const std::vector<int>&) {
          return derived.takeRootsByLength();
        },
        starts, best);
    for (const double around_rad : {kAside, -kAside}) {
      beginAgain(
          [&](const std::vector<int>& missed) {
            return derived.takeRootsAround(missed, around_rad);
          },
          starts, best);
    }
    for (const double turn_rad : kTurns) {
      beginAgain(
          [&](const std::vector<int>& missed) {
            return derived.turnDirections(missed, turn_rad);
          },
          starts, best);
    }
  }

  /// Once, while patches are missed. `take_roots` gets those, and moves the roots as they were
  /// before the first search; false if there are none to move.
  template <class TakeRoots>
  void beginAgain(const TakeRoots& take_roots, int starts, Best& best) const {
    if (best.worth.first == 0) return;
    Search standing(derived);
    const std::vector<int> missed =
        optimize::missedPatches(derived.problem(solving), best.report);
    derived.patches_ = as_it_was.patches;
    derived.start_ = as_it_was.start;
    derived.start_is_known_ = as_it_was.start_is_known;
    if (!take_roots(missed)) return;
    derived.transfer(progress);
    SolveOptions again = options;
    again.starts = starts;
    SolveReport other;
    std::vector<Minimum> others = derived.searchAbout(other, solving, again, progress);
    // A finger on the wrong side of a sheet costs the objective little.
    const double depth =
        solving.avoids() ? derived.depthOf(other, derived.patches_, progress) : 0.0;
    if (depth > kDeep && depth > derived.depthOf(best.report, standing.patches, progress))
      return;
    if (!takeBetter(derived.worthOf(other, solving), other, best.worth, best.report)) return;
    best.found = std::move(others);
    standing.keep();
  }
};

void DerivedState::choosePlacement(const std::vector<placement::HandPoseGuess>& placements,
                                   const Progress& progress) {
  SolveOptions options;
  options.starts = 1;
  options.max_evaluations = kTrialEvaluations;
  const std::vector<SessionPatch> before = patches_;
  Search outcome(*this);
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(placements.size(), kTriedPlacements); ++i) {
    patches_ = before;
    start_ = placements[i].pose;
    takeDirectionsFrom(start_);
    transferPatches(progress);
    SolverSettings solving;
    solving.avoid_penetration = document_.solving.avoids();
    const PoseProblem trial = problem(solving);
    if (trial.pairs.empty()) break;
    const SolveReport report = optimize::solve(trial, options, progress);
    const double score =
        report.terms.objective +
        placer(progress).depthCharge(report.pose, document_.X_WO, trial.pairs.size());
    if (score >= best) continue;
    best = score;
    start_ = report.pose;
    outcome.keep();
  }
  patches_ = outcome.patches;
  start_ = outcome.start;
  takeDirectionsFrom(start_);
  start_is_known_ = true;
  outcome.keep();
}

Solution DerivedState::solve(const SolverSettings& solving,
                             const SolveRun& run,
                             const Progress& progress) {
  validate(solving);
  if (expected_ != nullptr && !run.places_stay && expected_->solving == solving) {
    transfer(progress);
    Solution known = *expected_;
    known.document.notes = document_.notes;
    known.document.solving = document_.solving;
    return known;
  }
  // Who asks once more gets no less than what stands.
  if (document_.is_solved && !solving.paper && !run.places_stay) {
    Solution standing = judgeBy(solving, progress);
    Solution found = solveAnew(solving, run, progress);
    return session::worthOf(found) < session::worthOf(standing)
               ? std::move(found)
               : keptInsteadOf(std::move(found), std::move(standing));
  }
  return solveAnew(solving, run, progress);
}

Solution DerivedState::solveAnew(const SolverSettings& solving,
                                 const SolveRun& run,
                                 const Progress& progress) {
  if (solving.paper || run.places_stay || solving.starts <= optimize::kDefaultStarts)
    return solveOnce(solving, run, progress);
  // Other starts lead to other slides of roots, and those may end worse: who asks for more gets
  // no less than who asks for nothing.
  SolverSettings usual = solving;
  usual.starts = optimize::kDefaultStarts;
  Solution best = solveOnce(solving, run, progress);
  Solution other = solveOnce(usual, run, progress);
  const int evaluations = best.report.evaluations + other.report.evaluations;
  if (session::worthOf(other) < session::worthOf(best)) best = std::move(other);
  best.solving = solving;
  best.report.evaluations = evaluations;
  return best;
}

Solution DerivedState::solveOnce(const SolverSettings& solving,
                                 const SolveRun& run,
                                 const Progress& progress) {
  transfer(progress);
  requirePoints();
  if (solving.avoids()) placement::makeSolids(*models_.hand, models_.object_O, progress);
  const Search as_it_was(*this);
  SolveOptions options = solveOptions(solving);
  options.near = near_.get();
  options.threads = run.threads;
  options.on_improvement = run.on_improvement;
  if (solving.paper || run.places_stay) {
    const PoseProblem posed = problem(solving);
    SolveReport standing = optimize::solve(posed, options, progress);
    if (solving.paper || document_.start_is_known || !reachesNothing(posed, standing))
      return answered(std::move(standing), solving);
    options.starts = std::max(options.starts, optimize::kDefaultStarts);
  }
  transfer(progress);
  SolveReport report;
  std::vector<Minimum> found;
  {
    const Drafts drafts(*this);
    if (searchesWidely(options) && slides()) options.least_promise = kDraftPromise;
    found = searchAbout(report, solving, options, progress);
    options.on_improvement = nullptr;
    if (searchesWidely(options)) {
      NewBeginnings{*this, as_it_was, solving, options, progress}.improve(report, found);
      if (isInside(report)) approachAnew(as_it_was.start, report, solving, options, progress);
      if (solving.avoids()) beginOpen(report, solving, options, progress);
      reweightMissedPatches(report, solving, options, progress);
    }
  }
  const bool is_rough = options.least_promise > optimize::kLeastPromise;
  options.least_promise = optimize::kLeastPromise;
  layDraftsInFull(report, is_rough, solving, options, progress);
  if (solving.avoids() && report.minima.size() < found.size())
    keepMinima(found, report, solving, options, progress);
  return answered(std::move(report), solving);
}

Solution DerivedState::solveRoughly(const SolverSettings& solving, const Progress& progress) {
  validate(solving);
  const Search as_it_was(*this);
  const Drafts drafts(*this);
  // What a full solve laid before is no draft: the answer would depend on it.
  for (SessionPatch& item : patches_)
    item.up_to_date = item.up_to_date && item.transferred.is_draft;
  transfer(progress);
  requirePoints();
  if (solving.avoids()) placement::makeSolids(*models_.hand, models_.object_O, progress);
  SolveOptions options = solveOptions(solving);
  options.near = near_.get();
  options.least_promise = kDraftPromise;
  SolveReport report;
  searchAbout(report, solving, options, progress);
  return answered(std::move(report), solving);
}

DerivedState::Worth DerivedState::worthOf(const SolveReport& report,
                                          const SolverSettings& solving) const {
  const PoseProblem posed = problem(solving);
  return {failedPatches(posed, report), costOf(posed, report)};
}

double DerivedState::depthOf(const SolveReport& report,
                             const std::vector<SessionPatch>& patches,
                             const Progress& progress) const {
  hand::HandPose pose_O = report.pose;
  pose_O.X_WH = inverse(document_.X_WO) * report.pose.X_WH;
  return placement::deepestOf(models_.hand->model, models_.hand->skin, models_.object_O, pose_O,
                              progress, contactSides(patches));
}

bool DerivedState::takeBetter(const Worth& of_other,
                              SolveReport& other,
                              Worth& worth,
                              SolveReport& report) {
  if (!(of_other < worth)) return false;
  worth = of_other;
  other.evaluations += report.evaluations;
  report = std::move(other);
  return true;
}

std::vector<Minimum> DerivedState::searchAbout(SolveReport& report,
                                               const SolverSettings& solving,
                                               SolveOptions options,
                                               const Progress& progress) {
  if (solving.avoids() && searchesWidely(options))
    options.found = slideFreely(solving, options, progress);
  report = optimize::solve(problem(solving), options, progress);
  options.on_improvement = nullptr;
  options.found.clear();
  std::vector<Minimum> found = report.minima;
  const SolveOptions step = solving.avoids() ? stepOf(options) : options;
  for (int i = 0; i < kRefinements && refineDirections(report, solving, step, progress); ++i) {
  }
  slideRoots(report, solving, step, progress, kWorseSlides);
  goOn(report, solving, options, progress);
  return found;
}

void DerivedState::layDraftsInFull(SolveReport& report,
                                   bool is_rough,
                                   const SolverSettings& solving,
                                   SolveOptions options,
                                   const Progress& progress) {
  bool any = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.transferred.is_draft) continue;
    item.up_to_date = false;
    any = true;
  }
  if (!any && !is_rough) return;
  transfer(progress);
  start_ = report.pose;
  options.starts = 1;
  SolveReport laid =
      optimize::solve(problem(solving), solving.avoids() ? stepOf(options) : options, progress);
  laid.evaluations += report.evaluations;
  laid.best_start = report.best_start;
  laid.solver = report.solver;
  report = std::move(laid);
  goOn(report, solving, options, progress);
}

Solution DerivedState::answered(SolveReport report, const SolverSettings& solving) const {
  Solution solution;
  solution.problem = problem(solving);
  solution.solving = solving;
  solution.document = document_;
  solution.document.start = report.pose;
  solution.document.prior = report.pose;
  solution.document.start_is_known = true;
  solution.document.is_solved = true;
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    if (!patches_[i].placement) continue;
    solution.document.patches[i].placement = patches_[i].placement;
    solution.document.patches[i].direction_O = patches_[i].patch.direction_O;
  }
  solution.patches = patches_;
  solution.report = std::move(report);
  return solution;
}

void DerivedState::goOn(SolveReport& report,
                        const SolverSettings& solving,
                        SolveOptions options,
                        const Progress& progress) {
  if (report.outcome != optimize::Outcome::kEvaluationLimit) return;
  const Search as_it_was(*this);
  options.starts = 1;
  start_ = report.pose;
  SolveReport last = optimize::solve(problem(solving), options, progress);
  if (last.terms.objective <= report.terms.objective) report = std::move(last);
}

void DerivedState::keepMinima(const std::vector<Minimum>& found,
                              SolveReport& report,
                              const SolverSettings& solving,
                              const SolveOptions& options,
                              const Progress& progress) {
  const Search as_it_was(*this);
  std::vector<Minimum> all = report.minima;
  Worth worth = worthOf(report, solving);
  for (const Minimum& other : found) {
    start_ = other.pose;
    SolveReport now = optimize::solve(problem(solving), stepOf(options), progress);
    if (worthOf(now, solving) < worth) goOn(now, solving, options, progress);
    // A step from it is still what it was found by, and as often.
    for (Minimum& minimum : now.minima) {
      minimum.start = other.start;
      minimum.solver = other.solver;
      minimum.hits = other.hits;
      all.push_back(minimum);
    }
    if (!takeBetter(worthOf(now, solving), now, worth, report)) continue;
    report.best_start = other.start;
    report.solver = other.solver;
  }
  optimize::rankMinima(*models_.hand->model, {}, "", all);
  report.minima = std::move(all);
}

bool DerivedState::refineDirections(SolveReport& report,
                                    const SolverSettings& solving,
                                    const SolveOptions& options,
                                    const Progress& progress) {
  Search outcome(*this);
  if (!takeDirectionsFrom(report.pose)) return false;
  transfer(progress);
  start_ = report.pose;
  SolveReport refined = optimize::solve(problem(solving), options, progress);
  if (!(refined.terms.objective < report.terms.objective)) return false;
  report = std::move(refined);
  outcome.keep();
  return true;
}

}  // namespace handgraft::session
