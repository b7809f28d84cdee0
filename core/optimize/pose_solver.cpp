#include "core/optimize/pose_solver.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/optimize/finalists.h"
#include "core/optimize/local_search.h"
#include "core/optimize/minima.h"
#include "core/optimize/starts.h"
#include "core/optimize/worker_pool.h"

namespace handgraft::optimize {

namespace {

/// How a multi-start of a solver shares out its evaluations (DECISIONS: measured).
struct Plan {
  int exploring = 0;    ///< a start is left after as many unless it is a finalist
  int warm_up = 0;      ///< of those starts that get one
  int first_round = 0;  ///< starts; the others only if these do not agree
};

Plan planOf(const SolveOptions& options) {
  constexpr int kFewStarts = 32;  // too few to leave any out
  if (options.solver != Solver::kLm) {
    return {std::min(200, options.max_evaluations), 0, options.starts};
  }
  const int five_eighths = (5 * options.starts + 7) / 8;
  return {std::min(10, options.max_evaluations), 5,
          options.starts < kFewStarts ? options.starts : five_eighths};
}

/// Starts that go on to their end, of so many explored ones.
int finalistsAmong(int explored, Solver solver) {
  return solver == Solver::kLm ? std::max(8, (explored + 3) / 4) : 3;
}

// Of the best places found, so many have starts of the second round about them.
constexpr std::size_t kCenters = 4;

// What the listener of the progress hears about the first stage.
constexpr double kExploringShare = 0.7;

void validate(const SolveOptions& options) {
  constexpr int kMostStarts = 100000;
  constexpr int kMostThreads = 256;
  if (options.starts < 1 || options.starts > kMostStarts) {
    rejectInput("starts: {} must lie in 1 to {}", options.starts, kMostStarts);
  }
  if (options.threads < 1 || options.threads > kMostThreads) {
    rejectInput("threads: {} must lie in 1 to {}", options.threads, kMostThreads);
  }
  if (options.max_evaluations < 1) {
    rejectInput("evaluations: {} must be at least 1", options.max_evaluations);
  }
  if (!(options.least_promise >= 0.0 && options.least_promise < 1.0)) {
    rejectInput("least promise: {} must lie in 0 to 1", options.least_promise);
  }
}

/// Hears all workers, and lets the user's listeners hear one at a time.
class Audience {
 public:
  Audience(const SolveOptions& options, const Progress& progress)
      : options_(options), progress_(progress) {}

  void offer(const hand::HandPose& pose, const Terms& terms) {
    const std::lock_guard lock(mutex_);
    if (terms.objective >= best_) return;
    best_ = terms.objective;
    options_.on_improvement(pose, terms);
  }

  void reportDone(double step) {
    const std::lock_guard lock(mutex_);
    fraction_ = std::min(1.0, fraction_ + step);
    progress_.report("solving for the pose", fraction_);
  }

 private:
  const SolveOptions& options_;
  const Progress& progress_;
  std::mutex mutex_;
  double best_ = std::numeric_limits<double>::infinity();
  double fraction_ = 0.0;
};

}  // namespace

struct PoseSolver::Parts {
  explicit Parts(PoseProblem source) : problem(std::move(source)), prepared(problem) {}

  PoseProblem problem;
  PreparedProblem prepared;
  std::unique_ptr<WorkerPool> pool;
  std::vector<std::unique_ptr<LocalSearch>> searches;  ///< one a worker
  std::vector<LocalResult> results;                    ///< one a start

  void hire(int workers) {
    if (pool != nullptr && pool->workers() == workers) return;
    pool = std::make_unique<WorkerPool>(workers);
    while (searches.size() < static_cast<std::size_t>(workers))
      searches.push_back(std::make_unique<LocalSearch>(prepared));
  }

  /// `found`: what the first round found, for starts about it; empty in the first round.
  void explore(const SolveOptions& options,
               const Plan& plan,
               const std::vector<hand::HandPose>& found,
               int index,
               LocalSearch& search) {
    LocalResult& result = results[static_cast<std::size_t>(index)];
    if (found.empty()) {
      hand::HandPose start = startPose(problem, *prepared.tree, index, options.seed);
      if (index == 0 && options.from_prior) start = problem.prior;
      const bool warms_up = startKind(index) == StartKind::kSpread;
      result = search.begin(std::move(start),
                            warms_up ? std::min(plan.warm_up, plan.exploring - 1) : 0);
    } else {
      const hand::HandPose& center = found[static_cast<std::size_t>(index) % found.size()];
      result = search.begin(startAbout(center, problem, *prepared.tree, index, options.seed));
    }
    // A lone start is not compared with any other.
    const int most = options.starts == 1 ? options.max_evaluations : plan.exploring;
    search.advance(options.solver, most - result.evaluations, result);
  }

