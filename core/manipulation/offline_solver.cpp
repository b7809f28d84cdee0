#include "core/manipulation/offline_solver.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/manipulation/band_search.h"
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
constexpr double kApart = 0.025;  // s
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

/// The poses of the objective's frames, those of `range`.
void solvePart(const MotionProblem& problem,
               MotionObjective& objective,
               const std::vector<SearchStage>& stages,
               const FrameRange& range,
               HeldFrames held,
               const Progress& progress,
               Trajectory& trajectory) {
  const std::size_t part = range.count;
  const std::size_t count = trajectory.poses.size();
  const std::size_t first = range.first;
  Poses poses;
  for (std::size_t k = 0; k < part; ++k)
    poses.push_back(trajectory.poses[static_cast<std::size_t>(range.at(k))]);
  BandSearch search(problem, objective, range, std::move(poses), held);
  const bool is_limited = problem.velocity_limit.array().isFinite().any() ||
                          problem.acceleration_limit.array().isFinite().any();
  double done = 0.0;
  for (const SearchStage& stage : stages) {
    // Without limits of that kind nothing is stiff.
    if (!is_limited && problem.avoidance == nullptr && stage.limits < 1.0) continue;
    progress.report(
        range.stride > 1 ? "solving some frames" : "solving all frames",
        (static_cast<double>(first) + done * static_cast<double>(part * range.stride)) /
            static_cast<double>(count));
    done += 1.0 / static_cast<double>(stages.size());
    search.descend(stage, progress, trajectory.evaluations);
  }
  for (std::size_t k = 0; k < part; ++k) {
    const auto at = static_cast<std::size_t>(range.at(k));
    trajectory.objective[at] = search.frames()[k];
    trajectory.poses[at] = std::move(search.poses()[k]);
  }
}

/// Frames of a part between those of `range`, and behind the last of them, by their poses,
/// within limits of their own; what is held stays.
void interpolateRest(const MotionProblem& problem,
                     const FrameRange& range,
                     const FrameRange& part,
                     HeldFrames held,
                     Poses& poses) {
  const std::vector<double>& time_s = problem.time_s;
  for (std::size_t k = held.before; k + held.behind < part.count; ++k) {
    if (k % range.stride == 0) continue;
    const auto at = static_cast<std::size_t>(part.at(k));
    const std::size_t before = at - k % range.stride;
    const std::size_t behind = before + range.stride;
    if (behind > static_cast<std::size_t>(range.at(range.count - 1))) {
      poses[at] = poses[before];
    } else {
      poses[at] =
          poseBetween(poses[before], poses[behind],
                      (time_s[at] - time_s[before]) / (time_s[behind] - time_s[before]));
    }
    const Eigen::VectorXd& lower = problem.lowerAt(part.at(k));
    poses[at].q = poses[at].q.cwiseMax(lower).cwiseMin(problem.upperAt(part.at(k)));
  }
}

/// Every `stride`-th frame of a part; the first and the last one held if those of the part are.
HeldFrames heldAmong(const FrameRange& range, const FrameRange& part, HeldFrames held) {
  HeldFrames among;
  for (std::size_t k = 0; k < range.count; ++k) {
    const std::size_t at = k * range.stride;
    among.before += at < held.before ? 1 : 0;
    among.behind += at + held.behind >= part.count ? 1 : 0;
  }
  return among;
}

/// Frames `first` to `end`, in parts; before them and from `end` on poses stay. Every
/// `stride`-th of them is searched, others lie between.
void solveParts(const MotionProblem& problem,
                const MotionOptions& options,
                const std::vector<SearchStage>& stages,
                std::size_t first,
                std::size_t end,
                const Progress& progress,
                Trajectory& trajectory,
                std::size_t stride = 1) {
  optimize::WorkerPool pool(options.threads);
  const FrameProblems frames(problem, options.fade);
  const std::size_t count = problem.time_s.size();
  const auto at_once = static_cast<std::size_t>(options.frames_at_once);
  // Frames that are solved with one part for its sake, and with the next for good.
  const std::size_t ahead = std::min<std::size_t>(480, at_once / 4);
  std::size_t from = first - std::min(kJoined, first);
  const std::size_t to = std::min(count, end + kJoined);
  HeldFrames held{first - from, 0};
  for (;;) {
    const std::size_t left = to - from;
    const std::size_t part = left <= at_once + ahead ? left : at_once;
    held.behind = part == left ? to - end : 0;
    const FrameRange all{from, part};
    const FrameRange range{from, 1 + (part - 1) / stride, stride};
    MotionObjective objective(problem, frames, options, pool, range);
    solvePart(problem, objective, stages, range, heldAmong(range, all, held), progress,
              trajectory);
    interpolateRest(problem, range, all, held, trajectory.poses);
    if (part == left) return;
    from += part - ahead - kJoined;
    held.before = kJoined;
  }
}

