#include "core/retargeting/edited_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/geometry/tangent.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/offline_solver.h"
#include "core/placement/solids.h"
#include "core/retargeting/motion_grasps.h"
#include "core/retargeting/motion_layer.h"
#include "core/retargeting/motion_places.h"
#include "core/retargeting/motion_slides.h"
#include "core/retargeting/motion_times.h"
#include "core/retargeting/motion_unheld.h"
#include "core/session/field_bytes.h"
#include "core/session/timed_edit.h"

namespace handgraft::retargeting {

namespace {

using manipulation::Motion;
using manipulation::MotionProblem;
using manipulation::PairSpan;
using manipulation::PatchKey;
using manipulation::PatchTrack;
using manipulation::TransferredMotion;

constexpr std::size_t kFramesKept = 20000;  // of bases beside the last one, and of stretches
// Beyond what the answer before missed: so much more, and an edit is answered from nothing as
// well.
constexpr double kMissedMore = 0.05;

/// Where a patch was put; one that slides has a place on the hand of its own.
void addPlaces(const session::DocumentPatch& patch, session::FieldWriter& writer) {
  writer.add(patch.root_O);
  writer.add(patch.direction_O.value_or(Eigen::Vector3d::Zero()));
  writer.add(patch.root_is_open ? std::nullopt : patch.placement);
}

}  // namespace

struct EditedMotion::Work {
  const session::Document& document;
  const hand::Hand& hand;
  const MotionSolving& solving;
  int threads;
  const Progress& progress;
  std::string base_key;
  bool from_nothing;
};

namespace {

void measureDepths(const hand::Hand& hand,
                   const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                   FrameRange range,
                   int threads,
                   const Progress& progress,
                   SolvedMotion& solved) {
  const std::vector<hand::HandPose>& poses = solved.trajectory.poses;
  placement::makeSolids(hand, object_O, progress);
  const std::thread::id listener = std::this_thread::get_id();
  const auto measure = [&](int i) {
    progress.checkpoint();
    const auto k = static_cast<std::size_t>(range.first) + static_cast<std::size_t>(i);
    if (std::this_thread::get_id() == listener) {
      progress.report("measuring depths",
                      static_cast<double>(k) / static_cast<double>(poses.size()));
    }
    solved.depths[k] = placement::depthsOf(hand.model, hand.skin, object_O, poses[k], progress);
  };
  parallelFor(range.end - range.first, measure, std::max(1, threads));
}

bool arePosesSame(const hand::HandPose& a, const hand::HandPose& b) {
  return a.q == b.q && a.X_WH.matrix() == b.X_WH.matrix();
}

/// Joins ranges that touch; sorted.
std::vector<FrameRange> joined(std::vector<FrameRange> ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const FrameRange& a, const FrameRange& b) {
    return a.first < b.first;
  });
  std::vector<FrameRange> result;
  for (const FrameRange& range : ranges) {
    if (!result.empty() && range.first <= result.back().end)
      result.back().end = std::max(result.back().end, range.end);
    else
      result.push_back(range);
  }
  return result;
}

/// The frames of an edit and those that smoothness couples to them.
FrameRange stretchOf(const session::TimedEdit& edit, const std::vector<double>& time_s) {
  const std::map<int, double> influences = session::influencesOf(edit, time_s);
  const auto time_at = [&](int frame) {
    return time_s[static_cast<std::size_t>(frame)];
  };
  FrameRange range{influences.begin()->first, influences.rbegin()->first + 1};
  const double from = time_at(range.first) - EditedMotion::kMargin;
  const double to = time_at(range.end - 1) + EditedMotion::kMargin;
  while (range.first > 0 && time_at(range.first - 1) >= from)
    --range.first;
  while (range.end < static_cast<int>(time_s.size()) && time_at(range.end) <= to)
    ++range.end;
  return range;
}

/// How an edit moves a patch of the grasp that stands for the motion.
Shift shiftOf(const geometry::TriangleMesh& mesh_O,
              const contact::Patch& unedited,
              const session::DocumentPatch& now) {
  Shift shift;
  const bool is_same = now.root_O.face == unedited.root.face &&
                       now.root_O.barycentric == unedited.root.barycentric;
  if (!is_same)
    shift.way_T = wayTo(mesh_O, unedited.root, *unedited.direction_O, now.root_O, now.name);
  if (now.direction_O && !now.direction_is_open) {
    const Eigen::Vector3d carried =
        tangentCarried(mesh_O, unedited.root, now.root_O, *unedited.direction_O);
    const Eigen::Vector3d n = normalOf(mesh_O, now.root_O);
    const double turn =
        std::atan2(n.dot(carried.cross(*now.direction_O)), carried.dot(*now.direction_O));
    if (std::abs(turn) > 1e-9) shift.turn_rad = turn;
  }
  return shift;
}

