#include "core/sweep/sweep_motion.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/hand/finger_coordinates.h"
#include "core/manipulation/offline_solver.h"
#include "core/retargeting/motion_grasps.h"
#include "core/retargeting/motion_layer.h"
#include "core/session/session.h"
#include "core/sweep/sweep_places.h"

namespace handgraft::sweep {

namespace {

using manipulation::PatchKey;
using manipulation::PatchTrack;
using manipulation::Trajectory;

constexpr double kHalfThere = 0.5;
constexpr double kAtLimit = 1e-6;  // rad or m

/// Recorded points have no outline that could be laid.
bool hasPlaces(const manipulation::Motion& motion) {
  return std::all_of(motion.tracks.begin(), motion.tracks.end(), [](const PatchTrack& track) {
    return track.keys.front().hand_points.empty() &&
           track.keys.front().patch.interpolation_boundary.size() >=
               static_cast<std::size_t>(contact::kFewestInterpolationPoints);
  });
}

double objectiveOf(const Trajectory& trajectory) {
  return std::accumulate(trajectory.objective.begin(), trajectory.objective.end(), 0.0);
}

/// Patches that are there at a frame, and how many of them the hand reaches.
struct PatchCounts {
  int there = 0;
  int reached = 0;
};

/// Adds what a frame's patches come to: sums over points, until they are averaged. Of a patch
/// that is there several times (a palm's recorded points) each has to be reached.
PatchCounts addFrame(const std::vector<retargeting::PatchFrameFit>& fits, SweepRow& row) {
  std::map<int, bool> is_reached;  // of the patches that are there
  for (const retargeting::PatchFrameFit& fit : fits) {
    if (fit.presence < kHalfThere) continue;
    SweepPatch& patch = row.patches[static_cast<std::size_t>(fit.patch)];
    patch.point_count += fit.points;
    patch.mean_mm += fit.points * fit.mean_mm;
    patch.normal_deg += fit.points * fit.normal_deg;
    patch.max_mm = std::max(patch.max_mm, fit.mean_mm);
    bool& reached = is_reached.try_emplace(fit.patch, true).first->second;
    reached = reached && fit.reached;
  }
  PatchCounts counts;
  for (const auto& [index, reached] : is_reached) {
    SweepPatch& patch = row.patches[static_cast<std::size_t>(index)];
    ++counts.there;
    ++patch.frames;
    counts.reached += reached ? 1 : 0;
    patch.reached += reached ? 1 : 0;
  }
  return counts;
}

/// Makes means of the patches' sums, and those of the whole row.
void average(SweepRow& row) {
  double sum_mm = 0.0;
  double sum_deg = 0.0;
  for (SweepPatch& patch : row.patches) {
    if (patch.frames == 0) continue;
    ++row.patch_count;
    row.reached_count += patch.reached == patch.frames ? 1 : 0;
    row.point_count += patch.point_count;
    sum_mm += patch.mean_mm;
    sum_deg += patch.normal_deg;
    row.max_mm = std::max(row.max_mm, patch.max_mm);
    patch.mean_mm /= patch.point_count;
    patch.normal_deg /= patch.point_count;
  }
  if (row.point_count > 0) {
    row.mean_mm = sum_mm / row.point_count;
    row.normal_deg = sum_deg / row.point_count;
  }
}

/// In how many frames each joint stands at a limit.
class LimitCounts {
 public:
  /// Keeps a reference.
  explicit LimitCounts(const manipulation::MotionProblem& problem)
      : problem_(problem),
        at_lower_(static_cast<std::size_t>(problem.model->dofCount()), 0),
        at_upper_(at_lower_) {}

  void add(const Eigen::VectorXd& q) {
    for (std::size_t i = 0; i < at_lower_.size(); ++i) {
      const auto dof = static_cast<Eigen::Index>(i);
      at_lower_[i] += q[dof] <= problem_.lower[dof] + kAtLimit ? 1 : 0;
      at_upper_[i] += q[dof] >= problem_.upper[dof] - kAtLimit ? 1 : 0;
    }
  }

  /// Joints that stand there in half of the row's frames.
  void tell(SweepRow& row) const {
    if (row.frame_count == 0) return;
    for (std::size_t i = 0; i < at_lower_.size(); ++i) {
      const std::string& name = problem_.model->dofJoint(static_cast<int>(i)).name;
      if (2 * at_lower_[i] >= row.frame_count) row.joints_at_limit.push_back({name, false});
      if (2 * at_upper_[i] >= row.frame_count) row.joints_at_limit.push_back({name, true});
    }
  }

 private:
  const manipulation::MotionProblem& problem_;
  std::vector<int> at_lower_;
  std::vector<int> at_upper_;
};

/// Means over all frames, and which patch is reached in how many of them.
void fill(const SweepMotionBase& base, const retargeting::SolvedMotion& solved, SweepRow& row) {
  const retargeting::MotionFits fits(base.motion, solved);
  for (const std::string& name : retargeting::patchNames(base.motion))
    row.patches.emplace_back().name = name;
  const std::vector<hand::HandPose>& poses = solved.trajectory.poses;
  LimitCounts at_limits(solved.problem);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const PatchCounts counts = addFrame(fits.at(static_cast<int>(k)), row);
    if (counts.there == 0) continue;
    ++row.frame_count;
    row.frames_reached += counts.reached == counts.there ? 1 : 0;
    at_limits.add(poses[k].q);
  }
  average(row);
  at_limits.tell(row);
  row.terms.objective = objectiveOf(solved.trajectory);
  row.outcome = optimize::Outcome::kConverged;
}

}  // namespace

