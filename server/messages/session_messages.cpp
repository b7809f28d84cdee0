#include "server/messages/session_messages.h"

#include "core/session/pinned_points.h"
#include "server/messages/convert.h"
#include "server/messages/transfer_messages.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostSteps = 20;  // shown of what can be undone

v1::PriorShares sharesMessage(const optimize::PriorShares& shares) {
  v1::PriorShares message;
  message.root_rotation(shares.root_rotation);
  message.root_translation(shares.root_translation);
  message.joints(shares.joints);
  message.posture(shares.posture);
  return message;
}

v1::PatchState patchState(const session::DocumentPatch& patch) {
  v1::PatchState message;
  message.name(patch.name);
  message.enabled(patch.enabled);
  message.weight(patch.weight);
  message.site(patch.site);
  message.placed(patch.placement.has_value());
  message.reason(patch.dropped);
  message.root_is_open(patch.root_is_open);
  message.direction_is_open(patch.direction_is_open);
  message.root_O(toMessage(patch.root_O));
  if (patch.direction_O) message.direction_O(toMessage(*patch.direction_O));
  if (patch.placement) {
    message.root_S(toMessage(patch.placement->root_S));
    message.direction_S(toMessage(patch.placement->direction_S));
  }
  return message;
}

v1::JointSetting jointSetting(const hand::HandModel& model,
                              const session::Document& document,
                              int dof) {
  const session::DocumentJoint& joint = document.joints[static_cast<std::size_t>(dof)];
  v1::JointSetting message;
  message.name(model.dofJoint(dof).name);
  message.kind(kindOf(model.dofJoint(dof)));
  message.value(document.start.q[dof]);
  message.prior(document.prior.q[dof]);
  message.lower(joint.lower);
  message.upper(joint.upper);
  message.model_lower(model.lower()[dof]);
  message.model_upper(model.upper()[dof]);
  message.locked(joint.locked);
  message.soft(joint.soft_weight > 0.0);
  message.soft_weight(joint.soft_weight);
  if (message.soft()) message.prior(joint.soft_value);
  return message;
}

}  // namespace

v1::Weights weightsMessage(const optimize::Weights& weights) {
  v1::Weights message;
  message.distance(weights.distance);
  message.normal(weights.normal);
  message.prior(weights.prior);
  return message;
}

v1::PinnedPoint heldMessage(const session::PinnedPoint& place,
                            const hand::HandModel& model,
                            const hand::HandPose& pose) {
  v1::PinnedPoint message;
  message.link(place.link);
  message.p_L_m(toMessage(place.p_L));
  message.target_W_m(toMessage(place.target_W));
  message.weight(place.weight);
  message.miss_m(session::fitOf(place, model, pose).off_m);
  return message;
}

v1::SessionSettings settingsMessage(const session::Session& session) {
  const session::Document& document = session.document();
  const hand::HandModel& model = *session.hand().model;
  v1::SessionSettings message;
  message.X_WO(toMessage(document.X_WO));
  message.X_WH(toMessage(document.start.X_WH));
  message.prior_X_WH(toMessage(document.prior.X_WH));
  message.weights(weightsMessage(document.weights));
  message.prior_shares(sharesMessage(document.prior_shares));
  message.solving(toMessage(document.solving));
  message.transfer(toMessage(document.transfer));
  for (const session::DocumentPatch& patch : document.patches)
    message.patches().push_back(patchState(patch));
  for (int dof = 0; dof < model.dofCount(); ++dof)
    message.joints().push_back(jointSetting(model, document, dof));
  for (const session::PinnedPoint& place : document.held)
    message.held().push_back(heldMessage(place, model, document.start));
  message.snapshots(session.history().snapshotNames());
  message.undo(session.history().undoLabels(kMostSteps));
  message.redo(session.history().redoLabels(kMostSteps));
  message.notes(document.notes);
  for (const session::TimedEdit& edit : document.timed) {
    v1::TimedState timed;
    timed.time_s(edit.when.time_s);
    timed.falloff_s(edit.when.falloff_s);
    timed.text(describe(edit.change, model));
    message.timed().push_back(std::move(timed));
  }
  return message;
}

v1::CompareReply toMessage(const std::vector<session::Difference>& differences) {
  v1::CompareReply reply;
  for (const session::Difference& difference : differences) {
    v1::Difference message;
    message.what(difference.what);
    message.a(difference.a);
    message.b(difference.b);
    message.change(difference.change);
    reply.differences().push_back(std::move(message));
  }
  return reply;
}

}  // namespace handgraft::server