/// The motion with roots and directions that were edited for all of it.
Motion withEdits(const Motion& motion,
                 const contact::ContactSet& grasp,
                 const session::Document& document,
                 const geometry::TriangleMesh& mesh_O) {
  const std::vector<std::string> names = patchNames(motion);
  Motion edited = motion;
  for (std::size_t i = 0; i < names.size() && i < document.patches.size(); ++i) {
    const session::DocumentPatch& now = document.patches[i];
    const Shift shift = shiftOf(mesh_O, withDirection(mesh_O, grasp.patches[i]), now);
    for (PatchTrack& track : edited.tracks) {
      if (track.name != names[i]) continue;
      track.dropped = now.dropped;
      if (shift.isNone()) continue;
      for (PatchKey& key : track.keys)
        key.patch = movedOver(mesh_O, key.patch, shift);
    }
  }
  return edited;
}

/// Where the patches of the same motion lay on the hand.
void takePlacements(const Motion& from, Motion& to) {
  for (std::size_t t = 0; t < to.tracks.size(); ++t)
    for (std::size_t i = 0; i < to.tracks[t].keys.size(); ++i)
      to.tracks[t].keys[i].placement = from.tracks[t].keys[i].placement;
}

/// Of the patches that are there in a frame each 50 ms: the share that is not reached.
double shareMissed(const Motion& motion, const SolvedMotion& solved) {
  constexpr double kEvery = 0.05;  // s
  const MotionFits fits(motion, solved);
  const int stride = manipulation::strideOf(motion.time_s, kEvery);
  int there = 0;
  int missed = 0;
  for (int k = 0; k < solved.problem.frameCount(); k += stride) {
    for (const PatchFrameFit& fit : fits.at(k)) {
      if (fit.presence < 1.0) continue;  // it comes or goes, or is switched off
      ++there;
      missed += fit.reached ? 0 : 1;
    }
  }
  return there > 0 ? static_cast<double>(missed) / there : 0.0;
}

}  // namespace

EditedMotion::EditedMotion(std::shared_ptr<const Motion> motion,
                           std::shared_ptr<const geometry::TriangleMesh> object_O)
    : motion_(std::move(motion)),
      object_O_(std::move(object_O)),
      grasp_(graspOf(*motion_, *object_O_)) {}

std::shared_ptr<const SolvedMotion> EditedMotion::solve(const session::Document& document,
                                                        const hand::Hand& hand,
                                                        MotionSolving solving,
                                                        int threads,
                                                        const Progress& progress,
                                                        const OnStretch& on_stretch,
                                                        bool from_nothing) {
  solving.options.threads = threads;
  session::FieldWriter key;
  key.add(document.hand);
  for (const session::DocumentPatch& patch : document.patches) {
    key.add(patch.name);
    key.add(patch.effectiveWeight());
    addPlaces(patch, key);
  }
  key.add(document.joints);
  for (std::size_t i = 0; i < document.joints.size(); ++i)
    key.add(document.joints[i].locked ? document.start.q[static_cast<Eigen::Index>(i)] : 0.0);
  key.add(document.held);
  key.add(document.X_WO);
  key.add(document.prior.q);
  key.add(document.weights);
  key.add(document.solving.normal_form);
  key.add(document.solving.avoids());
  key.add(document.transfer);
  key.add(solving.causal);
  key.add(solving.acceleration_limit);
  key.add(solving.options.smoothness);
  key.add(solving.options.fade.seconds);
  key.add(solving.options.starts);
  key.add(solving.options.seed);
  const Work work{document, hand, solving, threads, progress, key.take(), from_nothing};
  const Base& unedited = base(work);
  std::shared_ptr<const SolvedMotion> first = unedited.solved;
  if (document.timed.empty()) return first;
  auto solved = std::make_shared<SolvedMotion>(*first);
  const Laid& as_laid = *unedited.laid;
  layAtTimes(
      {document, hand, *object_O_, as_laid.motion, grasp_, as_laid.laid, solving.options.fade},
      progress, solved->problem);
  if (!solving.causal) {
    solveStretches(work, *solved, on_stretch);
    return solved;
  }
  solved->trajectory = solveCausal(solved->problem, solving.options, progress);
  const int count = solved->problem.frameCount();
  int same = 0;
  while (same < count && arePosesSame(solved->trajectory.poses[static_cast<std::size_t>(same)],
                                      first->trajectory.poses[static_cast<std::size_t>(same)]))
    ++same;
  measureDepths(hand, object_O_, {same, count}, threads, progress, *solved);
  return solved;
}

