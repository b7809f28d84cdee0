#include "core/manipulation/offline_solver.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/manipulation/band_search.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_objective.h"
#include "core/manipulation/motion_starts.h"

namespace handgraft::manipulation {

namespace {

using Poses = std::vector<hand::HandPose>;

constexpr double kNearlyEnough = 1e-3;  // where each evaluation looks at thousands of samples

constexpr optimize::AvoidanceLevel kTouch = {false, 0.0};
constexpr optimize::AvoidanceLevel kClosely = {true, 1.0};
constexpr optimize::AvoidanceLevel kFirmly = {true, 16.0};

// From soft to hard: what is stiff at once is stuck at once.
const std::vector<SearchStage> touching_stages = {
    {kTouch, 1.0, 1e-4, 40}, {kTouch, 1.0, 1e-2, 40}, {kTouch, 1.0, 1.0, 60}};
// Out of the object already, and to stay there while the way grows smooth.
const std::vector<SearchStage> avoiding_stages = {{kClosely, 0.05, 1e-3, 4, kNearlyEnough},
                                                  {kClosely, 1.0, 1.0, 16, kNearlyEnough},
                                                  {kFirmly, 1.0, 1.0, 10, kNearlyEnough}};

// Few frames tell the way; then those between them take their places in it.
constexpr double kApart = 0.0249;  // s; 25 ms and what rounding takes
const std::vector<SearchStage> avoiding_between = {{kFirmly, 1.0, 1.0, 10, kNearlyEnough}};

// Where velocities or accelerations are beyond their limits still: firmer and firmer; and where
// that is stuck, by a way so smooth that it keeps them, which is let go bit by bit.
const std::vector<SearchStage> touching_limited = {
    {kTouch, 1.0, 10.0, 40}, {kTouch, 1.0, 100.0, 40}, {kTouch, 1.0, 1000.0, 40}};
const std::vector<SearchStage> avoiding_limited = {{kFirmly, 1.0, 10.0, 20, kNearlyEnough},
                                                   {kFirmly, 1.0, 100.0, 20, kNearlyEnough},
                                                   {kFirmly, 1.0, 1000.0, 20, kNearlyEnough}};
const std::vector<SearchStage> touching_smoothed = {{kTouch, 1000.0, 1.0, 40},
                                                    {kTouch, 100.0, 100.0, 40},
                                                    {kTouch, 10.0, 1000.0, 40},
                                                    {kTouch, 1.0, 1e4, 40}};
const std::vector<SearchStage> avoiding_smoothed = {{kFirmly, 1000.0, 1.0, 20, kNearlyEnough},
                                                    {kFirmly, 100.0, 100.0, 20, kNearlyEnough},
                                                    {kFirmly, 10.0, 1000.0, 20, kNearlyEnough},
                                                    {kFirmly, 1.0, 1e4, 30, 1e-4}};

// From an answer that stands already, beside what was edited.
const std::vector<SearchStage> touching_again = {{kTouch, 1.0, 1.0, 60}};
const std::vector<SearchStage> avoiding_again = {{kClosely, 1.0, 1.0, 12, kNearlyEnough},
                                                 {kFirmly, 1.0, 1.0, 10, kNearlyEnough}};

// Of a step among others.
const std::vector<SearchStage> touching_step = {{kTouch, 1.0, 1.0, 6}};
const std::vector<SearchStage> avoiding_step = {{kClosely, 1.0, 1.0, 4, kNearlyEnough}};

// A second difference joins a frame with the two before it.
constexpr std::size_t kJoined = 2;

/// Frames of a motion, the last one not among them.
struct Stretch {
  std::size_t first;
  std::size_t end;
};

/// Of a stretch, its first and last frame and those between that are so far apart at least.
std::vector<int> framesApart(const std::vector<double>& time_s,
                             const Stretch& of,
                             double apart_s) {
  std::vector<int> frames;
  double last_s = -std::numeric_limits<double>::infinity();
  for (std::size_t k = of.first; k < of.end; ++k) {
    if (time_s[k] - last_s < apart_s && k + 1 < of.end) continue;
    frames.push_back(static_cast<int>(k));
    last_s = time_s[k];
  }
  return frames;
}

/// Searches the frames of a motion by parts, which share what is the same for all of them.
class PartSearch {
 public:
  PartSearch(const MotionProblem& problem,
             const MotionOptions& options,
             const Progress& progress,
             Trajectory& trajectory)
      : problem_(problem),
        options_(options),
        progress_(progress),
        trajectory_(trajectory),
        pool_(options.threads),
        frames_(problem, options.fade) {}

  PartSearch(const PartSearch&) = delete;
  PartSearch& operator=(const PartSearch&) = delete;

