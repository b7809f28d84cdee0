// What each edit checks and changes.
#include "core/session/apply_edit.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <set>

#include "core/base/error.h"
#include "core/base/limit_note.h"
#include "core/geometry/tangent.h"
#include "core/optimize/drag.h"
#include "core/optimize/pose_solver.h"
#include "core/session/edit_checks.h"
#include "core/session/model_swap.h"
#include "core/session/patch_matching.h"
#include "core/session/pinned_points.h"
#include "core/session/timed_edit.h"

namespace handgraft::session {
namespace {

/// Those that Session does itself; named, so that no other kind goes without its `apply`.
template <class Kind>
concept OfHistory = std::same_as<Kind, UndoEdit> || std::same_as<Kind, RedoEdit> ||
    std::same_as<Kind, SnapshotEdit> || std::same_as<Kind, RestoreEdit>;

/// One edit on its way into a document.
class Editing {
 public:
  Editing(DerivedState& derived, ModelCache& cache, const Progress& progress)
      : edited{derived.document(), ""}, derived_(derived), cache_(cache), progress_(progress) {}

  void apply(const ObjectPoseEdit& edit) {
    requireRigid(edit.X_WO, "the object's pose");
    edited.document.X_WO = edit.X_WO;
  }

  void apply(const PatchWeightEdit& edit) {
    DocumentPatch& patch = patchNamed(edit.patch);
    requireWithin(edit.weight, 0.0, contact::kLargestWeight,
                  "weight of patch " + quoted(edit.patch));
    patch.weight = edit.weight;
  }

  void apply(const PatchEnabledEdit& edit) { patchNamed(edit.patch).enabled = edit.enabled; }

  void apply(const PatchRootEdit& edit);
  void apply(const PatchDirectionEdit& edit);

  void apply(const JointLimitEdit& edit) {
    const std::string joint = "of joint " + quoted(edit.joint);
    DocumentJoint& limits = jointNamed(edit.joint);
    const std::string unit = unitOf(edit.joint);
    requireWithin(edit.lower, -kLargestJointValue, kLargestJointValue, "lower limit " + joint,
                  unit);
    requireWithin(edit.upper, -kLargestJointValue, kLargestJointValue, "upper limit " + joint,
                  unit);
    if (edit.lower > edit.upper) {
      rejectInput("lower limit {} {} {} is above its upper limit {} {}", edit.lower, unit,
                  joint, edit.upper, unit);
    }
    limits.lower = edit.lower;
    limits.upper = edit.upper;
    edited.message = noteOn(edit);
  }

  void apply(const JointLockEdit& edit) {
    jointNamed(edit.joint).locked = edit.locked;
    if (!edit.locked || !edit.value) return;
    requireWithin(*edit.value, -kLargestJointValue, kLargestJointValue,
                  "joint " + quoted(edit.joint));
    edited.document.start.q[hand().model->dofIndex(edit.joint)] = *edit.value;
  }

  void apply(const JointSoftEdit& edit) {
    DocumentJoint& joint = jointNamed(edit.joint);
    requireWithin(edit.weight, 0.0, kLargestLambda,
                  "soft weight of joint " + quoted(edit.joint));
    if (edit.weight > 0.0) requireValue(joint, edit.joint, edit.value);
    joint.soft_weight = edit.weight;
    joint.soft_value = edit.weight > 0.0 ? edit.value : 0.0;
  }

  void apply(const PriorEdit& edit);

  void apply(const PriorSharesEdit& edit) {
    validateShares(edit.shares);
    edited.document.prior_shares = edit.shares;
  }

  void apply(const WeightsEdit& edit) {
    validateWeights(edit.weights);
    edited.document.weights = edit.weights;
  }

  void apply(const SolverSettingsEdit& edit) {
    validate(edit.solving);
    edited.document.solving = edit.solving;
  }

  void apply(const DragEdit& edit);
  void apply(const ReleaseEdit& edit);
  void apply(const ChoiceEdit& edit);

  void apply(const HandEdit& edit) {
    edited = withHand(edited.document, edit.name, cache_, progress_);
    dropUnfitting();
  }

  void apply(const ObjectEdit& edit) {
    edited = withObject(edited.document, edit.name, cache_, progress_);
    dropUnfitting();
  }

  void apply(const TimedEdit& edit) {
    addTimed(edit, derived_.models(), edited.document);
    if (const auto* limits = std::get_if<JointLimitEdit>(&edit.change))
      edited.message = noteOn(*limits);
  }

  void apply(const RemoveTimedEdit& edit) {
    std::vector<TimedEdit>& timed = edited.document.timed;
    if (edit.index < 0 || edit.index >= static_cast<int>(timed.size()))
      rejectInput("edit {} at a time: there are {}", edit.index + 1, timed.size());
    timed.erase(timed.begin() + edit.index);
  }

