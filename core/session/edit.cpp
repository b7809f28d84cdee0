#include "core/session/edit.h"

#include <algorithm>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/hand/hand_model.h"

namespace handgraft::session {
namespace {

constexpr double kDegree = 0.017453292519943295;  // rad

const char* nameOf(Side side) {
  return side == Side::kHand ? "hand" : "object";
}

/// A name of somebody's, cut so that a history stays small.
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 48;
  return onOneLine(name, kMost);
}

/// Of kinds without a text of their own below: "snapshot before".
template <class OneEdit>
std::string text(const OneEdit& edit) {
  std::string out(OneEdit::kKind);
  std::replace(out.begin(), out.end(), '_', ' ');
  OneEdit::fields(edit, [&](const char* /*name*/, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>) out += " " + shortened(value);
    if constexpr (std::is_arithmetic_v<Value>) out += fmt::format(" {:.6g}", double(value));
  });
  return out;
}

std::string text(const ObjectPoseEdit& /*edit*/) {
  return "place object";
}

std::string text(const PatchWeightEdit& edit) {
  return fmt::format("weight {} {:.6g}", shortened(edit.patch), edit.weight);
}

std::string text(const PatchEnabledEdit& edit) {
  return fmt::format("{} {}", edit.enabled ? "enable" : "disable", shortened(edit.patch));
}

std::string text(const PatchRootEdit& edit) {
  return fmt::format("root {} {}", shortened(edit.patch), nameOf(edit.side));
}

std::string text(const PatchDirectionEdit& edit) {
  return fmt::format("dir {} {} {:+.4g}deg", shortened(edit.patch), nameOf(edit.side),
                     edit.angle_rad / kDegree);
}

std::string text(const JointLimitEdit& edit, const std::string& unit = "") {
  return fmt::format("limit {} {:.6g} to {:.6g}{}", shortened(edit.joint), edit.lower,
                     edit.upper, unit);
}

std::string text(const JointLockEdit& edit) {
  return fmt::format("{} {}", edit.locked ? "lock" : "unlock", shortened(edit.joint));
}

std::string text(const JointSoftEdit& edit, const std::string& unit = "") {
  return edit.weight > 0.0 ? fmt::format("soft {} {:.6g}{} weight {:.6g}",
                                         shortened(edit.joint), edit.value, unit, edit.weight)
                           : fmt::format("soft {} off", shortened(edit.joint));
}

std::string text(const PriorEdit& edit, const std::string& unit = "") {
  if (edit.joints.size() == 1 && edit.q.size() == 1 && !edit.X_WH) {
    return fmt::format("joint {} {:.6g}{}", shortened(edit.joints.front()), edit.q.front(),
                       unit);
  }
  return edit.X_WH ? fmt::format("pose of the hand and {} joints", edit.joints.size())
                   : fmt::format("pose of {} joints", edit.joints.size());
}

std::string text(const PriorSharesEdit& edit) {
  return fmt::format("prior shares {:.6g} {:.6g} {:.6g}, posture {:.6g}",
                     edit.shares.root_rotation, edit.shares.root_translation,
                     edit.shares.joints, edit.shares.posture);
}

std::string text(const WeightsEdit& edit) {
  return fmt::format("weights {:.6g} {:.6g} {:.6g}", edit.weights.distance, edit.weights.normal,
                     edit.weights.prior);
}

std::string text(const SolverSettingsEdit& edit) {
  return edit.solving.paper
             ? std::string("solving as in the paper")
             : fmt::format("solving by {} from {} starts",
                           optimize::nameOf(edit.solving.solver), edit.solving.starts);
}

std::string text(const DragEdit& edit) {
  return fmt::format("drag {} to {:.4g} {:.4g} {:.4g}", shortened(edit.link), edit.target_W.x(),
                     edit.target_W.y(), edit.target_W.z());
}

std::string text(const ReleaseEdit& edit) {
  return edit.link.empty() ? std::string("release all")
                           : fmt::format("release {}", shortened(edit.link));
}

std::string text(const ChoiceEdit& edit) {
  return fmt::format("choose minimum {}", edit.rank);
}

std::string text(const UndoEdit& edit) {
  return edit.count == 1 ? std::string("undo") : fmt::format("undo {}", edit.count);
}

std::string text(const RedoEdit& edit) {
  return edit.count == 1 ? std::string("redo") : fmt::format("redo {}", edit.count);
}

std::string text(const DragPath& way) {
  return fmt::format("drag {}", shortened(way.link));
}

/// A change at a time; `change` says what it is.
std::string text(const EditTime& when, const std::string& change) {
  const std::string text = fmt::format("{} at {:.6g} s", change, when.time_s);
  return when.falloff_s > 0.0 ? fmt::format("{} +- {:.7g} s", text, when.falloff_s) : text;
}

std::string text(const TimedEdit& edit) {
  return text(edit.when, describe(edit.change));
}

std::string text(const RemoveTimedEdit& edit) {
  return fmt::format("take back {}", edit.index + 1);
}

/// Of a joint's values, with a space before; empty for joints that the hand does not have.
std::string unitBehind(const hand::HandModel& model, const std::string& joint) {
  for (int dof = 0; dof < model.dofCount(); ++dof)
    if (model.dofJoint(dof).name == joint)
      return model.dofJoint(dof).type == hand::JointType::kPrismatic ? " m" : " rad";
  return "";
}

// Joints' values with their units, which only the hand tells.
template <class OneEdit>
std::string textIn(const OneEdit& edit, const hand::HandModel& /*model*/) {
  return text(edit);
}

std::string textIn(const JointLimitEdit& edit, const hand::HandModel& model) {
  return text(edit, unitBehind(model, edit.joint));
}

std::string textIn(const JointSoftEdit& edit, const hand::HandModel& model) {
  return text(edit, unitBehind(model, edit.joint));
}

std::string textIn(const PriorEdit& edit, const hand::HandModel& model) {
  return edit.joints.size() == 1 ? text(edit, unitBehind(model, edit.joints.front()))
                                 : text(edit);
}

std::string textIn(const TimedEdit& edit, const hand::HandModel& model) {
  return text(edit.when, describe(edit.change, model));
}

}  // namespace

std::string describe(const Edit& edit, const hand::HandModel& model) {
  return std::visit(
      [&model](const auto& one) {
        return textIn(one, model);
      },
      edit);
}

std::string describe(const TimedChange& change, const hand::HandModel& model) {
  return std::visit(
      [&model](const auto& one) {
        return textIn(one, model);
      },
      change);
}

std::string describe(const Edit& edit) {
  return std::visit(
      [](const auto& one) {
        return text(one);
      },
      edit);
}

std::string describe(const TimedChange& change) {
  return std::visit(
      [](const auto& one) {
        return text(one);
      },
      change);
}

}  // namespace handgraft::session