  /// Poses before the stretch and behind it stay. Frames so far apart are searched, others lie
  /// between them. `what` is told of it.
  void search(const std::vector<SearchStage>& stages,
              const Stretch& of,
              std::string_view what,
              double apart_s = 0.0) {
    const auto at_once = static_cast<std::size_t>(options_.frames_at_once);
    // Frames that are solved with one part for its sake, and with the next for good.
    const std::size_t ahead = std::min<std::size_t>(480, at_once / 4);
    std::size_t from = of.first - std::min(kJoined, of.first);
    const std::size_t to = std::min(problem_.time_s.size(), of.end + kJoined);
    std::size_t first = of.first;  // that may move
    for (;;) {
      const std::size_t left = to - from;
      const std::size_t part = left <= at_once + ahead ? left : at_once;
      const std::size_t end = part == left ? of.end : from + part;
      const std::vector<int> frames =
          framesApart(problem_.time_s, {from, from + part}, apart_s);
      searchPart(stages, frames, {first, end}, what);
      interpolateRest(frames, {first, end});
      if (part == left) return;
      from += part - ahead - kJoined;
      first = from + kJoined;
    }
  }

 private:
  /// These frames, of which those of `moving` may move.
  void searchPart(const std::vector<SearchStage>& stages,
                  const std::vector<int>& frames,
                  const Stretch& moving,
                  std::string_view what) {
    HeldFrames held;
    Poses poses;
    for (const int frame : frames) {
      const auto at = static_cast<std::size_t>(frame);
      held.before += at < moving.first ? 1 : 0;
      held.behind += at >= moving.end ? 1 : 0;
      poses.push_back(trajectory_.poses[at]);
    }
    MotionObjective objective(problem_, frames_, options_, pool_, frames);
    BandSearch search(problem_, objective, frames, std::move(poses), held);
    const bool is_limited = problem_.velocity_limit.array().isFinite().any() ||
                            problem_.acceleration_limit.array().isFinite().any();
    double done = 0.0;
    for (const SearchStage& stage : stages) {
      // Without limits of that kind nothing is stiff.
      if (!is_limited && problem_.avoidance == nullptr && stage.limits < 1.0) continue;
      const double length = frames.back() + 1 - frames.front();
      progress_.report(what, (frames.front() + done * length) / problem_.frameCount());
      done += 1.0 / static_cast<double>(stages.size());
      search.descend(stage, progress_, trajectory_.evaluations);
    }
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const auto at = static_cast<std::size_t>(frames[k]);
      trajectory_.objective[at] = search.frames()[k];
      trajectory_.poses[at] = std::move(search.poses()[k]);
    }
  }

  /// What lies between these frames and may move, within limits of its own.
  void interpolateRest(const std::vector<int>& frames, const Stretch& moving) {
    const std::vector<double>& time_s = problem_.time_s;
    Poses& poses = trajectory_.poses;
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const auto before = static_cast<std::size_t>(frames[i - 1]);
      const auto behind = static_cast<std::size_t>(frames[i]);
      for (std::size_t k = std::max(before + 1, moving.first); k < std::min(behind, moving.end);
           ++k) {
        const auto frame = static_cast<int>(k);
        poses[k] =
            poseBetween(poses[before], poses[behind],
                        (time_s[k] - time_s[before]) / (time_s[behind] - time_s[before]));
        poses[k].q =
            poses[k].q.cwiseMax(problem_.lowerAt(frame)).cwiseMin(problem_.upperAt(frame));
      }
    }
  }

  const MotionProblem& problem_;
  const MotionOptions& options_;
  const Progress& progress_;
  Trajectory& trajectory_;
  optimize::WorkerPool pool_;
  FrameProblems frames_;
};

constexpr std::string_view kSolving = "solving all frames";

/// How many times its limit a velocity or an acceleration is at most that the poses of these
/// frames have a share in.
double limitShare(const MotionProblem& problem, const Poses& poses, const Stretch& of) {
  double share = 0.0;
  for (std::size_t k = of.first; k < std::min(poses.size(), of.end + kJoined); ++k)
    share = std::max(share, limitShareAt(problem, poses, k));
  return share;
}

/// Of `all`, where a limit is not kept, with what lies about it by so many seconds.
std::vector<Stretch> beyondLimits(const MotionProblem& problem,
                                  const Poses& poses,
                                  const Stretch& all,
                                  double about_s) {
  const auto about = static_cast<std::size_t>(strideOf(problem.time_s, about_s));
  std::vector<Stretch> found;
  for (std::size_t k = all.first; k < std::min(poses.size(), all.end + kJoined); ++k) {
    if (limitShareAt(problem, poses, k) <= 1.0) continue;
    const std::size_t first = std::max(all.first, k - std::min(k, about));
    const Stretch one{std::min(first, all.end - 1), std::min(all.end, k + about + 1)};
    if (!found.empty() && one.first <= found.back().end)
      found.back().end = one.end;
    else
      found.push_back(one);
  }
  return found;
}

