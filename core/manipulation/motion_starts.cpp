#include "core/manipulation/motion_starts.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "core/manipulation/causal_solver.h"
#include "core/manipulation/motion.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

namespace handgraft::manipulation {

namespace {

constexpr double kChangesApart = 0.25;  // s
constexpr std::size_t kMostAnchors = 64;
constexpr std::size_t kMostCandidates = 5;
// Evaluations of a search that goes on from a neighbour's minimum.
constexpr int kFollowing = 60;
// Of the way that is to be made smooth later: close to the contacts.
constexpr double kFollowedSmoothness = 1000.0;

/// A pose that a frame might have.
struct Candidate {
  hand::HandPose pose;
  double objective = 0.0;
};

struct Anchor {
  int frame = 0;
  std::vector<Candidate> candidates;
};

double squareBetween(const MotionProblem& problem,
                     const hand::HandPose& a,
                     const hand::HandPose& b) {
  double sum =
      kShiftScale * (a.X_WH.translation() - b.X_WH.translation()).squaredNorm() +
      kTurnScale *
          vectorFromRotation(a.X_WH.linear() * b.X_WH.linear().transpose()).squaredNorm();
  for (Eigen::Index i = 0; i < a.q.size(); ++i) {
    const bool slides =
        problem.model->dofJoint(static_cast<int>(i)).type == hand::JointType::kPrismatic;
    const double way = a.q[i] - b.q[i];
    sum += (slides ? kSliderScale : 1.0) * way * way;
  }
  return sum;
}

bool isNear(const MotionProblem& problem, const Candidate& a, const Candidate& b) {
  return squareBetween(problem, a.pose, b.pose) < 0.01;
}

void keepBest(const MotionProblem& problem, std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return a.objective < b.objective;
                   });
  std::vector<Candidate> kept;
  for (const Candidate& one : candidates) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return isNear(problem, one, other);
    });
    if (!known && kept.size() < kMostCandidates) kept.push_back(one);
  }
  candidates = std::move(kept);
}

std::vector<int> anchorFrames(const MotionProblem& problem, const FrameProblems& frames) {
  double apart = kChangesApart;
  std::vector<int> changes = contactChanges(problem, apart);
  while (changes.size() > kMostAnchors) {
    apart *= 1.5;
    changes = contactChanges(problem, apart);
  }
  std::erase_if(changes, [&](int frame) {
    return frames.presentAt(frame).empty();
  });
  return changes;
}

/// Joins the minima of frames at which contacts change.
class JoiningMinima {
 public:
  JoiningMinima(const MotionProblem& problem,
                const MotionOptions& options,
                const Progress& progress)
      : touching_(withoutAvoidance(problem)),
        options_(options),
        progress_(progress),
        frames_(touching_, options.fade) {
    rest_.q = problem.prior.cwiseMax(problem.lower).cwiseMin(problem.upper);
    for (const int frame : anchorFrames(touching_, frames_))
      anchors_.push_back({frame, {}});
  }

  JoiningMinima(const JoiningMinima&) = delete;
  JoiningMinima& operator=(const JoiningMinima&) = delete;

  /// Of all frames.
  std::vector<hand::HandPose> poses() {
    if (anchors_.empty()) return std::vector<hand::HandPose>(touching_.time_s.size(), rest_);
    findCandidates();
    for (std::size_t i = 1; i < anchors_.size(); ++i)
      spread(i - 1, i);
    for (std::size_t i = anchors_.size() - 1; i-- > 0;)
      spread(i + 1, i);
    return posesThrough(cheapestWay());
  }

 private:
  /// Penetration comes in later, step by step.
  static MotionProblem withoutAvoidance(MotionProblem problem) {
    problem.avoidance = nullptr;
    return problem;
  }