SweepMotionBase solveMotionBase(const hand::Hand& hand,
                                const SweepGrasp& grasp,
                                const SweepOptions& options,
                                int threads,
                                const Progress& progress) {
  SweepMotionBase base;
  try {
    const session::Session session(
        retargeting::modelsOfMotion(hand, grasp.object_O, *grasp.motion), Pose::Identity(),
        options.weights, options.transfer);
    session::Document document = session.document();
    document.solving = options.solving;
    retargeting::MotionSolving solving = retargeting::motionSolving(false);
    solving.options.starts = options.solving.starts;
    solving.options.seed = options.solving.seed;
    base.solved = std::make_shared<const retargeting::SolvedMotion>(retargeting::solveMotion(
        document, hand, grasp.object_O, *grasp.motion, solving, threads, progress));
    base.motion = *base.solved->laid;
    if (!hasPlaces(base.motion)) return base;
    const retargeting::MotionLayer layer(document, hand, *grasp.object_O, base.motion);
    for (PatchTrack& track : base.motion.tracks)
      for (PatchKey& key : track.keys)
        key.placement = layer.placementOf(key);
  } catch (const InvalidInput& error) {
    base.error = error.what();
  }
  return base;
}

LaidSweepMotion layMotion(const SweepMotionBase& base,
                          const hand::Hand& original,
                          const geometry::TriangleMesh& object_O,
                          const transfer::Surfaces* bent,
                          const transfer::TransferOptions& options,
                          const Progress& progress) {
  LaidSweepMotion laid;
  laid.error = base.error;
  if (!base.error.empty()) return laid;
  laid.laid.tracks = base.solved->problem.tracks;
  laid.laid.track_of = base.solved->track_of;
  if (bent == nullptr) return laid;
  try {
    if (!hasPlaces(base.motion)) {
      for (manipulation::PairTrack& track : laid.laid.tracks)
        for (manipulation::PairSpan& span : track.spans)
          for (optimize::PointPair& pair : span.pairs)
            pair = carriedAlong(*original.skin, *bent->skin, pair);
      return laid;
    }
    manipulation::Motion motion = base.motion;
    for (PatchTrack& track : motion.tracks)
      for (PatchKey& key : track.keys)
        if (key.placement)
          key.placement = carriedAlong(*original.skin, *bent->skin, *key.placement);
    transfer::Surfaces surfaces = *bent;
    surfaces.object_O = transfer::borrowedSurfaces(object_O, *bent->skin).object_O;
    // Every key that has a place on the hand tells it; coordinates are for those that do not.
    const hand::FingerCoordinates coordinates(*original.model, *original.skin, original.sites);
    laid.laid = manipulation::transferPatches(motion, surfaces, *original.model, {},
                                              coordinates, options, progress);
  } catch (const InvalidInput& error) {
    laid.error = error.what();
  }
  return laid;
}

void solveMotionRow(const SweepMotionBase& base,
                    const LaidSweepMotion& laid,
                    const hand::HandVariant& variant,
                    const std::shared_ptr<const optimize::Avoidance>& solids,
                    const Progress& progress,
                    SweepRow& row) {
  const manipulation::MotionProblem& before = base.solved->problem;
  retargeting::SolvedMotion solved;
  solved.solving = base.solved->solving;
  solved.solving.options.threads = 1;
  solved.track_of = laid.laid.track_of;
  solved.problem = manipulation::makeMotionProblem(
      std::make_shared<const hand::HandModel>(variant.model), before.time_s);
  manipulation::MotionProblem& problem = solved.problem;
  problem.tracks = laid.laid.tracks;
  problem.weights = before.weights;
  problem.normal_form = before.normal_form;
  problem.prior = before.prior;  // also beyond a row's limits: all rows are pulled alike
  if (before.avoidance != nullptr) problem.avoidance = solids;
  const manipulation::MotionOptions& options = solved.solving.options;

  // What the base does may lie deep in the object by now: a way found from nothing, too.
  Trajectory from_base;
  from_base.time_s = before.time_s;
  for (const hand::HandPose& pose : base.solved->trajectory.poses)
    from_base.poses.push_back({pose.X_WH, hand::poseOfVariant(variant, pose.q)});
  from_base.objective.assign(from_base.poses.size(), 0.0);
  manipulation::solveAgain(problem, options, 0, problem.frameCount(), progress, from_base);
  Trajectory from_nothing = manipulation::solveOffline(problem, options, progress);
  solved.trajectory = objectiveOf(from_nothing) < objectiveOf(from_base)
                          ? std::move(from_nothing)
                          : std::move(from_base);
  fill(base, solved, row);
  for (const hand::HandPose& pose : solved.trajectory.poses) {
    progress.checkpoint();
    row.depths =
        deeperOf(row.depths, quality::measureDepths(*problem.model, *solids->hand,
                                                    *solids->object_O, pose, progress));
  }
}

}  // namespace handgraft::sweep