  template <OfHistory HistoryEdit>
  void apply(const HistoryEdit& /*edit*/) {
    throw BrokenContract("an edit of the history, which is not applied");
  }

  Edited edited;

 private:
  [[nodiscard]] const hand::Hand& hand() const { return *derived_.models().hand; }

  /// On limits that are hardly meant.
  [[nodiscard]] std::string noteOn(const JointLimitEdit& edit) const {
    const hand::HandModel& model = *hand().model;
    const int dof = model.dofIndex(edit.joint);
    return limitNote(edit.joint, model.dofJoint(dof).type == hand::JointType::kPrismatic,
                     {edit.lower, edit.upper}, {model.lower()[dof], model.upper()[dof]});
  }

  /// Edits at times that name what the new model does not have.
  void dropUnfitting() {
    const Document& document = edited.document;
    const int dropped = dropUnfittingTimed(
        cache_.find(document.hand, document.object, progress_), edited.document);
    if (dropped == 0) return;
    edited.message += fmt::format("{}{} edits at times do not fit and are gone",
                                  edited.message.empty() ? "" : "; ", dropped);
  }

  DocumentPatch& patchNamed(const std::string& name) {
    std::vector<std::string> names;
    for (DocumentPatch& patch : edited.document.patches) {
      if (patch.name == name) return patch;
      names.push_back(patch.name);
    }
    rejectInput("there is no patch {}; there are {}", quoted(name), fmt::join(names, ", "));
  }

  DocumentJoint& jointNamed(const std::string& name) {
    return edited.document.joints[static_cast<std::size_t>(hand().model->dofIndex(name))];
  }

  /// Of a joint's values.
  [[nodiscard]] std::string unitOf(const std::string& joint) const {
    const hand::HandModel& model = *hand().model;
    const hand::Joint& moving = model.dofJoint(model.dofIndex(joint));
    return moving.type == hand::JointType::kPrismatic ? "m" : "rad";
  }

  void requireValue(const DocumentJoint& joint, const std::string& name, double value) const {
    // The message names the limits themselves.
    if (value >= joint.lower - kBoundTolerance && value <= joint.upper + kBoundTolerance &&
        std::abs(value) <= kLargestJointValue) {
      return;
    }
    requireWithin(value, std::max(joint.lower, -kLargestJointValue),
                  std::min(joint.upper, kLargestJointValue), "joint " + quoted(name),
                  unitOf(name));
  }

  /// The user's pose is where the next solve starts, and what it stays close to (paper, III-E).
  void takePose(const hand::HandPose& pose) {
    edited.document.start = pose;
    edited.document.prior = pose;
    edited.document.start_is_known = true;
  }

  /// From where a place that is let go had pulled the hand, nothing may lead back downhill: it
  /// is searched for as if it had not been found yet.
  void forgetAStartThatReachesNothing() {
    derived_.transfer(progress_);
    SolverSettings touching;
    touching.avoid_penetration = false;
    const optimize::PoseProblem posed = derived_.problem(touching);
    optimize::SolveReport standing;
    standing.pose = posed.start;
    optimize::judge(posed, standing);
    if (reachesNothing(posed, standing)) edited.document.start_is_known = false;
  }

