#include "core/optimize/avoiding_solve.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/optimize/avoidance_term.h"
#include "core/optimize/finalists.h"
#include "core/optimize/local_search.h"
#include "core/optimize/minima.h"
#include "core/optimize/pose_solver.h"
#include "core/optimize/starts.h"

namespace handgraft::optimize {

namespace {

/// Of a joint of the hand, behind the root's six.
bool isHeld(const PoseProblem& problem, int joint) {
  return !problem.locked.empty() && problem.locked[6 + static_cast<std::size_t>(joint)];
}

/// One part of the way out: so many of the best searches go on, looking so closely.
struct Stage {
  std::size_t searches;
  int evaluations;
  AvoidanceLevel level;
  double least_promise = 0.0;  ///< as of SolveOptions, which may ask for more
};

/// A search and the start that it came from.
struct CandidatePose {
  LocalResult result;
  int start = 0;
};

/// Of those that stand close together the best alone goes on, wherever their forearms are: they
/// end in the same place.
void leaveOutAlike(const hand::HandModel& model,
                   const MomentTree& tree,
                   std::vector<CandidatePose>& candidates) {
  std::vector<CandidatePose> kept;
  for (CandidatePose& candidate : candidates) {
    const bool is_known =
        std::any_of(kept.begin(), kept.end(), [&](const CandidatePose& other) {
          const hand::HandPose& a = candidate.result.pose;
          const hand::HandPose& b = other.result.pose;
          return liesClose(model, a, b) || liesCloseBehindTheWrist(tree, a, b);
        });
    if (!is_known) kept.push_back(std::move(candidate));
  }
  candidates = std::move(kept);
}

bool isBetter(const CandidatePose& a, const CandidatePose& b) {
  return a.result.terms.objective < b.result.terms.objective;
}

// From soft and roughly to hard and closely: what is stiff at once is stuck at once.
const std::vector<Stage> full_stages = {
    {8, 8, {false, 0.02}},
    {4, 12, {true, 0.1}},
    {3, 20, {true, 1.0}},
};

constexpr int kPriorsStart = 2;  // starts.h

// Deeper in one another than this, fingers have run through each other.
constexpr double kCrossed = 1.5e-3;  // m

// The best of a whole search goes to its end, and a lone start as far as it is told to. Few
// starts follow an edit, and the answer must be there before the next one is.
constexpr int kToTheEnd = 300;

// Where fingers rest on edges, steps go on for ever and gain ever less: a round that gains less
// than this share of the objective is the last one.
constexpr int kRound = 20;
constexpr double kWorthARound = 1e-3;

// With few starts the hand stands out of the object already, and is nearly where it ends. A
// third of the evaluations went into the last thousandth of the objective.
const std::vector<Stage> short_stages = {
    {1, 12, {true, 0.1}, 1e-3},
    {1, 25, {true, 1.0}, 3e-5},
};

/// Up to so many evaluations more, for as long as they gain anything worth having.
void goToTheEnd(LocalSearch& search, Solver solver, int evaluations, LocalResult& result) {
  while (evaluations > 0) {
    const int before = result.evaluations;
    const double objective = result.terms.objective;
    search.advance(solver, std::min(kRound, evaluations), result);
    if (result.outcome != Outcome::kEvaluationLimit) return;
    evaluations -= std::max(1, result.evaluations - before);
    if (objective - result.terms.objective < kWorthARound * objective) {
      result.outcome = Outcome::kConverged;
      return;
    }
  }
}

/// Tells fingers that cross. Those are stuck: what pushes one out on one side is undone on the
/// other.
class CrossedFingers {
 public:
  CrossedFingers(const PoseProblem& problem, const MomentTree& tree)
      : problem_(problem),
        tree_(tree),
        term_(*problem.avoidance, tree),
        bodies_(static_cast<std::size_t>(tree.bodyCount())) {}

