#include "client/editor/edit_builders.h"

#include <cmath>

#include "client/editor/match_values.h"
#include "client/link/hand_point.h"
#include "client/link/surface_pick.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"

namespace handgraft::client::editor {

namespace {

// Whoever points at a surface is not farther from it: numbers in another unit or frame are.
constexpr double kFarthestRoot = 0.05;  // m

v1::PatchSide sideOf(const std::string& side) {
  return side == "object" ? v1::SIDE_OBJECT : v1::SIDE_HAND;
}

// === Patches

v1::EditBody rootEdit(const std::string& patch,
                      v1::PatchSide side,
                      const v1::SurfacePoint& at) {
  v1::PatchRootEdit edit;
  edit.patch(patch);
  edit.side(side);
  edit.root(at);
  return bodyOf(&v1::EditBody::patch_root, edit);
}

v1::EditBody turnEdit(const std::string& patch, v1::PatchSide side, double angle_rad) {
  v1::PatchDirectionEdit edit;
  edit.patch(patch);
  edit.side(side);
  edit.angle_rad(angle_rad);
  return bodyOf(&v1::EditBody::patch_direction, edit);
}

v1::EditBody enabledEdit(const std::string& patch, bool enabled) {
  v1::PatchEnabledEdit edit;
  edit.patch(patch);
  edit.enabled(enabled);
  return bodyOf(&v1::EditBody::patch_enabled, edit);
}

// === Joints

const v1::JointInfo& jointNamed(EditContext& context, const std::string& name) {
  for (const v1::JointInfo& joint : context.hand().joints()) {
    if (joint.name() == name) return joint;
  }
  rejectInput("the hand has no joint {}", handgraft::quoted(name));
}

// In the joint's own unit.
double jointNumber(const Match& match, std::size_t index, EditContext& context) {
  const std::string& joint = word(match, 0);
  const Value& value = match.values.at(index);
  const bool slides = jointNamed(context, joint).kind() == v1::JOINT_PRISMATIC;
  if (value.unit == (slides ? Unit::kAngle : Unit::kLength)) {
    rejectInput("joint {} {}: {} is no {}", handgraft::quoted(joint),
                slides ? "slides" : "turns", value.text, slides ? "length" : "angle");
  }
  return value.number;
}

v1::JointSetting settingOf(EditContext& context, const std::string& joint) {
  for (const v1::JointSetting& setting : context.settings().joints()) {
    if (setting.name() == joint) return setting;
  }
  rejectInput("the session has no joint {}", handgraft::quoted(joint));
}

v1::EditBody limitEdit(const std::string& joint, double lower, double upper) {
  v1::JointLimitEdit edit;
  edit.joint(joint);
  edit.lower(lower);
  edit.upper(upper);
  return bodyOf(&v1::EditBody::joint_limit, edit);
}

v1::EditBody lockEdit(const std::string& joint, bool locked) {
  v1::JointLockEdit edit;
  edit.joint(joint);
  edit.locked(locked);
  return bodyOf(&v1::EditBody::joint_lock, edit);
}

v1::EditBody softEdit(const std::string& joint, double value, double weight) {
  v1::JointSoftEdit edit;
  edit.joint(joint);
  edit.value(value);
  edit.weight(weight);
  return bodyOf(&v1::EditBody::joint_soft, edit);
}

// === Patches

v1::EditBody rootOnSite(const Match& match, EditContext& context) {
  const v1::HandDescription& hand = context.handWithMeshes();
  const v1::SiteInfo* site = siteNamed(hand, word(match, 1));
  if (site == nullptr)
    rejectInput("the hand has no site {}", handgraft::quoted(word(match, 1)));
  const std::size_t link = linkIndex(hand, site->link());
  if (link >= hand.X_SL().size())
    rejectInput("the hand's skin does not say where its links are");
  const Eigen::Vector3d p_S = poseOf(hand.X_SL()[link]) * vectorOf(site->p_L_m());
  return rootEdit(word(match, 0), v1::SIDE_HAND, nearestPoint(hand.skin_S(), p_S));
}

v1::EditBody rootOnFace(const Match& match, EditContext& /*context*/) {
  constexpr double kTolerance = 1e-3;  // as typed
  const Value& face = match.values.at(2);
  if (face.count > 0x7fffffffU) rejectInput("face {}: there is none of that number", face.text);
  v1::SurfacePoint root;
  root.face(static_cast<std::int32_t>(face.count));
  const Eigen::Vector3d b = vectorAt(match, 3);
  if (b.minCoeff() < 0.0 || std::abs(b.sum() - 1.0) > kTolerance) {
    rejectInput("weights {} {} {}: they must not be negative and sum to 1", word(match, 3),
                word(match, 4), word(match, 5));
  }
  const Eigen::Vector3d exact = b / b.sum();
  root.barycentric() = {exact[0], exact[1], exact[2]};
  return rootEdit(word(match, 0), sideOf(word(match, 1)), root);
}

v1::EditBody rootNearPoint(const Match& match, EditContext& context) {
  const v1::PatchSide side = sideOf(word(match, 1));
  const v1::Mesh& mesh =
      side == v1::SIDE_OBJECT ? context.object().mesh_O() : context.handWithMeshes().skin_S();
  const Eigen::Vector3d p = vectorAt(match, 2);
  const v1::SurfacePoint root = nearestPoint(mesh, p);
  const double distance = (positionOf(mesh, root) - p).norm();
  if (!(distance <= kFarthestRoot)) {
    rejectInput(
        "root of patch {}: {} {} {} is {:.0f} mm from the {}; it may be at most {:.0f} mm",
        handgraft::quoted(word(match, 0)), word(match, 2), word(match, 3), word(match, 4),
        1e3 * distance, side == v1::SIDE_OBJECT ? "object's surface" : "hand's skin",
        1e3 * kFarthestRoot);
  }
  return rootEdit(word(match, 0), side, root);
}

v1::EditBody turn(const Match& match, EditContext& /*context*/) {
  return turnEdit(word(match, 0), v1::SIDE_HAND, number(match, 1));
}

v1::EditBody turnOnSide(const Match& match, EditContext& /*context*/) {
  return turnEdit(word(match, 0), sideOf(word(match, 1)), number(match, 2));
}

v1::EditBody enable(const Match& match, EditContext& /*context*/) {
  return enabledEdit(word(match, 0), true);
}

v1::EditBody disable(const Match& match, EditContext& /*context*/) {
  return enabledEdit(word(match, 0), false);
}

v1::EditBody patchWeight(const Match& match, EditContext& /*context*/) {
  v1::PatchWeightEdit edit;
  edit.patch(word(match, 0));
  edit.weight(number(match, 1));
  if (!(edit.weight() >= 0.0)) {
    rejectInput("weight of patch {}: {}: it must not be negative",
                handgraft::quoted(edit.patch()), word(match, 1));
  }
  return bodyOf(&v1::EditBody::patch_weight, edit);
}

v1::EditBody weights(const Match& match, EditContext& /*context*/) {
  v1::Weights edit;
  edit.distance(number(match, 0));
  edit.normal(number(match, 1));
  edit.prior(number(match, 2));
  if (edit.distance() == 0.0 && edit.normal() == 0.0 && edit.prior() == 0.0) {
    rejectInput("weights 0 0 0: at least one of them must be positive");
  }
  return bodyOf(&v1::EditBody::weights, edit);
}

// === Joints

v1::EditBody jointValue(const Match& match, EditContext& context) {
  v1::PriorEdit edit;
  edit.joints().push_back(word(match, 0));
  edit.joint_positions().push_back(jointNumber(match, 1, context));
  return bodyOf(&v1::EditBody::prior, edit);
}

v1::EditBody lock(const Match& match, EditContext& /*context*/) {
  return lockEdit(word(match, 0), true);
}

v1::EditBody unlock(const Match& match, EditContext& /*context*/) {
  return lockEdit(word(match, 0), false);
}

v1::EditBody soft(const Match& match, EditContext& context) {
  return softEdit(word(match, 0), jointNumber(match, 1, context), number(match, 2));
}

v1::EditBody softOff(const Match& match, EditContext& /*context*/) {
  return softEdit(word(match, 0), 0.0, 0.0);
}

v1::EditBody limitLower(const Match& match, EditContext& context) {
  const double lower = jointNumber(match, 1, context);
  return limitEdit(word(match, 0), lower, settingOf(context, word(match, 0)).upper());
}

v1::EditBody limitUpper(const Match& match, EditContext& context) {
  const double upper = jointNumber(match, 1, context);
  return limitEdit(word(match, 0), settingOf(context, word(match, 0)).lower(), upper);
}

v1::EditBody limitRange(const Match& match, EditContext& context) {
  return limitEdit(word(match, 0), jointNumber(match, 1, context),
                   jointNumber(match, 2, context));
}

v1::EditBody limitReset(const Match& match, EditContext& context) {
  const v1::JointSetting setting = settingOf(context, word(match, 0));
  return limitEdit(word(match, 0), setting.model_lower(), setting.model_upper());
}

}  // namespace

// === What is typed for them, in the order of help

std::span<const Command> patchCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"root PATCH hand pick SITE", "put a patch's root on a site of the hand", Action::kEdit, rootOnSite},
      {"root PATCH SIDE face COUNT NUMBER NUMBER NUMBER", "on a face of the object's mesh or the hand's skin, by three weights that sum to 1", Action::kEdit, rootOnFace},
      {"root PATCH SIDE at LENGTH LENGTH LENGTH", "on the surface's place nearest to a point, in the frame of the object or of the skin", Action::kEdit, rootNearPoint},
      {"dir PATCH ANGLE", "turn a patch on the hand, counter-clockwise as seen from outside", Action::kEdit, turn},
      {"dir PATCH SIDE ANGLE", "likewise on the side named", Action::kEdit, turnOnSide},
      {"enable PATCH", "have a patch count", Action::kEdit, enable},
      {"disable PATCH", "have it not count", Action::kEdit, disable},
      {"weight PATCH NUMBER", "how much a patch counts; 1 is usual", Action::kEdit, patchWeight},
      {"weights NUMBER NUMBER NUMBER", "of distance (1/m2), normal and prior in the objective", Action::kEdit, weights},
  };
  // clang-format on
  return kRows;
}

std::span<const Command> jointCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"joint JOINT VALUE", "bend a joint: the pose becomes prior and start", Action::kEdit, jointValue},
      {"lock JOINT", "hold a joint where it is", Action::kEdit, lock},
      {"unlock JOINT", "let it move again", Action::kEdit, unlock},
      {"soft JOINT VALUE NUMBER", "hold a joint near a value, so many times as firmly as the prior does", Action::kEdit, soft},
      {"soft JOINT off", "let it go", Action::kEdit, softOff},
      {"limit JOINT lower VALUE", "set a joint's lower limit", Action::kEdit, limitLower},
      {"limit JOINT upper VALUE", "its upper limit", Action::kEdit, limitUpper},
      {"limit JOINT range VALUE VALUE", "both", Action::kEdit, limitRange},
      {"limit JOINT reset", "both as the hand's model has them", Action::kEdit, limitReset},
  };
  // clang-format on
  return kRows;
}

}  // namespace handgraft::client::editor