  /// The best of each anchor by itself.
  void findCandidates() {
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      Anchor& anchor = anchors_[i];
      progress_.checkpoint();
      progress_.report("finding grasps",
                       static_cast<double>(i) / static_cast<double>(anchors_.size()));
      const auto report =
          solveSingle(touching_, frames_, anchor.frame, rest_, options_, progress_);
      for (const optimize::Minimum& minimum : report.minima)
        anchor.candidates.push_back({minimum.pose, minimum.terms.objective});
      keepBest(touching_, anchor.candidates);
    }
  }

  /// To an anchor, what follows there from its neighbour's candidates.
  void spread(std::size_t from, std::size_t to) {
    std::vector<Candidate> all = anchors_[to].candidates;
    for (const Candidate& one : anchors_[from].candidates)
      all.push_back(searchFrom(anchors_[to], one.pose));
    keepBest(touching_, all);
    anchors_[to].candidates = std::move(all);
  }

  [[nodiscard]] Candidate searchFrom(const Anchor& anchor, const hand::HandPose& start) const {
    optimize::SolveOptions solving;
    solving.starts = 1;
    solving.max_evaluations = kFollowing;
    const auto report = optimize::solve(frames_.at(anchor.frame, start), solving, progress_);
    return {report.pose, report.terms.objective};
  }

  /// One candidate of each anchor: those that are joined at the least cost.
  [[nodiscard]] std::vector<hand::HandPose> cheapestWay() const {
    std::vector<std::vector<double>> costs(anchors_.size());
    std::vector<std::vector<std::size_t>> from(anchors_.size());
    costs[0].assign(anchors_[0].candidates.size(), 0.0);
    for (std::size_t i = 1; i < anchors_.size(); ++i) {
      const Anchor& before = anchors_[i - 1];
      const Anchor& now = anchors_[i];
      const double count = now.frame - before.frame;
      const int middle = (before.frame + now.frame) / 2;
      const optimize::PoseProblem single = frames_.at(middle, rest_);
      optimize::Objective objective(single);
      for (const Candidate& one : now.candidates) {
        double best = std::numeric_limits<double>::infinity();
        std::size_t best_from = 0;
        for (std::size_t j = 0; j < before.candidates.size(); ++j) {
          const Candidate& other = before.candidates[j];
          const double middle_cost =
              objective.evaluate(poseBetween(other.pose, one.pose, 0.5)).objective;
          // From rest to rest over n frames the squares of second differences sum to
          // 12 way^2 / n^3.
          const double bend = 12.0 * options_.smoothness *
                              squareBetween(touching_, one.pose, other.pose) /
                              (count * count * count);
          const double cost =
              costs[i - 1][j] + bend +
              count / 6.0 * (other.objective + 4.0 * middle_cost + one.objective);
          if (cost < best) {
            best = cost;
            best_from = j;
          }
        }
        costs[i].push_back(best);
        from[i].push_back(best_from);
      }
    }
    auto at = static_cast<std::size_t>(
        std::min_element(costs.back().begin(), costs.back().end()) - costs.back().begin());
    std::vector<hand::HandPose> chosen(anchors_.size());
    for (std::size_t i = anchors_.size(); i-- > 0;) {
      chosen[i] = anchors_[i].candidates[at].pose;
      if (i > 0) at = from[i][at];
    }
    return chosen;
  }

  /// All frames, given a pose of each anchor.
  [[nodiscard]] std::vector<hand::HandPose> posesThrough(
      const std::vector<hand::HandPose>& chosen) const {
    const std::vector<double>& time_s = touching_.time_s;
    std::vector<hand::HandPose> poses(time_s.size(), rest_);
    std::size_t next = 0;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const int frame = static_cast<int>(k);
      while (next < anchors_.size() && anchors_[next].frame <= frame)
        ++next;
      if (next == 0) {
        poses[k] = chosen.front();
      } else if (next == anchors_.size()) {
        poses[k] = chosen.back();
      } else {
        const double begin = time_s[static_cast<std::size_t>(anchors_[next - 1].frame)];
        const double end = time_s[static_cast<std::size_t>(anchors_[next].frame)];
        poses[k] =
            poseBetween(chosen[next - 1], chosen[next], (time_s[k] - begin) / (end - begin));
      }
    }
    return poses;
  }

  MotionProblem touching_;
  const MotionOptions& options_;
  const Progress& progress_;
  FrameProblems frames_;
  hand::HandPose rest_;
  std::vector<Anchor> anchors_;
};

}  // namespace

std::vector<hand::HandPose> joinedMinima(const MotionProblem& problem,
                                         const MotionOptions& options,
                                         const Progress& progress) {
  return JoiningMinima(problem, options, progress).poses();
}