/// Searches a stretch by these stages; it stays as it was unless its limits are kept better
/// then.
void searchWithin(const MotionProblem& problem,
                  const std::vector<SearchStage>& stages,
                  const Stretch& of,
                  PartSearch& search,
                  Trajectory& trajectory) {
  const auto part = [&of](auto& values) {
    return std::pair(values.begin() + static_cast<std::ptrdiff_t>(of.first),
                     values.begin() + static_cast<std::ptrdiff_t>(of.end));
  };
  const auto [pose, last_pose] = part(trajectory.poses);
  const auto [objective, last_objective] = part(trajectory.objective);
  const Poses poses(pose, last_pose);
  const std::vector<double> objectives(objective, last_objective);
  const double share = limitShare(problem, trajectory.poses, of);
  search.search(stages, of, "keeping limits");
  if (limitShare(problem, trajectory.poses, of) < share) return;
  std::copy(poses.begin(), poses.end(), pose);
  std::copy(objectives.begin(), objectives.end(), objective);
}

/// What lies beyond a limit costs, and a tight one asks for more than a cost: it is brought
/// within, as far as that goes, first with what lies about it alone, all of it if that fails;
/// where it does not, that is noted.
void keepLimits(const MotionProblem& problem,
                const Stretch& all,
                PartSearch& search,
                Trajectory& trajectory) {
  const bool touches = problem.avoidance == nullptr;
  const std::vector<SearchStage>& limited = touches ? touching_limited : avoiding_limited;
  const std::vector<SearchStage>& smoothed = touches ? touching_smoothed : avoiding_smoothed;
  const double whole_s = problem.time_s.back() - problem.time_s.front();
  const std::pair<const std::vector<SearchStage>*, double> attempts[] = {
      {&limited, 0.25}, {&smoothed, 0.5}, {&limited, whole_s}, {&smoothed, whole_s}};
  for (const auto& [stages, about_s] : attempts)
    for (const Stretch& beyond : beyondLimits(problem, trajectory.poses, all, about_s))
      searchWithin(problem, *stages, beyond, search, trajectory);
  constexpr double kWorthNoting = 1.01;
  const double share = limitShare(problem, trajectory.poses, {0, trajectory.poses.size()});
  if (share > kWorthNoting)
    trajectory.notes.push_back(fmt::format(
        "a joint's velocity or acceleration comes to {:.2f} times its limit", share));
}

}  // namespace

Trajectory solveOffline(const MotionProblem& problem,
                        const MotionOptions& options,
                        const Progress& progress,
                        const std::vector<hand::HandPose>& start,
                        const std::vector<FramePose>& known) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(start.empty() || start.size() == problem.time_s.size());
  for (const FramePose& one : known)
    HANDGRAFT_REQUIRE(one.frame >= 0 && one.frame < problem.frameCount());
  Trajectory trajectory;
  trajectory.time_s = problem.time_s;
  trajectory.poses = start;
  if (trajectory.poses.empty()) {
    trajectory.poses = problem.avoidance == nullptr
                           ? joinedMinima(problem, options, progress)
                           : followedMinima(problem, options, progress, known);
  }
  trajectory.objective.assign(trajectory.poses.size(), 0.0);
  const Stretch all{0, problem.time_s.size()};
  PartSearch search(problem, options, progress, trajectory);
  if (problem.avoidance == nullptr) {
    search.search(touching_stages, all, kSolving);
  } else {
    const bool has_between = framesApart(problem.time_s, all, kApart).size() < all.end;
    search.search(avoiding_stages, all, has_between ? "solving some frames" : kSolving, kApart);
    if (has_between) search.search(avoiding_between, all, kSolving);
  }
  keepLimits(problem, all, search, trajectory);
  return trajectory;
}

void solveAgain(const MotionProblem& problem,
                const MotionOptions& options,
                int first,
                int end,
                const Progress& progress,
                Trajectory& trajectory) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(trajectory.poses.size() == problem.time_s.size());
  HANDGRAFT_REQUIRE(0 <= first && first < end && end <= problem.frameCount());
  for (int k = first; k < end; ++k) {
    Eigen::VectorXd& q = trajectory.poses[static_cast<std::size_t>(k)].q;
    q = q.cwiseMax(problem.lowerAt(k)).cwiseMin(problem.upperAt(k));
  }
  const Stretch anew{static_cast<std::size_t>(first), static_cast<std::size_t>(end)};
  PartSearch search(problem, options, progress, trajectory);
  search.search(problem.avoidance == nullptr ? touching_again : avoiding_again, anew, kSolving);
  keepLimits(problem, anew, search, trajectory);
}

void stepOn(const MotionProblem& problem,
            const MotionOptions& options,
            const Progress& progress,
            Trajectory& trajectory) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(trajectory.poses.size() == problem.time_s.size());
  PartSearch(problem, options, progress, trajectory)
      .search(problem.avoidance == nullptr ? touching_step : avoiding_step,
              {0, problem.time_s.size()}, kSolving);
}

}  // namespace handgraft::manipulation