  DerivedState& derived_;
  ModelCache& cache_;
  const Progress& progress_;
};

void Editing::apply(const PatchRootEdit& edit) {
  DocumentPatch& patch = patchNamed(edit.patch);
  const std::string what = "root of patch " + quoted(edit.patch);
  if (edit.side == Side::kObject) {
    const geometry::TriangleMesh& object_O = *derived_.models().object_O;
    validate(object_O, edit.root, what.c_str());
    if (patch.direction_is_open) {
      patch.direction_O.reset();
    } else {
      patch.direction_O = tangentCarried(object_O, patch.root_O, edit.root, *patch.direction_O);
    }
    patch.root_O = edit.root;
    return;
  }
  const geometry::TriangleMesh& skin_S = hand().skin->mesh();
  validate(skin_S, edit.root, what.c_str());
  patch.placement =
      patch.placement
          ? movedTo(skin_S, *patch.placement, edit.root)
          : transfer::PatchPlacement{
                edit.root, tangentAt(skin_S, edit.root, -positionOf(skin_S, edit.root))
                               .value_or(anyTangentAt(skin_S, edit.root))};
  patch.dropped.clear();
  patch.root_is_open = false;
}

void Editing::apply(const PatchDirectionEdit& edit) {
  requireWithin(edit.angle_rad, -kLargestTurn, kLargestTurn,
                "angle of patch " + quoted(edit.patch));
  DocumentPatch& patch = patchNamed(edit.patch);
  if (!patch.placement)
    rejectInput("patch {} is dropped: {}", quoted(edit.patch), patch.dropped);
  if (edit.side == Side::kHand) {
    patch.placement = turned(hand().skin->mesh(), *patch.placement, edit.angle_rad);
    patch.root_is_open = false;
    return;
  }
  std::optional<Eigen::Vector3d> direction_O = patch.direction_O;
  if (!direction_O) {
    derived_.findOpenDirections(progress_);
    const auto index = static_cast<std::size_t>(&patch - edited.document.patches.data());
    direction_O = derived_.patches()[index].patch.direction_O;
    HANDGRAFT_REQUIRE(direction_O.has_value());
  }
  patch.direction_O =
      tangentTurned(*derived_.models().object_O, patch.root_O, *direction_O, edit.angle_rad);
  patch.direction_is_open = false;
}

void Editing::apply(const PriorEdit& edit) {
  if (edit.X_WH) requireRigid(*edit.X_WH, "the hand's pose");
  if (edit.joints.size() != edit.q.size()) {
    rejectInput("{} joints with {} values; one value per joint is needed", edit.joints.size(),
                edit.q.size());
  }
  hand::HandPose pose = edited.document.start;
  if (edit.X_WH) pose.X_WH = *edit.X_WH;
  std::vector<int> seen;
  for (std::size_t i = 0; i < edit.joints.size(); ++i) {
    const int dof = hand().model->dofIndex(edit.joints[i]);
    if (std::find(seen.begin(), seen.end(), dof) != seen.end())
      rejectInput("joint {} is named twice", quoted(edit.joints[i]));
    seen.push_back(dof);
    requireValue(edited.document.joints[static_cast<std::size_t>(dof)], edit.joints[i],
                 edit.q[i]);
    pose.q[dof] = edit.q[i];
  }
  takePose(pose);
}

void Editing::apply(const DragEdit& edit) {
  optimize::DragTarget target;
  target.link = hand().model->linkIndex(edit.link);
  target.p_L = edit.p_L;
  target.target_W = edit.target_W;
  target.R_WL = edit.target_R_WL;
  if (edit.target_R_WL) {
    Pose X = Pose::Identity();
    X.linear() = *edit.target_R_WL;
    requireRigid(X, "the target's rotation");
  }
  requireWithin(edit.weight, 0.0, contact::kLargestWeight, "weight of a drag");
  derived_.transfer(progress_);
  const optimize::DragResult result =
      optimize::drag(derived_.problem(SolverSettings()), target, {}, progress_);
  takePose(result.pose);
  letGo(edited.document, edit.link);
  if (edit.weight > 0.0) {
    edited.document.held.push_back(
        {edit.link, edit.p_L, edit.target_W, edit.target_R_WL, edit.weight});
  }
  constexpr double kToldShort = 1e-4;  // m
  constexpr double kToldTurn = 1e-3;   // rad
  if (result.short_m > kToldShort)
    edited.message = fmt::format("{:.1f} mm short of its target", result.short_m * 1e3);
  if (result.short_rad > kToldTurn) {
    edited.message +=
        fmt::format("{}{:.1f} deg short of its rotation", edited.message.empty() ? "" : ", ",
                    result.short_rad * 57.29577951308232);
  }
}

void Editing::apply(const ReleaseEdit& edit) {
  Document& document = edited.document;
  const auto goes = [&](const TimedEdit& timed) {
    const auto* way = std::get_if<DragPath>(&timed.change);
    return way != nullptr && (edit.link.empty() || way->link == edit.link);
  };
  if (std::erase_if(document.timed, goes) > 0) {
    if (edit.link.empty())
      document.held.clear();
    else
      letGo(document, edit.link);
    return;
  }
  if (document.held.empty()) rejectInput("nothing is held: no place was dragged");
  if (edit.link.empty()) {
    document.held.clear();
  } else if (!letGo(document, edit.link)) {
    rejectInput("link {} is not held; held are {}", quoted(edit.link),
                fmt::join(heldLinks(document), ", "));
  }
  if (document.held.empty()) forgetAStartThatReachesNothing();
}

void Editing::apply(const ChoiceEdit& edit) {
  HANDGRAFT_REQUIRE(edit.pose.has_value());
  const std::string what = fmt::format("minimum {}", edit.rank);
  requireRigid(edit.pose->X_WH, what.c_str());
  const std::vector<DocumentJoint>& joints = edited.document.joints;
  if (static_cast<std::size_t>(edit.pose->q.size()) != joints.size())
    rejectInput("{} has {} joints; the hand has {}", what, edit.pose->q.size(), joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i)
    requireValue(joints[i], hand().model->dofJoint(static_cast<int>(i)).name,
                 edit.pose->q[static_cast<Eigen::Index>(i)]);
  takePose(*edit.pose);
}

void requireTangent(const Eigen::Vector3d& direction,
                    const Eigen::Vector3d& normal,
                    const std::string& what) {
  constexpr double kUnitTolerance = 1e-3;
  const double length = direction.norm();
  if (!(std::abs(length - 1.0) <= kUnitTolerance))
    rejectInput("{} has length {:.6g}; it must be 1", what, length);
  constexpr double kAlongNormal = 0.999;  // the cosine
  if (std::abs(direction.dot(normal)) > kAlongNormal)
    rejectInput("{} points along the surface's normal", what);
}

void validatePose(const hand::HandPose& pose, std::size_t joints, const char* what) {
  requireRigid(pose.X_WH, what);
  if (static_cast<std::size_t>(pose.q.size()) != joints)
    rejectInput("{} has {} joints; the hand has {}", what, pose.q.size(), joints);
  for (const double q : pose.q)
    requireWithin(q, -kLargestJointValue, kLargestJointValue,
                  std::string("a joint of ") + what);
}

void validate(const DocumentPatch& patch, const Models& models) {
  const std::string name = quoted(patch.name);
  requireWithin(patch.weight, 0.0, contact::kLargestWeight, "weight of patch " + name);
  const std::string root = "root of patch " + name;
  validate(*models.object_O, patch.root_O, root.c_str());
  if (patch.direction_O) {
    requireTangent(*patch.direction_O, normalOf(*models.object_O, patch.root_O),
                   "direction of patch " + name);
  } else if (!patch.direction_is_open) {
    rejectInput("patch {} has no direction, and it is not open", name);
  }
  if (!patch.placement) {
    if (patch.dropped.empty()) rejectInput("patch {} has no place and no reason for it", name);
    return;
  }
  const geometry::TriangleMesh& skin_S = models.hand->skin->mesh();
  const std::string place = "place of patch " + name;
  validate(skin_S, patch.placement->root_S, place.c_str());
  requireTangent(patch.placement->direction_S, normalOf(skin_S, patch.placement->root_S),
                 "direction on the hand of patch " + name);
}

}  // namespace

Edited applied(const Edit& edit,
               DerivedState& derived,
               ModelCache& cache,
               const Progress& progress) {
  Editing editing(derived, cache, progress);
  std::visit(
      [&](const auto& one) {
        editing.apply(one);
      },
      edit);
  // A minimum that is chosen answers what the solution answered; what holds at a time of a
  // motion leaves the grasp as it is.
  if (!std::holds_alternative<ChoiceEdit>(edit) && !std::holds_alternative<TimedEdit>(edit) &&
      !std::holds_alternative<RemoveTimedEdit>(edit))
    editing.edited.document.is_solved = false;
  return std::move(editing.edited);
}

void validate(const Document& document, const Models& models) {
  requireRigid(document.X_WO, "the object's pose");
  validateWeights(document.weights);
  validateShares(document.prior_shares);
  validate(document.solving);
  validate(document.transfer);
  const std::size_t joints = document.joints.size();
  const hand::HandModel& model = *models.hand->model;
  if (joints != static_cast<std::size_t>(model.dofCount()))
    rejectInput("{} joints; hand {} has {}", joints, quoted(document.hand), model.dofCount());
  for (const PinnedPoint& place : document.held)
    validate(place, model);
  const std::vector<std::string> held = heldLinks(document);
  if (std::set(held.begin(), held.end()).size() != held.size())
    rejectInput("a link is held twice; held are {}", fmt::join(held, ", "));
  validatePose(document.start, joints, "the start");
  validatePose(document.prior, joints, "the prior");
  for (std::size_t i = 0; i < joints; ++i) {
    const DocumentJoint& joint = document.joints[i];
    const std::string name = "joint " + quoted(model.dofJoint(static_cast<int>(i)).name);
    if (std::isnan(joint.lower) || std::isnan(joint.upper) || joint.lower > joint.upper)
      rejectInput("{}: limits {} to {} hold nothing", name, joint.lower, joint.upper);
    requireWithin(joint.soft_weight, 0.0, kLargestLambda, "soft weight of " + name);
    requireWithin(joint.soft_value, -kLargestJointValue, kLargestJointValue,
                  "soft value of " + name);
  }
  if (document.timed.size() > kMostTimed)
    rejectInput("{} edits at times; permitted are {}", document.timed.size(), kMostTimed);
  for (const TimedEdit& edit : document.timed)
    session::validate(edit, document, models);
  if (document.patches.empty()) rejectInput("there is no patch");
  std::vector<std::string> names;
  for (const DocumentPatch& patch : document.patches) {
    if (std::find(names.begin(), names.end(), patch.name) != names.end())
      rejectInput("patch {} comes twice", quoted(patch.name));
    names.push_back(patch.name);
    (void)patchOf(models, patch);
    validate(patch, models);
  }
}

}  // namespace handgraft::session