  /// One solver's searches from all starts; their ends are in `results`.
  void searchAll(const SolveOptions& options,
                 const Progress& progress,
                 Audience& audience,
                 double share);
};

void PoseSolver::Parts::searchAll(const SolveOptions& options,
                                  const Progress& progress,
                                  Audience& audience,
                                  double share) {
  const Plan plan = planOf(options);
  hire(options.threads);
  results.assign(static_cast<std::size_t>(options.starts), LocalResult());

  LocalSearch::Observer observer;
  if (options.on_improvement) {
    observer = [&audience](const hand::HandPose& pose, const Terms& terms) {
      audience.offer(pose, terms);
    };
  }
  const std::function<void()> keep_going = [&] {
    progress.checkpoint();
    if (pool->failed()) throw Cancelled();
  };
  for (const auto& search : searches) {
    search->attend(observer, keep_going);
    search->level(options.level);
    search->endBelow(options.least_promise);
  }

  Finalists finalists(*problem.model);
  int explored = 0;
  while (explored < options.starts) {
    const int begin = explored;
    explored = begin == 0 ? plan.first_round : options.starts;
    const int count = explored - begin;
    const double round_share = share * count / options.starts;
    const std::vector<hand::HandPose> found = finalists.best(results, kCenters);

    // === Starts as far as the first part of their evaluations carries them
    pool->run(count, [&](int worker, int index) {
      explore(options, plan, found, begin + index, *searches[static_cast<std::size_t>(worker)]);
      audience.reportDone(round_share * kExploringShare / count);
    });

    // === The most promising ones to their end
    const std::vector<int> chosen =
        finalists.choose(results, explored, finalistsAmong(explored, options.solver));
    const int finishing = static_cast<int>(chosen.size());
    pool->run(finishing, [&](int worker, int index) {
      LocalResult& result =
          results[static_cast<std::size_t>(chosen[static_cast<std::size_t>(index)])];
      if (result.outcome == Outcome::kEvaluationLimit) {
        searches[static_cast<std::size_t>(worker)]->advance(
            options.solver, options.max_evaluations - result.evaluations, result);
      }
      audience.reportDone(round_share * (1.0 - kExploringShare) / finishing);
    });
    if (finalists.agree(results)) break;
  }
  results.resize(static_cast<std::size_t>(explored));
  audience.reportDone(share * (options.starts - explored) / options.starts);
}

PoseSolver::PoseSolver(PoseProblem problem) {
  optimize::validate(problem);
  parts_ = std::make_unique<Parts>(std::move(problem));
}

PoseSolver::~PoseSolver() = default;

const PoseProblem& PoseSolver::problem() const {
  return parts_->problem;
}

SolveReport PoseSolver::search(const SolveOptions& options, const Progress& progress) {
  validate(options);
  SolveReport report;
  if (boundsContradict(problem())) {
    report.solver = nameOf(options.solver);
    report.outcome = Outcome::kInfeasible;
    report.pose = problem().start;
    report.evaluations = 1;
    report.starts = 1;
    report.terms = Objective(problem(), parts_->prepared.tree).evaluate(report.pose);
    return report;
  }
  std::vector<Solver> solvers = {options.solver};
  if (options.solver == Solver::kAll) solvers = singleSolvers();
  const double share = 1.0 / static_cast<double>(solvers.size());
  SolveOptions single = options;
  Audience audience(options, progress);
  for (const Solver solver : solvers) {
    single.solver = solver;
    parts_->searchAll(single, progress, audience, share);
    rankMinima(*problem().model, parts_->results, std::string(nameOf(solver)), report.minima);
    report.starts = std::max(report.starts, static_cast<int>(parts_->results.size()));
    for (const LocalResult& result : parts_->results)
      report.evaluations += result.evaluations;
  }
  const Minimum& best = report.minima.front();
  report.outcome = best.outcome;
  report.solver = best.solver;
  report.pose = best.pose;
  report.terms = best.terms;
  report.best_start = best.start;
  return report;
}

void judge(const PoseProblem& problem, SolveReport& report) {
  PoseProblem bare = problem;
  bare.pairs.clear();
  judge(problem, Objective(bare).evaluate(report.pose), report);
}

void judge(const PoseProblem& problem, const Terms& terms, SolveReport& report) {
  report.terms = sumOverPoints(problem, report.pose, terms);
  report.patches = fitPatches(problem, report.pose);
  report.active_limits = activeLimits(problem, report.pose);
}

}  // namespace handgraft::optimize