std::shared_ptr<const EditedMotion::Laid> EditedMotion::laid(
    const Work& work, bool anew, std::vector<hand::HandPose>& start) {
  session::FieldWriter writer;
  writer.add(work.document.hand);
  writer.add(work.document.transfer);
  for (const session::DocumentPatch& patch : work.document.patches)
    addPlaces(patch, writer);
  std::string key = writer.take();
  std::shared_ptr<const Laid> before;
  if (!anew && !bases_.empty() && bases_.front().laid->hand == work.document.hand)
    before = bases_.front().laid;
  if (before && key == before->key) return before;
  const MotionLayer layer(work.document, work.hand, *object_O_, *motion_);
  Motion edited = withEdits(*motion_, grasp_, work.document, *object_O_);
  std::optional<manipulation::MotionCharts> charts;
  const MotionPlaces places(work.document, work.hand, *object_O_, edited);
  if (before) {
    takePlacements(before->motion, edited);
    places.settle(edited);
  } else {
    places.deal(edited);
    if (!work.solving.causal && places.any()) {
      const std::vector<FrameGrasp> grasps = graspFrames(
          work.document, work.hand, object_O_, grasp_, edited, work.threads, work.progress);
      placeAsGrasped(grasps, edited);
      SlidPatches slid =
          slidePatches({work.document, work.hand, object_O_, grasp_, work.solving},
                       posesOf(grasps), work.progress, edited);
      start = std::move(slid.poses_O);
      charts = std::move(slid.charts);
    }
  }
  TransferredMotion as_laid = layer.lay(edited, work.progress, {}, charts ? &*charts : nullptr);
  return std::make_shared<const Laid>(
      Laid{std::move(key), work.document.hand, std::move(edited), std::move(as_laid)});
}

EditedMotion::Base EditedMotion::solveBase(const Work& work, bool goes_on) {
  const session::Document& document = work.document;
  auto made = std::make_shared<SolvedMotion>();
  SolvedMotion& solved = *made;
  solved.solving = work.solving;
  solved.problem = motionProblemOf(document, work.hand, motion_->time_s, work.solving);
  std::vector<hand::HandPose> start;
  if (!work.solving.causal) turnAlike(work.hand, *motion_, solved.problem);
  std::shared_ptr<const Laid> as_laid = laid(work, !goes_on, start);
  solved.problem.tracks = weighed(document, grasp_, as_laid->motion, as_laid->laid);
  solved.track_of = as_laid->laid.track_of;
  holdThroughout(document, work.solving.options.fade, solved.problem);
  if (document.solving.avoids()) {
    solved.problem.avoidance = placement::avoidanceOf(
        work.hand.model, work.hand.skin, object_O_, Pose::Identity(), work.progress);
  }
  const manipulation::MotionOptions& options = work.solving.options;
  const int count = solved.problem.frameCount();
  const auto lay_unheld = [&](std::vector<hand::HandPose>& poses) {
    return layUnheld(work.hand, as_laid->motion, options.fade, work.progress, solved.problem,
                     poses);
  };
  if (work.solving.causal) {
    solved.trajectory = solveCausal(solved.problem, options, work.progress);
  } else if (goes_on) {
    solved.trajectory = bases_.front().solved->trajectory;
    solved.trajectory.notes.clear();
    lay_unheld(solved.trajectory.poses);
    solveAgain(solved.problem, options, 0, count, work.progress, solved.trajectory);
  } else {
    if (!start.empty()) lay_unheld(start);
    std::vector<manipulation::FramePose> known;
    if (start.empty() && document.solving.avoids() && !isOfPoints(*motion_)) {
      known = posesOf(graspFrames(document, work.hand, object_O_, grasp_, as_laid->motion,
                                  work.threads, work.progress));
    }
    solved.trajectory = solveOffline(solved.problem, options, work.progress, start, known);
    if (start.empty() && lay_unheld(solved.trajectory.poses))
      solveAgain(solved.problem, options, 0, count, work.progress, solved.trajectory);
  }
  for (const std::vector<std::string>& notes :
       {remarksOn(*motion_, work.solving.causal), document.notes, as_laid->laid.notes,
        solved.trajectory.notes}) {
    for (const std::string& note : notes)
      if (std::find(solved.notes.begin(), solved.notes.end(), note) == solved.notes.end())
        solved.notes.push_back(note);
  }
  solved.laid = {as_laid, &as_laid->motion};
  solved.depths.assign(static_cast<std::size_t>(count), {});
  measureDepths(work.hand, object_O_, {0, count}, work.threads, work.progress, solved);
  return {work.base_key, std::move(as_laid), std::move(made)};
}