  /// The pose with their joints as at rest; nothing if none cross.
  std::optional<hand::HandPose> uncrossed(const hand::HandPose& pose, LocalSearch& search) {
    placeBodies(tree_, pose.X_WH.linear(), pose.q, bodies_);
    NearLists lent;  // where the search has just been
    search.swapNear(lent);
    term_.swapNear(lent);
    term_.evaluate(pose.X_WH.translation(), bodies_);
    term_.swapNear(lent);
    search.swapNear(lent);
    hand::HandPose straight = pose;
    bool is_crossed = false;
    for (const PenetratingSample& touch : term_.touches()) {
      if (touch.other < 0 || touch.depth < kCrossed) continue;
      is_crossed = true;
      for (int a = touch.body, b = touch.other; a != b;)
        straighten(a > b ? a : b, straight.q);
    }
    if (!is_crossed) return std::nullopt;
    return straight;
  }

 private:
  /// Of the joint that carries `body`, which becomes the body before.
  void straighten(int& body, Eigen::VectorXd& q) const {
    const TreeJoint& joint = tree_.joints[static_cast<std::size_t>(body - 1)];
    body = joint.parent_body;
    if (isHeld(problem_, joint.dof)) return;
    q[joint.dof] = std::clamp(problem_.model->restPose()[joint.dof], problem_.lower[joint.dof],
                              problem_.upper[joint.dof]);
  }

  const PoseProblem& problem_;
  const MomentTree& tree_;
  AvoidanceTerm term_;
  std::vector<BodyPlace> bodies_;
};

/// A lone start is a step from where the hand is: without the charge it would only go in.
bool isStep(const SolveOptions& options) {
  return options.starts == 1 && options.solver != Solver::kAll;
}

/// The minima without the charge, from which ways lead out of the object; for a step, none.
SolveReport searchUncharged(const PoseProblem& problem,
                            const SolveOptions& options,
                            const Progress& progress) {
  SolveReport report;
  if (isStep(options) && !boundsContradict(problem)) {
    report.starts = 1;
  } else if (!options.found.empty() && !boundsContradict(problem)) {
    report.starts = static_cast<int>(std::ssize(options.found));
    report.minima = options.found;
  } else {
    // Poses on the way there lie where they may not stay.
    SolveOptions rough = options;
    rough.on_improvement = nullptr;
    rough.level.share = 0.0;
    report = PoseSolver(problem).search(rough, progress);
  }
  return report;
}

/// Leads poses out of the object, and fingers out of one another.
class WayOut {
 public:
  /// Keeps references.
  WayOut(const PoseProblem& problem, const SolveOptions& options, const Progress& progress)
      : problem_(problem),
        options_(options),
        prepared_(problem),
        keep_going_([&progress] {
          progress.checkpoint();
        }),
        search_(prepared_),
        crossed_(problem, *prepared_.tree) {
    search_.attend(nobody_, keep_going_);
    search_.endBelow(options.least_promise);
    if (options.near != nullptr) search_.swapNear(*options.near);
  }

  ~WayOut() {
    if (options_.near != nullptr) search_.swapNear(*options_.near);
  }

  WayOut(const WayOut&) = delete;
  WayOut& operator=(const WayOut&) = delete;

  /// From what a solver has found, and from where the problem has it begin. The report gets
  /// its minima with the charge, unranked.
  void lead(Solver solver, const std::vector<Minimum>& found, SolveReport& report) {
    std::vector<CandidatePose> candidates = candidatesOf(solver, found);
    if (candidates.empty()) return;
    for (const Stage& stage : options_.starts <= kFewStarts ? short_stages : full_stages)
      goThrough(stage, solver, candidates, report);
    std::stable_sort(candidates.begin(), candidates.end(), isBetter);
    tryUncrossed(solver, candidates);
    if (isStep(options_) || options_.starts > kFewStarts) {
      LocalResult& best = candidates.front().result;
      goToTheEnd(search_, solver,
                 std::min(kToTheEnd, options_.max_evaluations - best.evaluations), best);
    }
    // The others are left a little before their ends, and count all the same.
    for (const CandidatePose& candidate : candidates) {
      const LocalResult& result = candidate.result;
      report.minima.push_back({result.pose, result.terms, result.outcome,
                               std::string(nameOf(solver)), candidate.start});
      report.evaluations += result.evaluations;
    }
  }

