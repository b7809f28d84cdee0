#include "core/session/motion_bench.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <numbers>
#include <set>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/tangent.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/offline_solver.h"
#include "core/manipulation/patch_path.h"
#include "core/optimize/drag.h"
#include "core/session/field_bytes.h"
#include "core/session/held_places.h"
#include "core/session/motion_layer.h"
#include "core/session/solids.h"
#include "core/session/timed_edit.h"

namespace handgraft::session {

namespace {

using manipulation::LaidMotion;
using manipulation::Motion;
using manipulation::MotionProblem;
using manipulation::PairSpan;
using manipulation::PairTrack;
using manipulation::PatchKey;
using manipulation::PatchTrack;

constexpr int kShares = 12;                 // steps in which a patch goes to an edited root
constexpr std::size_t kFramesKept = 20000;  // of bases beside the last one, and of stretches

/// The document's switches and weights of a patch, as shares of the patch's own.
double shareOf(const DocumentPatch& patch, double own) {
  return own > 0.0 ? patch.effectiveWeight() / own : patch.effectiveWeight();
}

}  // namespace

struct MotionBench::Work {
  const Document& document;
  const Hand& hand;
  const MotionSolving& solving;
  int threads;
  const Progress& progress;
  std::string base_key;
  bool from_nothing;
};

namespace {

/// Frames are independent: each thread takes every so-manyth.
void measureDepths(const Hand& hand,
                   const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                   FrameRange range,
                   int threads,
                   const Progress& progress,
                   SolvedMotion& solved) {
  const std::vector<hand::HandPose>& poses = solved.trajectory.poses;
  makeSolids(hand, object_O, progress);
  const auto step = static_cast<std::size_t>(std::max(1, threads));
  const auto first_frame = static_cast<std::size_t>(range.first);
  const auto end = static_cast<std::size_t>(range.end);
  std::vector<std::exception_ptr> errors(step);
  const auto measure = [&](std::size_t first) {
    try {
      for (std::size_t k = first_frame + first; k < end; k += step) {
        progress.checkpoint();
        if (first == 0) {
          progress.report("measuring depths",
                          static_cast<double>(k) / static_cast<double>(poses.size()));
        }
        solved.depth_m[k] = deepestOf(hand.model, hand.skin, object_O, poses[k], progress);
      }
    } catch (...) {
      errors[first] = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < step; ++i)
    others.emplace_back(measure, i);
  measure(0);
  for (std::thread& other : others)
    other.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

bool arePosesSame(const hand::HandPose& a, const hand::HandPose& b) {
  return a.q == b.q && a.X_WH.matrix() == b.X_WH.matrix();
}

/// What a patch's edit at a time moves, as a shift from where the motion has it then.
void goBy(const TimedEdit& edit,
          const Shift& turn_from,
          double share,
          const std::optional<Shift>& root,
          Shift& shift) {
  if (std::holds_alternative<PatchRootEdit>(edit.change)) {
    Shift to = *root;
    to.turn_rad = turn_from.turn_rad;
    shift.go(to, share);
  } else {
    shift.turn_rad += share * std::get<PatchDirectionEdit>(edit.change).angle_rad;
  }
}

const std::string* patchOfTimed(const TimedEdit& edit) {
  if (const auto* root = std::get_if<PatchRootEdit>(&edit.change)) return &root->patch;
  if (const auto* turn = std::get_if<PatchDirectionEdit>(&edit.change)) return &turn->patch;
  return nullptr;
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

/// Pairs of what is held at a place, as firm as it is among what one frame has.
void holdAt(const optimize::DragTarget& target,
            double weight,
            const optimize::PoseProblem& single,
            manipulation::FrameOwn& own) {
  double of_patches = contact::kDefaultInterpolationCount;  // where nothing touches
  for (const optimize::PointPair& pair : single.pairs)
    of_patches += pair.patch >= 0 ? pair.weight : 0.0;
  for (const optimize::PointPair& pair :
       optimize::pairsOf(target, kHeldFirmness * weight * of_patches))
    own.pairs.push_back(pair);
}

/// Joints that are held softly and places that were dragged, for all of the motion.
void holdThroughout(const Document& document,
                    const manipulation::Fade& fade,
                    MotionProblem& problem) {
  const bool is_soft = std::any_of(document.joints.begin(), document.joints.end(),
                                   [](const DocumentJoint& joint) {
                                     return joint.soft_weight > 0.0;
                                   });
  if (!is_soft && document.held.empty()) return;
  const manipulation::FrameProblems singles(problem, fade);
  hand::HandPose rest;
  rest.q = problem.prior;
  const Pose X_OW = inverse(document.X_WO);
  for (int frame = 0; frame < problem.frameCount(); ++frame) {
    manipulation::FrameOwn own;
    for (const DocumentJoint& joint : document.joints) {
      if (!is_soft) break;
      own.soft_weights.push_back(joint.soft_weight);
      own.soft_values.push_back(joint.soft_value);
    }
    for (const HeldPlace& place : document.held) {
      optimize::DragTarget target;
      target.link = problem.model->linkIndex(place.link);
      target.p_L = place.p_L;
      target.target_W = X_OW * place.target_W;
      if (place.target_R_WL) target.R_WL = X_OW.linear() * *place.target_R_WL;
      holdAt(target, place.weight, singles.at(frame, rest), own);
    }
    problem.own[frame] = std::move(own);
  }
}

/// The frames of an edit and those that smoothness couples to them.
FrameRange stretchOf(const TimedEdit& edit, const std::vector<double>& time_s) {
  const std::map<int, double> influences = influencesOf(edit, time_s);
  const auto timeAt = [&](int frame) {
    return time_s[static_cast<std::size_t>(frame)];
  };
  FrameRange range{influences.begin()->first, influences.rbegin()->first + 1};
  const double from = timeAt(range.first) - MotionBench::kMargin_s;
  const double to = timeAt(range.end - 1) + MotionBench::kMargin_s;
  while (range.first > 0 && timeAt(range.first - 1) >= from)
    --range.first;
  while (range.end < static_cast<int>(time_s.size()) && timeAt(range.end) <= to)
    ++range.end;
  return range;
}

}  // namespace

MotionBench::MotionBench(std::shared_ptr<const Motion> motion,
                         std::shared_ptr<const geometry::TriangleMesh> object_O)
    : motion_(std::move(motion)),
      object_O_(std::move(object_O)),
      grasp_(graspOf(*motion_, *object_O_)) {}

std::shared_ptr<const SolvedMotion> MotionBench::solve(const Document& document,
                                                       const Hand& hand,
                                                       MotionSolving solving,
                                                       int threads,
                                                       const Progress& progress,
                                                       const OnStretch& on_stretch,
                                                       bool from_nothing) {
  solving.options.threads = threads;
  FieldWriter key;
  key.add(document.hand);
  for (const DocumentPatch& patch : document.patches) {
    key.add(patch.name);
    key.add(patch.effectiveWeight());
    key.add(patch.root_O);
    key.add(patch.direction_O.value_or(Eigen::Vector3d::Zero()));
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
  const std::shared_ptr<const SolvedMotion> first = base(work);
  if (document.timed.empty()) return first;
  auto solved = std::make_shared<SolvedMotion>(*first);
  layAtTimes(work, solved->problem);
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

const LaidMotion& MotionBench::laid(const Work& work) {
  FieldWriter writer;
  writer.add(work.document.hand);
  writer.add(work.document.transfer);
  for (const DocumentPatch& patch : work.document.patches) {
    writer.add(patch.root_O);
    writer.add(patch.direction_O.value_or(Eigen::Vector3d::Zero()));
  }
  std::string key = writer.take();
  if (laid_ && key == laid_key_) return *laid_;
  const MotionLayer layer(work.document, work.hand, *object_O_, *motion_);
  // Roots and directions that were edited for all of the motion.
  const std::vector<std::string> names = patchNames(*motion_);
  Motion edited = *motion_;
  for (std::size_t i = 0; i < names.size() && i < work.document.patches.size(); ++i) {
    const DocumentPatch& now = work.document.patches[i];
    const contact::Patch before = withDirection(*object_O_, grasp_.patches[i]);
    Shift shift;
    const auto same = [&] {
      return now.root_O.face == before.root.face &&
             now.root_O.barycentric == before.root.barycentric;
    };
    if (!same())
      shift.way_T = wayTo(*object_O_, before.root, *before.direction_O, now.root_O, now.name);
    if (now.direction_O && !now.direction_is_open) {
      const Eigen::Vector3d carried =
          tangentCarried(*object_O_, before.root, now.root_O, *before.direction_O);
      const Eigen::Vector3d n = normalOf(*object_O_, now.root_O);
      const double turn =
          std::atan2(n.dot(carried.cross(*now.direction_O)), carried.dot(*now.direction_O));
      if (std::abs(turn) > 1e-9) shift.turn_rad = turn;
    }
    if (shift.isNone()) continue;
    for (PatchTrack& track : edited.tracks) {
      if (track.name != names[i]) continue;
      for (PatchKey& patch_key : track.keys)
        patch_key.patch = movedOver(*object_O_, patch_key.patch, shift);
    }
  }
  laid_ = layer.lay(edited, work.progress);
  laid_key_ = std::move(key);
  return *laid_;
}

std::shared_ptr<const SolvedMotion> MotionBench::base(const Work& work) {
  const auto known = std::find_if(bases_.begin(), bases_.end(), [&](const Base& one) {
    return one.key == work.base_key;
  });
  if (known != bases_.end()) {
    bases_.splice(bases_.begin(), bases_, known);
    return bases_.front().solved;
  }
  const Document& document = work.document;
  auto made = std::make_shared<SolvedMotion>();
  SolvedMotion& solved = *made;
  solved.solving = work.solving;
  solved.problem = motionProblemOf(document, work.hand, motion_->time_s, work.solving);
  const LaidMotion& laid_motion = laid(work);
  solved.problem.tracks = laid_motion.tracks;
  solved.track_of = laid_motion.track_of;
  solved.notes = remarksOn(*motion_);
  solved.notes.insert(solved.notes.end(), laid_motion.notes.begin(), laid_motion.notes.end());

  // === The document's switches and weights, which it has by the patches' names
  const std::vector<std::string> names = patchNames(*motion_);
  std::map<std::string, double> factors;
  for (std::size_t i = 0; i < names.size() && i < document.patches.size(); ++i)
    factors[names[i]] = shareOf(document.patches[i], grasp_.patches[i].weight);
  bool any = false;
  for (std::size_t t = 0; t < solved.problem.tracks.size(); ++t) {
    const std::string& name =
        motion_->tracks[static_cast<std::size_t>(solved.track_of[t])].name;
    const auto found = factors.find(name);
    const double factor = found == factors.end() ? 1.0 : found->second;
    any = any || factor > 0.0;
    if (factor == 1.0) continue;
    for (PairSpan& span : solved.problem.tracks[t].spans)
      for (optimize::PointPair& pair : span.pairs)
        pair.weight *= factor;
  }
  if (!any) rejectInput("all patches of motion {} are switched off", quoted(motion_->name));

  holdThroughout(document, work.solving.options.fade, solved.problem);
  if (document.solving.avoids()) {
    solved.problem.avoidance = avoidanceOf(work.hand.model, work.hand.skin, object_O_,
                                           Pose::Identity(), work.progress);
  }
  const manipulation::MotionOptions& options = work.solving.options;
  const int count = solved.problem.frameCount();
  const SolvedMotion* before = bases_.empty() ? nullptr : bases_.front().solved.get();
  if (work.solving.causal) {
    solved.trajectory = solveCausal(solved.problem, options, work.progress);
  } else if (!work.from_nothing && before != nullptr && !before->solving.causal &&
             before->problem.model == solved.problem.model) {
    solved.trajectory = before->trajectory;
    solved.trajectory.notes.clear();
    solveAgain(solved.problem, options, 0, count, work.progress, solved.trajectory);
  } else {
    solved.trajectory = solveOffline(solved.problem, options, work.progress);
  }
  solved.notes.insert(solved.notes.end(), solved.trajectory.notes.begin(),
                      solved.trajectory.notes.end());
  solved.depth_m.assign(static_cast<std::size_t>(count), 0.0);
  measureDepths(work.hand, object_O_, {0, count}, work.threads, work.progress, solved);
  bases_.push_front({work.base_key, made});
  std::size_t frames = 0;
  for (auto base = std::next(bases_.begin()); base != bases_.end();) {
    frames += base->solved->trajectory.poses.size();
    base = frames > kFramesKept ? bases_.erase(base) : std::next(base);
  }
  return made;
}

void MotionBench::layAtTimes(const Work& work, MotionProblem& problem) {
  const Document& document = work.document;
  const std::vector<std::string> names = patchNames(*motion_);
  const auto patchIndexOf = [&](const std::string& name) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < document.patches.size() && i < names.size(); ++i)
      if (document.patches[i].name == name) return i;
    return std::nullopt;
  };
  const auto tracksOf = [&](std::size_t patch) {
    std::vector<int> tracks;
    for (std::size_t t = 0; t < problem.tracks.size(); ++t)
      if (motion_->tracks[static_cast<std::size_t>(laid_->track_of[t])].name == names[patch])
        tracks.push_back(static_cast<int>(t));
    return tracks;
  };
  const int frames = problem.frameCount();

  // === Weights, and whether a patch counts
  struct Counts {
    double weight;
    double enabled;
  };

  std::map<std::size_t, std::map<int, Counts>> counts;  // by patch, frame
  // === Limits and what holds joints, frame by frame
  for (const TimedEdit& edit : document.timed) {
    const std::map<int, double> influences = influencesOf(edit, problem.time_s);
    const auto weigh = [&](const std::string& name, const auto& change) {
      const auto patch = patchIndexOf(name);
      if (!patch) return;
      const DocumentPatch& own = document.patches[*patch];
      for (const auto& [frame, influence] : influences) {
        Counts& at = counts[*patch]
                         .try_emplace(frame, Counts{own.weight, own.enabled ? 1.0 : 0.0})
                         .first->second;
        change(at, influence);
      }
    };
    const auto limit = [&](const std::string& joint, double lower, double upper) {
      const int dof = problem.model->dofIndex(joint);
      for (const auto& [frame, influence] : influences) {
        manipulation::FrameOwn& own = problem.own[frame];
        if (own.lower.size() == 0) own.lower = problem.lower;
        if (own.upper.size() == 0) own.upper = problem.upper;
        const auto go = [share = influence](double& value, double to) {
          if (std::isfinite(value) && std::isfinite(to))
            value += share * (to - value);
          else if (share >= 0.5)
            value = to;
        };
        go(own.lower[dof], lower);
        go(own.upper[dof], upper);
        if (own.lower[dof] > own.upper[dof]) own.upper[dof] = own.lower[dof];
      }
    };
    if (const auto* weight = std::get_if<PatchWeightEdit>(&edit.change)) {
      weigh(weight->patch, [&](Counts& at, double share) {
        at.weight += share * (weight->weight - at.weight);
      });
    } else if (const auto* on = std::get_if<PatchEnabledEdit>(&edit.change)) {
      weigh(on->patch, [&](Counts& at, double share) {
        at.enabled += share * ((on->enabled ? 1.0 : 0.0) - at.enabled);
      });
    } else if (const auto* range = std::get_if<JointLimitEdit>(&edit.change)) {
      limit(range->joint, range->lower, range->upper);
    } else if (const auto* lock = std::get_if<JointLockEdit>(&edit.change)) {
      const DocumentJoint& joint =
          document.joints[static_cast<std::size_t>(problem.model->dofIndex(lock->joint))];
      if (lock->locked)
        limit(lock->joint, *lock->value, *lock->value);
      else
        limit(lock->joint, joint.lower, joint.upper);
    } else if (const auto* soft = std::get_if<JointSoftEdit>(&edit.change)) {
      const auto dof = static_cast<std::size_t>(problem.model->dofIndex(soft->joint));
      for (const auto& [frame, influence] : influences) {
        manipulation::FrameOwn& own = problem.own[frame];
        own.soft_weights.resize(document.joints.size(), 0.0);
        own.soft_values.resize(document.joints.size(), 0.0);
        own.soft_weights[dof] = influence * soft->weight;
        own.soft_values[dof] = soft->value;
      }
    }
  }
  for (const auto& [patch, at] : counts) {
    const double own = grasp_.patches[patch].weight;
    const double before = shareOf(document.patches[patch], own);
    const auto share = [&](const Counts& now) {
      const double weight = now.weight * now.enabled;
      return own > 0.0 ? weight / own : weight;
    };
    for (const int track : tracksOf(patch)) {
      // Switched off throughout, its pairs weigh nothing: as they were laid, off elsewhere.
      if (before == 0.0) {
        problem.tracks[static_cast<std::size_t>(track)] =
            laid_->tracks[static_cast<std::size_t>(track)];
        for (int frame = 0; frame < frames; ++frame)
          problem.own[frame].shares[track] = 0.0;
      }
      for (const auto& [frame, now] : at)
        problem.own[frame].shares[track] = before == 0.0 ? share(now) : share(now) / before;
    }
  }

  // === Roots and directions
  std::set<std::size_t> moved_patches;
  for (const TimedEdit& edit : document.timed)
    if (const std::string* name = patchOfTimed(edit))
      if (const auto patch = patchIndexOf(*name)) moved_patches.insert(*patch);
  if (!moved_patches.empty()) {
    const MotionLayer layer(document, work.hand, *object_O_, *motion_);
    const geometry::TriangleMesh& skin_S = work.hand.skin->mesh();
    for (const std::size_t patch : moved_patches) {
      const double factor = shareOf(document.patches[patch], grasp_.patches[patch].weight);
      for (const int t : tracksOf(patch)) {
        const int motion_track = laid_->track_of[static_cast<std::size_t>(t)];
        const PatchTrack& track = motion_->tracks[static_cast<std::size_t>(motion_track)];
        std::map<int, Shifts> shifts;  // by frame
        for (const TimedEdit& edit : document.timed) {
          const std::string* name = patchOfTimed(edit);
          if (name == nullptr || *name != document.patches[patch].name) continue;
          const std::map<int, double> influences = influencesOf(edit, problem.time_s);
          const int at = std::clamp(frameNearest(problem.time_s, edit.when.time_s),
                                    track.begin(), track.end - 1);
          const PatchKey& there = track.keyAt(at);
          const auto* root = std::get_if<PatchRootEdit>(&edit.change);
          const auto* turn = std::get_if<PatchDirectionEdit>(&edit.change);
          const Side side = root != nullptr ? root->side : turn->side;
          std::optional<Shift> to;
          if (root != nullptr) {
            to.emplace();
            if (side == Side::kObject) {
              const contact::Patch from = withDirection(*object_O_, there.patch);
              to->way_T =
                  wayTo(*object_O_, from.root, *from.direction_O, root->root, root->patch);
            } else if (const auto placement = layer.placementOf(there)) {
              to->way_T = wayTo(skin_S, placement->root_S, placement->direction_S, root->root,
                                root->patch);
            } else {
              rejectInput("patch {} has no place on this hand to be moved from",
                          quoted(root->patch));
            }
          }
          for (const auto& [frame, influence] : influences) {
            if (frame < track.begin() || frame >= track.end) continue;
            // In a few steps: each is laid onto the hand.
            const double share = std::round(kShares * influence) / kShares;
            Shifts& all = shifts[frame];
            Shift& shift = side == Side::kObject ? all.on_object : all.on_hand;
            goBy(edit, shift, share, to, shift);
          }
        }
        PairTrack& laid_track = problem.tracks[static_cast<std::size_t>(t)];
        const PairTrack before = laid_track;
        const auto pairsBefore = [&](int frame) {
          auto span = std::find_if(before.spans.rbegin(), before.spans.rend(),
                                   [&](const PairSpan& one) {
                                     return one.begin <= frame;
                                   });
          return span == before.spans.rend() ? before.spans.front().pairs : span->pairs;
        };
        std::map<std::pair<const PatchKey*, Shifts>, std::vector<optimize::PointPair>> known;
        std::map<int, std::vector<optimize::PointPair>> spans;
        for (const PairSpan& span : before.spans)
          spans[span.begin] = span.pairs;
        for (const auto& [frame, shift] : shifts) {
          work.progress.checkpoint();
          const PatchKey& key = track.keyAt(frame);
          auto found = known.find({&key, shift});
          if (found == known.end()) {
            std::vector<optimize::PointPair> pairs;
            if (shift.isNone()) {
              pairs = pairsBefore(frame);
            } else {
              pairs = layer.layKey(*motion_, motion_track, key, shift, work.progress);
              for (optimize::PointPair& pair : pairs) {
                pair.patch = t;
                if (factor > 0.0) pair.weight *= factor;
              }
            }
            found = known.emplace(std::pair(&key, shift), std::move(pairs)).first;
          }
          spans[frame] = found->second;
          if (shifts.count(frame + 1) == 0 && frame + 1 < laid_track.end &&
              spans.count(frame + 1) == 0)
            spans[frame + 1] = pairsBefore(frame + 1);
        }
        laid_track.spans.clear();
        for (auto& [begin, pairs] : spans)
          laid_track.spans.push_back({begin, std::move(pairs)});
      }
    }
  }

  // === Places that were dragged
  const manipulation::FrameProblems singles(problem, work.solving.options.fade);
  hand::HandPose rest;
  rest.q = problem.prior;
  for (const TimedEdit& edit : document.timed) {
    const auto* way = std::get_if<DragWay>(&edit.change);
    if (way == nullptr) continue;
    const std::map<int, double> influences = influencesOf(edit, problem.time_s);
    for (std::size_t i = 0; i < way->targets_O.size(); ++i) {
      const int frame = way->first_frame + static_cast<int>(i);
      const auto influence = influences.find(frame);
      if (influence == influences.end() || frame >= frames) continue;
      optimize::DragTarget target;
      target.link = problem.model->linkIndex(way->link);
      target.p_L = way->p_L;
      target.target_W = way->targets_O[i];
      holdAt(target, influence->second * way->weight, singles.at(frame, rest),
             problem.own[frame]);
    }
  }
}

void MotionBench::solveStretches(const Work& work,
                                 SolvedMotion& solved,
                                 const OnStretch& on_stretch) {
  const std::vector<TimedEdit>& timed = work.document.timed;
  std::vector<FrameRange> ranges;
  for (const TimedEdit& edit : timed)
    ranges.push_back(stretchOf(edit, solved.problem.time_s));

  struct Open {
    FrameRange range;
    std::string key;
  };

  std::vector<Open> open;
  for (const FrameRange& range : joined(ranges)) {
    FieldWriter writer;
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
    std::copy(known->depth_m.begin(), known->depth_m.end(),
              solved.depth_m.begin() + range.first);
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
    stretch.depth_m = part(solved.depth_m);
    stretches_.push_front(std::move(stretch));
    if (on_stretch) on_stretch(solved, range);
  }
  std::size_t kept = 0;
  for (auto stretch = stretches_.begin(); stretch != stretches_.end();) {
    kept += stretch->poses.size();
    stretch = kept > kFramesKept ? stretches_.erase(stretch) : std::next(stretch);
  }
}

}  // namespace handgraft::session