const EditedMotion::Base& EditedMotion::base(const Work& work) {
  const auto known = std::find_if(bases_.begin(), bases_.end(), [&](const Base& one) {
    return one.key == work.base_key;
  });
  if (known != bases_.end()) {
    bases_.splice(bases_.begin(), bases_, known);
    return bases_.front();
  }
  const SolvedMotion* before = bases_.empty() ? nullptr : bases_.front().solved.get();
  const bool goes_on = !work.from_nothing && before != nullptr &&
                       before->solving.causal == work.solving.causal &&
                       before->problem.model == work.hand.model;
  Base made = solveBase(work, goes_on);
  if (goes_on && !work.solving.causal &&
      shareMissed(*motion_, *made.solved) > shareMissed(*motion_, *before) + kMissedMore) {
    // What was found before has become a bad place to set out from.
    Base anew = solveBase(work, false);
    if (shareMissed(*motion_, *anew.solved) < shareMissed(*motion_, *made.solved))
      made = std::move(anew);
  }
  bases_.push_front(std::move(made));
  std::size_t frames = 0;
  for (auto base = std::next(bases_.begin()); base != bases_.end();) {
    frames += base->solved->trajectory.poses.size();
    base = frames > kFramesKept ? bases_.erase(base) : std::next(base);
  }
  return bases_.front();
}

void EditedMotion::solveStretches(const Work& work,
                                  SolvedMotion& solved,
                                  const OnStretch& on_stretch) {
  const std::vector<session::TimedEdit>& timed = work.document.timed;
  std::vector<FrameRange> ranges;
  ranges.reserve(timed.size());
  for (const session::TimedEdit& edit : timed)
    ranges.push_back(stretchOf(edit, solved.problem.time_s));

  struct Open {
    FrameRange range;
    std::string key;
  };

  std::vector<Open> open;
  for (const FrameRange& range : joined(ranges)) {
    session::FieldWriter writer;
    writer.add(work.base_key);
    for (std::size_t i = 0; i < timed.size(); ++i)
      if (ranges[i].first >= range.first && ranges[i].end <= range.end) writer.add(timed[i]);
    std::string key = writer.take();
    const auto known =
        std::find_if(stretches_.begin(), stretches_.end(), [&](const Stretch& one) {
          return one.key == key;
        });
    if (known == stretches_.end()) {
      open.push_back({range, std::move(key)});
      continue;
    }
    stretches_.splice(stretches_.begin(), stretches_, known);
    std::copy(known->poses.begin(), known->poses.end(),
              solved.trajectory.poses.begin() + range.first);
    std::copy(known->objective.begin(), known->objective.end(),
              solved.trajectory.objective.begin() + range.first);
    std::copy(known->depths.begin(), known->depths.end(), solved.depths.begin() + range.first);
  }
  for (Open& one : open) {
    const FrameRange range = one.range;
    solveAgain(solved.problem, work.solving.options, range.first, range.end, work.progress,
               solved.trajectory);
    measureDepths(work.hand, object_O_, range, work.threads, work.progress, solved);
    Stretch stretch;
    stretch.key = std::move(one.key);
    const auto part = [&](const auto& list) {
      return std::decay_t<decltype(list)>(list.begin() + range.first, list.begin() + range.end);
    };
    stretch.poses = part(solved.trajectory.poses);
    stretch.objective = part(solved.trajectory.objective);
    stretch.depths = part(solved.depths);
    stretches_.push_front(std::move(stretch));
    if (on_stretch) on_stretch(solved, range);
  }
  std::size_t kept = 0;
  for (auto stretch = stretches_.begin(); stretch != stretches_.end();) {
    kept += stretch->poses.size();
    stretch = kept > kFramesKept ? stretches_.erase(stretch) : std::next(stretch);
  }
}

}  // namespace handgraft::retargeting
