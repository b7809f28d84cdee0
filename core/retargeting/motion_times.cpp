#include "core/retargeting/motion_times.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/optimize/drag.h"
#include "core/retargeting/motion_layer.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/pinned_points.h"
#include "core/session/timed_edit.h"

namespace handgraft::retargeting {

namespace {

using manipulation::FrameOwn;
using manipulation::MotionProblem;
using manipulation::PairSpan;
using manipulation::PairTrack;
using manipulation::PatchKey;
using manipulation::PatchTrack;
using Pairs = std::vector<optimize::PointPair>;

constexpr int kShares = 12;  // steps in which a patch goes to an edited root
// Farther on the hand it fades out and in: halfway between two fingers there is none.
constexpr double kFarOnHand = 0.025;  // m

/// Pairs of what is held at a place, as firm as it is among what one frame has.
void holdAt(const optimize::DragTarget& target,
            double weight,
            const optimize::PoseProblem& single,
            FrameOwn& own) {
  double of_patches = contact::kDefaultInterpolationCount;  // where nothing touches
  for (const optimize::PointPair& pair : single.pairs)
    of_patches += pair.patch >= 0 ? pair.weight : 0.0;
  for (const optimize::PointPair& pair :
       optimize::pairsOf(target, session::kHeldFirmness * weight * of_patches))
    own.pairs.push_back(pair);
}

const std::string* movedPatchOf(const session::TimedEdit& edit) {
  if (const auto* root = std::get_if<session::PatchRootEdit>(&edit.change)) return &root->patch;
  if (const auto* turn = std::get_if<session::PatchDirectionEdit>(&edit.change))
    return &turn->patch;
  return nullptr;
}

session::Side sideOf(const session::TimedEdit& edit) {
  const auto* root = std::get_if<session::PatchRootEdit>(&edit.change);
  return root != nullptr ? root->side : std::get<session::PatchDirectionEdit>(edit.change).side;
}

/// A share of the way from one number to another; from no limit or to none at its middle.
void go(double& value, double to, double share) {
  if (std::isfinite(value) && std::isfinite(to))
    value = std::lerp(value, to, share);  // with all of it there, to the bit
  else if (share >= 0.5)
    value = to;
}

class EditsAtTimes {
 public:
  EditsAtTimes(const LaidOut& laid_out, const Progress& progress, MotionProblem& problem)
      : at_(laid_out),
        progress_(progress),
        problem_(problem),
        names_(patchNames(laid_out.motion)) {}

  void weigh();
  void hold();
  void move();
  void drag();

 private:
  /// A patch's weight at a frame, and how much it counts.
  struct Counts {
    double weight;
    double enabled;
  };

  [[nodiscard]] std::map<int, double> influencesOf(const session::TimedEdit& edit) const {
    return session::influencesOf(edit, problem_.time_s);
  }

  [[nodiscard]] const session::DocumentPatch& patch(std::size_t index) const {
    return at_.document.patches[index];
  }

  [[nodiscard]] double ownWeight(std::size_t index) const {
    return at_.grasp.patches[index].weight;
  }

  [[nodiscard]] std::optional<std::size_t> indexOf(const std::string& name) const;
  [[nodiscard]] std::vector<int> tracksOf(std::size_t patch) const;
  /// Of the patches that edits weigh or switch, at the frames that they reach.
  [[nodiscard]] std::map<std::size_t, std::map<int, Counts>> countsAtTimes() const;
  void weighTrack(int track, std::size_t patch, const std::map<int, Counts>& at_frames);
  void limit(const session::TimedEdit& edit,
             const std::string& joint,
             double lower,
             double upper);
  void soften(const session::TimedEdit& edit, const session::JointSoftEdit& soft);
  [[nodiscard]] Shift rootShift(const session::PatchRootEdit& edit,
                                const PatchKey& there,
                                const MotionLayer& layer) const;

  /// How far a patch is moved at a frame, and how much of it is there.
  struct Move {
    Shifts shifts;
    double fade = 1.0;
  };

  static void moveOn(const session::TimedEdit& edit,
                     const Shift& to,
                     double influence,
                     Move& move);
  [[nodiscard]] std::map<int, Move> movesOf(std::size_t patch,
                                            const PatchTrack& track,
                                            const MotionLayer& layer) const;
  void moveTrack(int index, std::size_t patch, const MotionLayer& layer);