 private:
  [[nodiscard]] std::vector<CandidatePose> candidatesOf(
      Solver solver, const std::vector<Minimum>& found) const {
    std::vector<CandidatePose> candidates;
    const auto set_out = [&](const hand::HandPose& pose, int start) {
      candidates.push_back({{}, start});
      candidates.back().result.pose = pose;
    };
    for (const Minimum& minimum : found)
      if (minimum.solver == nameOf(solver)) set_out(minimum.pose, minimum.start);
    if (options_.solver != solver) return candidates;
    set_out(problem_.start, 0);
    // As the hand would stand without touching: on the right side of things, mostly.
    if (!isStep(options_))
      set_out(startPose(problem_, *prepared_.tree, kPriorsStart, options_.seed), 2);
    return candidates;
  }

  /// Those worth it go on, best first when the stage begins.
  void goThrough(const Stage& stage,
                 Solver solver,
                 std::vector<CandidatePose>& candidates,
                 SolveReport& report) {
    search_.level(stage.level);
    if (!isStep(options_))
      search_.endBelow(std::max(options_.least_promise, stage.least_promise));
    for (CandidatePose& candidate : candidates)
      judgeAnew(candidate);
    // Which poses are worth the effort shows when they are looked at so closely.
    std::stable_sort(candidates.begin(), candidates.end(), isBetter);
    leaveOutAlike(*problem_.model, *prepared_.tree, candidates);
    for (std::size_t i = stage.searches; i < candidates.size(); ++i)
      report.evaluations += candidates[i].result.evaluations;
    candidates.resize(std::min(candidates.size(), stage.searches));
    for (CandidatePose& candidate : candidates)
      advance(stage, solver, candidate);
  }

  /// Judges a pose as closely as the search looks by now.
  void judgeAnew(CandidatePose& candidate) {
    const int before = candidate.result.evaluations;
    candidate.result = search_.begin(std::move(candidate.result.pose));
    candidate.result.evaluations += before;
  }

  void advance(const Stage& stage, Solver solver, CandidatePose& candidate) {
    search_.advance(solver, std::min(stage.evaluations, options_.max_evaluations),
                    candidate.result);
  }

  /// If fingers of the best one cross, one more candidate: the best one with those straight.
  void tryUncrossed(Solver solver, std::vector<CandidatePose>& candidates) {
    auto straight = crossed_.uncrossed(candidates.front().result.pose, search_);
    if (!straight) return;
    CandidatePose candidate{{}, candidates.front().start};
    candidate.result.pose = std::move(*straight);
    for (const Stage& stage : short_stages) {
      search_.level(stage.level);
      judgeAnew(candidate);
      advance(stage, solver, candidate);
    }
    candidates.push_back(std::move(candidate));
    std::stable_sort(candidates.begin(), candidates.end(), isBetter);
  }

  const PoseProblem& problem_;
  const SolveOptions& options_;
  PreparedProblem prepared_;
  LocalSearch::Observer nobody_;
  std::function<void()> keep_going_;
  LocalSearch search_;
  CrossedFingers crossed_;
};

}  // namespace

SolveReport solveAvoiding(const PoseProblem& problem,
                          const SolveOptions& options,
                          const Progress& progress) {
  HANDGRAFT_REQUIRE(problem.avoidance != nullptr);
  validate(problem);
  SolveReport report = searchUncharged(problem, options, progress);
  if (report.outcome == Outcome::kInfeasible) {
    judge(problem, report);
    return report;
  }
  WayOut way_out(problem, options, progress);
  const std::vector<Minimum> found = std::move(report.minima);
  report.minima.clear();
  // By solver, as they rank what they found.
  for (const Solver solver : singleSolvers())
    way_out.lead(solver, found, report);
  rankMinima(*problem.model, {}, "", report.minima);
  const Minimum& answer = report.minima.front();
  report.outcome = answer.outcome;
  report.solver = answer.solver;
  report.pose = answer.pose;
  report.best_start = answer.start;
  judge(problem, answer.terms, report);
  if (options.on_improvement) options.on_improvement(report.pose, report.terms);
  return report;
}

}  // namespace handgraft::optimize
