#include "core/optimize/solver.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/local_search.h"
#include "core/optimize/starts.h"

namespace handgraft::optimize {

namespace {

constexpr std::array<std::pair<Solver, std::string_view>, 6> kSolverNames = {{
    {Solver::kMma, "mma"},
    {Solver::kCcsaq, "ccsaq"},
    {Solver::kSlsqp, "slsqp"},
    {Solver::kLbfgs, "lbfgs"},
    {Solver::kTnewton, "tnewton"},
    {Solver::kVar2, "var2"},
}};

// A start is left after this many evaluations unless it is among the best so far: enough to
// tell the basins apart (README: measured).
constexpr int kExploringEvaluations = 200;
constexpr std::size_t kFinishers = 3;

// What the listener of the progress hears about the first stage.
constexpr double kExploringShare = 0.7;

/// The searches of one solve. Each start depends on nothing but its number, so that threads may
/// take them in any order.
class MultiStart {
 public:
  MultiStart(const PoseProblem& problem, const SolveOptions& options, const Progress& progress)
      : problem_(problem),
        options_(options),
        progress_(progress),
        results_(static_cast<std::size_t>(options.starts)) {}

  /// Runs `work(search, result, index)` for each index, on `options.threads` threads. Progress
  /// is reported from `fraction` on.
  template <class Work>
  void forEach(const std::vector<int>& indices, double fraction, const Work& work) {
    const double end = fraction < kExploringShare ? kExploringShare : 1.0;
    const double step = (end - fraction) / static_cast<double>(indices.size());
    std::atomic<std::size_t> next{0};
    fraction_ = fraction;
    const auto loop = [&] {
      LocalSearch::Observer observer;
      if (options_.on_improvement) {
        observer = [this](const hand::HandPose& pose, const Terms& terms) {
          offer(pose, terms);
        };
      }
      const std::function<void()> keep_going = [this] {
        progress_.checkpoint();
        if (failed_.load(std::memory_order_relaxed)) throw Cancelled();
      };
      try {
        LocalSearch search(problem_, observer, keep_going);
        for (std::size_t i = next++; i < indices.size(); i = next++) {
          const int index = indices[i];
          work(search, results_[static_cast<std::size_t>(index)], index);
          reportDone(step);
        }
      } catch (...) {
        const std::lock_guard lock(mutex_);
        // The first failure counts; the others stop because of it.
        if (!failed_.exchange(true)) error_ = std::current_exception();
      }
    };
    const int extra = std::min(options_.threads, static_cast<int>(indices.size())) - 1;
    {
      std::vector<std::jthread> threads;
      threads.reserve(static_cast<std::size_t>(std::max(extra, 0)));
      for (int i = 0; i < extra; ++i)
        threads.emplace_back(loop);
      loop();
    }
    if (error_ != nullptr) std::rethrow_exception(error_);
  }

  [[nodiscard]] const std::vector<LocalResult>& results() const { return results_; }

 private:
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

  const PoseProblem& problem_;
  const SolveOptions& options_;
  const Progress& progress_;
  std::vector<LocalResult> results_;
  std::mutex mutex_;
  double best_ = std::numeric_limits<double>::infinity();
  double fraction_ = 0.0;
  std::atomic<bool> failed_{false};
  std::exception_ptr error_;
};

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
}

SolveReport reportOf(const PoseProblem& problem, Solver solver, LocalResult result) {
  SolveReport report;
  report.outcome = result.outcome;
  report.solver = nameOf(solver);
  report.pose = std::move(result.pose);
  report.terms = result.terms;
  report.evaluations = result.evaluations;
  report.patches = fitPatches(problem, report.pose);
  report.active_limits = activeLimits(problem, report.pose);
  return report;
}

}  // namespace

Solver solverFrom(std::string_view name) {
  for (const auto& [solver, known] : kSolverNames) {
    if (known == name) return solver;
  }
  rejectInput("solver {} is not known; permitted: mma ccsaq slsqp lbfgs tnewton var2",
              quoted(std::string(name)));
}

std::string_view nameOf(Solver solver) {
  for (const auto& [known, name] : kSolverNames) {
    if (known == solver) return name;
  }
  HANDGRAFT_REQUIRE(false && "a solver of the list");
  return {};
}

SolveReport solve(const PoseProblem& problem,
                  const SolveOptions& options,
                  const Progress& progress) {
  validate(problem);
  validate(options);
  if (boundsContradict(problem)) {
    LocalResult start;
    start.pose = problem.start;
    start.terms = Objective(problem).evaluate(problem.start);
    start.outcome = Outcome::kInfeasible;
    start.evaluations = 1;
    return reportOf(problem, options.solver, std::move(start));
  }

  // === All starts as far as the first part of their evaluations carries them
  MultiStart starts(problem, options, progress);
  const int exploring = std::min(kExploringEvaluations, options.max_evaluations);
  std::vector<int> order(static_cast<std::size_t>(options.starts));
  std::iota(order.begin(), order.end(), 0);
  starts.forEach(order, 0.0, [&](LocalSearch& search, LocalResult& result, int index) {
    result = search.begin(startPose(problem, index, options.seed));
    search.advance(options.solver, exploring - result.evaluations, result);
  });

  // === The most promising ones to their end
  const auto& explored = starts.results();
  std::stable_sort(order.begin(), order.end(), [&explored](int a, int b) {
    return explored[static_cast<std::size_t>(a)].terms.objective <
           explored[static_cast<std::size_t>(b)].terms.objective;
  });
  if (order.size() > kFinishers) order.resize(kFinishers);
  starts.forEach(order, kExploringShare, [&](LocalSearch& search, LocalResult& result, int) {
    if (result.outcome != Outcome::kEvaluationLimit) return;
    search.advance(options.solver, options.max_evaluations - result.evaluations, result);
  });

  const std::vector<LocalResult>& results = starts.results();
  const auto best =
      std::min_element(results.begin(), results.end(), [](const auto& a, const auto& b) {
        return a.terms.objective < b.terms.objective;
      });
  SolveReport report = reportOf(problem, options.solver, *best);
  report.evaluations = std::accumulate(results.begin(), results.end(), 0,
                                       [](int sum, const LocalResult& result) {
                                         return sum + result.evaluations;
                                       });
  report.starts = options.starts;
  report.best_start = static_cast<int>(best - results.begin());
  return report;
}

}  // namespace handgraft::optimize