  const LaidOut& at_;
  const Progress& progress_;
  MotionProblem& problem_;
  const std::vector<std::string> names_;
};

std::optional<std::size_t> EditsAtTimes::indexOf(const std::string& name) const {
  const auto& patches = at_.document.patches;
  for (std::size_t i = 0; i < patches.size() && i < names_.size(); ++i)
    if (patches[i].name == name) return i;
  return std::nullopt;
}

std::vector<int> EditsAtTimes::tracksOf(std::size_t patch) const {
  std::vector<int> tracks;
  for (std::size_t t = 0; t < problem_.tracks.size(); ++t) {
    const auto of_motion = static_cast<std::size_t>(at_.laid.track_of[t]);
    if (at_.motion.tracks[of_motion].name == names_[patch])
      tracks.push_back(static_cast<int>(t));
  }
  return tracks;
}

// === Weights, and whether a patch counts

std::map<std::size_t, std::map<int, EditsAtTimes::Counts>> EditsAtTimes::countsAtTimes() const {
  std::map<std::size_t, std::map<int, Counts>> counts;
  const auto change = [&](const session::TimedEdit& edit, const std::string& name, auto apply) {
    const auto index = indexOf(name);
    if (!index) return;
    const Counts throughout{patch(*index).weight, patch(*index).enabled ? 1.0 : 0.0};
    for (const auto& [frame, influence] : influencesOf(edit))
      apply(counts[*index].try_emplace(frame, throughout).first->second, influence);
  };
  for (const session::TimedEdit& edit : at_.document.timed) {
    if (const auto* weight = std::get_if<session::PatchWeightEdit>(&edit.change)) {
      change(edit, weight->patch, [&](Counts& now, double share) {
        go(now.weight, weight->weight, share);
      });
    } else if (const auto* on = std::get_if<session::PatchEnabledEdit>(&edit.change)) {
      change(edit, on->patch, [&](Counts& now, double share) {
        go(now.enabled, on->enabled ? 1.0 : 0.0, share);
      });
    }
  }
  return counts;
}

void EditsAtTimes::weighTrack(int track,
                              std::size_t patch,
                              const std::map<int, Counts>& at_frames) {
  const double own = ownWeight(patch);
  const double before = shareOf(this->patch(patch), own);
  // Switched off throughout, its pairs weigh nothing: as they were laid, off elsewhere.
  if (before == 0.0) {
    const auto t = static_cast<std::size_t>(track);
    problem_.tracks[t] = at_.laid.tracks[t];
    for (int frame = 0; frame < problem_.frameCount(); ++frame)
      problem_.own[frame].shares[track] = 0.0;
  }
  for (const auto& [frame, now] : at_frames) {
    const double weight = now.weight * now.enabled;
    const double share = own > 0.0 ? weight / own : weight;
    problem_.own[frame].shares[track] = before == 0.0 ? share : share / before;
  }
}

void EditsAtTimes::weigh() {
  for (const auto& [index, at_frames] : countsAtTimes())
    for (const int track : tracksOf(index))
      weighTrack(track, index, at_frames);
}

// === Limits and what holds joints, frame by frame

void EditsAtTimes::limit(const session::TimedEdit& edit,
                         const std::string& joint,
                         double lower,
                         double upper) {
  const int dof = problem_.model->dofIndex(joint);
  for (const auto& [frame, influence] : influencesOf(edit)) {
    FrameOwn& own = problem_.own[frame];
    if (own.lower.size() == 0) own.lower = problem_.lower;
    if (own.upper.size() == 0) own.upper = problem_.upper;
    go(own.lower[dof], lower, influence);
    go(own.upper[dof], upper, influence);
    if (own.lower[dof] > own.upper[dof]) own.upper[dof] = own.lower[dof];
  }
}

void EditsAtTimes::soften(const session::TimedEdit& edit, const session::JointSoftEdit& soft) {
  const auto dof = static_cast<std::size_t>(problem_.model->dofIndex(soft.joint));
  const std::size_t joints = at_.document.joints.size();
  for (const auto& [frame, influence] : influencesOf(edit)) {
    FrameOwn& own = problem_.own[frame];
    own.soft_weights.resize(joints, 0.0);
    own.soft_values.resize(joints, 0.0);
    // What holds it throughout goes as this comes.
    const double before = (1.0 - influence) * own.soft_weights[dof];
    const double now = influence * soft.weight;
    const double all = before + now;
    own.soft_values[dof] =
        all > 0.0 ? (before * own.soft_values[dof] + now * soft.value) / all : soft.value;
    own.soft_weights[dof] = all;
  }
}

void EditsAtTimes::hold() {
  for (const session::TimedEdit& edit : at_.document.timed) {
    if (const auto* range = std::get_if<session::JointLimitEdit>(&edit.change)) {
      limit(edit, range->joint, range->lower, range->upper);
    } else if (const auto* lock = std::get_if<session::JointLockEdit>(&edit.change)) {
      const auto dof = static_cast<std::size_t>(problem_.model->dofIndex(lock->joint));
      const session::DocumentJoint& joint = at_.document.joints[dof];
      if (lock->locked)
        limit(edit, lock->joint, *lock->value, *lock->value);
      else
        limit(edit, lock->joint, joint.lower, joint.upper);
    } else if (const auto* soft = std::get_if<session::JointSoftEdit>(&edit.change)) {
      soften(edit, *soft);
    }
  }
}

// === Roots and directions

Shift EditsAtTimes::rootShift(const session::PatchRootEdit& edit,
                              const PatchKey& there,
                              const MotionLayer& layer) const {
  Shift to;
  if (edit.side == session::Side::kObject) {
    const contact::Patch from = withDirection(at_.object_O, there.patch);
    to.way_T = wayTo(at_.object_O, from.root, *from.direction_O, edit.root, edit.patch);
    return to;
  }
  const auto placement = layer.placementOf(there);
  if (!placement)
    rejectInput("patch {} has no place on this hand to be moved from", quoted(edit.patch));
  to.way_T = wayTo(at_.hand.skin->mesh(), placement->root_S, placement->direction_S, edit.root,
                   edit.patch);
  return to;
}

/// Moves on by what holds of an edit at a frame: part of the way on which a root goes, `to`, or
/// part of a direction's turn.
void EditsAtTimes::moveOn(const session::TimedEdit& edit,
                          const Shift& to,
                          double influence,
                          Move& move) {
  const bool is_on_object = sideOf(edit) == session::Side::kObject;
  Shift& shift = is_on_object ? move.shifts.on_object : move.shifts.on_hand;
  double share = std::round(kShares * influence) / kShares;
  if (const auto* turn = std::get_if<session::PatchDirectionEdit>(&edit.change)) {
    shift.turn_rad += share * turn->angle_rad;
    return;
  }
  if (!is_on_object && (to.way_T - shift.way_T).norm() > kFarOnHand) {
    move.fade *= std::abs(2.0 * influence - 1.0);
    share = influence >= 0.5 ? 1.0 : 0.0;
  }
  shift.way_T += share * (to.way_T - shift.way_T);
}

/// Of a track's frames that edits move, in a few steps: each is laid onto the hand.
std::map<int, EditsAtTimes::Move> EditsAtTimes::movesOf(std::size_t patch,
                                                        const PatchTrack& track,
                                                        const MotionLayer& layer) const {
  std::map<int, Move> moves;
  for (const session::TimedEdit& edit : at_.document.timed) {
    const std::string* name = movedPatchOf(edit);
    if (name == nullptr || *name != this->patch(patch).name) continue;
    const int at = std::clamp(session::frameNearest(problem_.time_s, edit.when.time_s),
                              track.begin(), track.end - 1);
    const auto* root = std::get_if<session::PatchRootEdit>(&edit.change);
    const Shift to = root != nullptr ? rootShift(*root, track.keyAt(at), layer) : Shift();
    for (const auto& [frame, influence] : influencesOf(edit)) {
      if (frame < track.begin() || frame >= track.end) continue;
      moveOn(edit, to, influence, moves[frame]);
    }
  }
  return moves;
}

void EditsAtTimes::moveTrack(int index, std::size_t patch, const MotionLayer& layer) {
  const int motion_track = at_.laid.track_of[static_cast<std::size_t>(index)];
  const PatchTrack& track = at_.motion.tracks[static_cast<std::size_t>(motion_track)];
  const std::map<int, Move> moves = movesOf(patch, track, layer);
  const double factor = shareOf(this->patch(patch), ownWeight(patch));
  PairTrack& laid = problem_.tracks[static_cast<std::size_t>(index)];
  const std::vector<PairSpan> before = std::move(laid.spans);
  const auto pairs_before = [&](int frame) -> const Pairs& {
    const auto span = std::find_if(before.rbegin(), before.rend(), [&](const PairSpan& one) {
      return one.begin <= frame;
    });
    return span == before.rend() ? before.front().pairs : span->pairs;
  };
  std::map<int, Pairs> spans;
  for (const PairSpan& span : before)
    spans[span.begin] = span.pairs;
  std::map<std::pair<const PatchKey*, Shifts>, Pairs> known;
  for (const auto& [frame, move] : moves) {
    progress_.checkpoint();
    const Shifts& shift = move.shifts;
    if (move.fade < 1.0) problem_.own[frame].fades[index] = move.fade;
    if (shift.isNone()) {
      spans[frame] = pairs_before(frame);
    } else {
      const PatchKey& key = track.keyAt(frame);
      auto found = known.find({&key, shift});
      if (found == known.end()) {
        Pairs pairs = layer.layKey(at_.motion, motion_track, key, shift, progress_);
        for (optimize::PointPair& pair : pairs) {
          pair.patch = index;
          if (factor > 0.0) pair.weight *= factor;
        }
        found = known.emplace(std::pair(&key, shift), std::move(pairs)).first;
      }
      spans[frame] = found->second;
    }
    if (moves.count(frame + 1) == 0 && frame + 1 < laid.end && spans.count(frame + 1) == 0)
      spans[frame + 1] = pairs_before(frame + 1);
  }
  laid.spans.clear();
  for (auto& [begin, pairs] : spans)
    laid.spans.push_back({begin, std::move(pairs)});
}

void EditsAtTimes::move() {
  std::set<std::size_t> moved;
  for (const session::TimedEdit& edit : at_.document.timed)
    if (const std::string* name = movedPatchOf(edit))
      if (const auto index = indexOf(*name)) moved.insert(*index);
  if (moved.empty()) return;
  const MotionLayer layer(at_.document, at_.hand, at_.object_O, at_.motion);
  for (const std::size_t patch : moved)
    for (const int track : tracksOf(patch))
      moveTrack(track, patch, layer);
}

// === Places that were dragged

void EditsAtTimes::drag() {
  const manipulation::FrameProblems singles(problem_, at_.fade);
  hand::HandPose rest;
  rest.q = problem_.prior;
  for (const session::TimedEdit& edit : at_.document.timed) {
    const auto* way = std::get_if<session::DragPath>(&edit.change);
    if (way == nullptr) continue;
    const std::map<int, double> influences = influencesOf(edit);
    for (std::size_t i = 0; i < way->targets_O.size(); ++i) {
      const int frame = way->first_frame + static_cast<int>(i);
      const auto influence = influences.find(frame);
      if (influence == influences.end() || frame >= problem_.frameCount()) continue;
      optimize::DragTarget target;
      target.link = problem_.model->linkIndex(way->link);
      target.p_L = way->p_L;
      target.target_W = way->targets_O[i];
      holdAt(target, influence->second * way->weight, singles.at(frame, rest),
             problem_.own[frame]);
    }
  }
}

}  // namespace

double shareOf(const session::DocumentPatch& patch, double own) {
  return own > 0.0 ? patch.effectiveWeight() / own : patch.effectiveWeight();
}

std::vector<PairTrack> weighed(const session::Document& document,
                               const contact::ContactSet& grasp,
                               const manipulation::Motion& motion,
                               manipulation::TransferredMotion laid) {
  // The document's switches and weights, which it has by the patches' names.
  const std::vector<std::string> names = patchNames(motion);
  std::map<std::string, double> factors;
  for (std::size_t i = 0; i < names.size() && i < document.patches.size(); ++i)
    factors[names[i]] = shareOf(document.patches[i], grasp.patches[i].weight);
  bool any = false;
  for (std::size_t t = 0; t < laid.tracks.size(); ++t) {
    const std::string& name = motion.tracks[static_cast<std::size_t>(laid.track_of[t])].name;
    const auto found = factors.find(name);
    const double factor = found == factors.end() ? 1.0 : found->second;
    any = any || factor > 0.0;
    if (factor == 1.0) continue;
    for (PairSpan& span : laid.tracks[t].spans)
      for (optimize::PointPair& pair : span.pairs)
        pair.weight *= factor;
  }
  if (!any) rejectInput("all patches of motion {} are switched off", quoted(motion.name));
  return std::move(laid.tracks);
}

void holdThroughout(const session::Document& document,
                    const manipulation::Fade& fade,
                    MotionProblem& problem) {
  const bool is_soft = std::any_of(document.joints.begin(), document.joints.end(),
                                   [](const session::DocumentJoint& joint) {
                                     return joint.soft_weight > 0.0;
                                   });
  if (!is_soft && document.held.empty()) return;
  const manipulation::FrameProblems singles(problem, fade);
  hand::HandPose rest;
  rest.q = problem.prior;
  const Pose X_OW = inverse(document.X_WO);
  for (int frame = 0; frame < problem.frameCount(); ++frame) {
    manipulation::FrameOwn own;
    for (const session::DocumentJoint& joint : document.joints) {
      if (!is_soft) break;
      own.soft_weights.push_back(joint.soft_weight);
      own.soft_values.push_back(joint.soft_value);
    }
    for (const session::PinnedPoint& place : document.held) {
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

void layAtTimes(const LaidOut& laid_out, const Progress& progress, MotionProblem& problem) {
  EditsAtTimes edits(laid_out, progress, problem);
  edits.weigh();
  edits.hold();
  edits.move();
  edits.drag();
}

}  // namespace handgraft::retargeting