namespace {

constexpr int kToldEvery = 64;  // frames

/// The frames between two, by even steps from one to the other.
void fillBetween(const MotionProblem& problem,
                 int a,
                 int b,
                 std::vector<hand::HandPose>& poses) {
  const auto first = static_cast<std::size_t>(std::min(a, b));
  const auto last = static_cast<std::size_t>(std::max(a, b));
  const double whole = problem.time_s[last] - problem.time_s[first];
  for (std::size_t k = first + 1; k < last; ++k) {
    poses[k] = poseBetween(poses[first], poses[last],
                           (problem.time_s[k] - problem.time_s[first]) / whole);
  }
}

/// Follows the contacts from one frame on towards both ends, every `stride`-th frame, and those
/// at the ends; the objective of these frames, and the poses, even steps between. Gives up
/// where the objective is no less than `most`, which it then is.
double follow(const MotionProblem& problem,
              const FrameProblems& frames,
              const MotionOptions& options,
              const FramePose& setting,
              int stride,
              double most,
              const Progress& progress,
              std::vector<hand::HandPose>& poses) {
  const int last = problem.frameCount() - 1;
  poses.assign(problem.time_s.size(), setting.pose);
  double sum = 0.0;
  for (const int way : {1, -1}) {
    CausalSolver solver(problem, options);
    solver.begin(setting.pose);
    const int end = way > 0 ? last : 0;
    const int frames_before = way > 0 ? 0 : last - setting.frame;
    int told = -kToldEvery;
    int before = setting.frame;
    for (int k = setting.frame;; k = way * std::min(way * (k + way * stride), way * end)) {
      progress.checkpoint();
      const int followed = frames_before + std::abs(k - setting.frame);
      if (followed >= told + kToldEvery) {
        told = followed;
        progress.report("following contacts",
                        static_cast<double>(followed) / std::max(1, last));
      }
      const auto index = static_cast<std::size_t>(k);
      const CausalSolver::Step step =
          solver.follow(way * problem.time_s[index], frames.at(k, setting.pose));
      if (way > 0 || k != setting.frame) {
        sum += step.objective;
        poses[index] = step.pose;
        fillBetween(problem, before, k, poses);
        if (sum >= most) return sum;
      }
      before = k;
      if (k == end) break;
    }
  }
  return sum;
}

/// Frames in which as much touches as can be hoped for: the first of them, and those with most
/// pairs in each part of the motion.
std::vector<int> fullFrames(const MotionProblem& problem, const FrameProblems& frames) {
  constexpr int kParts = 3;
  std::vector<int> full = {fullestBegin(problem, frames)};
  const int begin = full[0];
  const int count = problem.frameCount() - begin;
  for (int part = 0; part < kParts; ++part) {
    int best = begin + part * count / kParts;
    for (int k = best; k < begin + (part + 1) * count / kParts; ++k)
      if (frames.presentAt(k).size() > frames.presentAt(best).size()) best = k;
    if (!frames.presentAt(best).empty()) full.push_back(best);
  }
  return full;
}

}  // namespace

std::vector<hand::HandPose> followedMinima(const MotionProblem& problem,
                                           const MotionOptions& options,
                                           const Progress& progress,
                                           const std::vector<FramePose>& known) {
  constexpr double kStride = 16.0 * kReferenceStep;  // s
  constexpr double kClosely = 3.0 * kReferenceStep;  // s; what lies between is solved next
  constexpr int kFewestStarts = 16;
  const FrameProblems frames(problem, options.fade);
  MotionOptions following = options;
  following.smoothness = std::min(options.smoothness, kFollowedSmoothness);
  hand::HandPose rest;
  rest.q = problem.prior.cwiseMax(problem.lower).cwiseMin(problem.upper);
  std::vector<FramePose> settings = {{0, rest}};
  if (!frames.presentAt(fullestBegin(problem, frames)).empty()) {
    settings.clear();
    // Four frames tell four times what the motion's basins are.
    MotionOptions searching = options;
    searching.starts = std::max(std::min(options.starts, kFewestStarts), options.starts / 2);
    for (const int frame : fullFrames(problem, frames)) {
      progress.report("finding grasps", 0.0);
      const auto report = solveSingle(problem, frames, frame, rest, searching, progress);
      for (const optimize::Minimum& minimum : report.minima)
        settings.push_back({frame, minimum.pose});
    }
  }
  for (FramePose one : known) {
    one.pose.q =
        one.pose.q.cwiseMax(problem.lowerAt(one.frame)).cwiseMin(problem.upperAt(one.frame));
    settings.push_back(std::move(one));
  }
  std::vector<hand::HandPose> poses;
  const FramePose* best = &settings.front();
  double least = std::numeric_limits<double>::infinity();
  for (const FramePose& setting : settings) {
    const double sum = follow(problem, frames, following, setting,
                              strideOf(problem.time_s, kStride), least, progress, poses);
    if (sum >= least) continue;
    least = sum;
    best = &setting;
  }
  follow(problem, frames, following, *best, strideOf(problem.time_s, kClosely),
         std::numeric_limits<double>::infinity(), progress, poses);
  return poses;
}

}  // namespace handgraft::manipulation