/// Frames of a motion, the last one not among them.
struct Stretch {
  std::size_t first;
  std::size_t end;
};

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
    const Stretch one{std::max(all.first, k - std::min(k, about)),
                      std::min(all.end, k + about)};
    if (!found.empty() && one.first <= found.back().end)
      found.back().end = one.end;
    else
      found.push_back(one);
  }
  return found;
}

/// Solves a stretch by these stages; it stays as it was unless its limits are kept better then.
void solveWithin(const MotionProblem& problem,
                 const MotionOptions& options,
                 const std::vector<SearchStage>& stages,
                 const Stretch& of,
                 const Progress& progress,
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
  solveParts(problem, options, stages, of.first, of.end, progress, trajectory);
  if (limitShare(problem, trajectory.poses, of) < share) return;
  std::copy(poses.begin(), poses.end(), pose);
  std::copy(objectives.begin(), objectives.end(), objective);
}

/// What lies beyond a limit costs, and a tight one asks for more than a cost: it is brought
/// within, as far as that goes, first with what lies about it alone; where it does not, that is
/// noted.
void keepLimits(const MotionProblem& problem,
                const MotionOptions& options,
                std::size_t first,
                std::size_t end,
                const Progress& progress,
                Trajectory& trajectory) {
  const bool touches = problem.avoidance == nullptr;
  const std::vector<SearchStage>& limited = touches ? touching_limited : avoiding_limited;
  const std::vector<SearchStage>& smoothed = touches ? touching_smoothed : avoiding_smoothed;
  const Stretch all{first, end};
  constexpr double kAll = 1e9;  // s
  const std::pair<const std::vector<SearchStage>*, double> attempts[] = {
      {&limited, 0.25}, {&smoothed, 0.5}, {&limited, kAll}, {&smoothed, kAll}};
  for (const auto& [stages, about_s] : attempts)
    for (const Stretch& beyond : beyondLimits(problem, trajectory.poses, all, about_s))
      solveWithin(problem, options, *stages, beyond, progress, trajectory);
  constexpr double kWorthNoting = 1.01;
  const double share = limitShare(problem, trajectory.poses, all);
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
  const std::size_t count = problem.time_s.size();
  if (problem.avoidance == nullptr) {
    solveParts(problem, options, touching_stages, 0, count, progress, trajectory);
  } else {
    const auto stride = static_cast<std::size_t>(strideOf(problem.time_s, kApart));
    solveParts(problem, options, avoiding_stages, 0, count, progress, trajectory, stride);
    if (stride > 1)
      solveParts(problem, options, avoiding_between, 0, count, progress, trajectory);
  }
  keepLimits(problem, options, 0, problem.time_s.size(), progress, trajectory);
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
  solveParts(problem, options, problem.avoidance == nullptr ? touching_again : avoiding_again,
             static_cast<std::size_t>(first), static_cast<std::size_t>(end), progress,
             trajectory);
  keepLimits(problem, options, static_cast<std::size_t>(first), static_cast<std::size_t>(end),
             progress, trajectory);
}

void stepOn(const MotionProblem& problem,
            const MotionOptions& options,
            const Progress& progress,
            Trajectory& trajectory) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(trajectory.poses.size() == problem.time_s.size());
  solveParts(problem, options, problem.avoidance == nullptr ? touching_step : avoiding_step, 0,
             problem.time_s.size(), progress, trajectory);
}

}  // namespace handgraft::manipulation
