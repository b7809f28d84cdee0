#pragma once

#include <array>
#include <concepts>
#include <string_view>
#include <type_traits>

#include "core/session/document.h"
#include "core/session/edit.h"
#include "core/session/log.h"

// The fields of everything that is compared, hashed and saved, listed once: whatever goes
// through them (bytes, files) cannot forget one.
namespace handgraft::session {

template <class T, class Of>
concept Maybe = std::same_as<std::remove_const_t<T>, Of>;

// === Values

void visitFields(Maybe<geometry::SurfacePoint> auto& point, auto&& visit) {
  visit("face", point.face);
  visit("barycentric", point.barycentric);
}

void visitFields(Maybe<transfer::PatchPlacement> auto& placement, auto&& visit) {
  visit("root_S", placement.root_S);
  visit("direction_S", placement.direction_S);
}

void visitFields(Maybe<hand::HandPose> auto& pose, auto&& visit) {
  visit("X_WH", pose.X_WH);
  visit("q", pose.q);
}

void visitFields(Maybe<optimize::Weights> auto& weights, auto&& visit) {
  visit("distance", weights.distance);
  visit("normal", weights.normal);
  visit("prior", weights.prior);
}

void visitFields(Maybe<optimize::PriorShares> auto& shares, auto&& visit) {
  visit("root_rotation", shares.root_rotation);
  visit("root_translation", shares.root_translation);
  visit("joints", shares.joints);
  visit("posture", shares.posture);
}

void visitFields(Maybe<SolverSettings> auto& solving, auto&& visit) {
  visit("solver", solving.solver);
  visit("starts", solving.starts);
  visit("seed", solving.seed);
  visit("max_evaluations", solving.max_evaluations);
  visit("paper", solving.paper);
  visit("normal_form", solving.normal_form);
  visit("avoid_penetration", solving.avoid_penetration);
}

void visitFields(Maybe<transfer::TransferOptions> auto& options, auto&& visit) {
  visit("method", options.method);
  visit("interior_rings", options.interior_rings);
}

// === The document

void visitFields(Maybe<DocumentPatch> auto& patch, auto&& visit) {
  visit("name", patch.name);
  visit("enabled", patch.enabled);
  visit("weight", patch.weight);
  visit("root_O", patch.root_O);
  visit("direction_O", patch.direction_O);
  visit("direction_is_open", patch.direction_is_open);
  visit("site", patch.site);
  visit("placement", patch.placement);
  visit("dropped", patch.dropped);
  visit("root_is_open", patch.root_is_open);
}

void visitFields(Maybe<DocumentJoint> auto& joint, auto&& visit) {
  visit("lower", joint.lower);
  visit("upper", joint.upper);
  visit("locked", joint.locked);
  visit("soft_weight", joint.soft_weight);
  visit("soft_value", joint.soft_value);
}

void visitFields(Maybe<PinnedPoint> auto& place, auto&& visit) {
  visit("link", place.link);
  visit("p_L", place.p_L);
  visit("target_W", place.target_W);
  visit("target_R_WL", place.target_R_WL);
  visit("weight", place.weight);
}

void visitFields(Maybe<Document> auto& document, auto&& visit) {
  visit("hand", document.hand);
  visit("object", document.object);
  visit("contacts", document.contacts);
  visit("X_WO", document.X_WO);
  visit("patches", document.patches);
  visit("joints", document.joints);
  visit("held", document.held);
  visit("start", document.start);
  visit("prior", document.prior);
  visit("start_is_known", document.start_is_known);
  visit("is_solved", document.is_solved);
  visit("weights", document.weights);
  visit("prior_shares", document.prior_shares);
  visit("solving", document.solving);
  visit("transfer", document.transfer);
  visit("timed", document.timed);
  visit("notes", document.notes);
}

void visitFields(Maybe<DocumentChange> auto& change, auto&& visit) {
  visit("hand", change.hand);
  visit("object", change.object);
  visit("contacts", change.contacts);
  visit("X_WO", change.X_WO);
  visit("patch_count", change.patch_count);
  visit("patches", change.patches);
  visit("joint_count", change.joint_count);
  visit("joints", change.joints);
  visit("held", change.held);
  visit("start", change.start);
  visit("prior", change.prior);
  visit("prior_is_start", change.prior_is_start);
  visit("start_is_known", change.start_is_known);
  visit("is_solved", change.is_solved);
  visit("weights", change.weights);
  visit("prior_shares", change.prior_shares);
  visit("solving", change.solving);
  visit("transfer", change.transfer);
  visit("timed", change.timed);
  visit("notes", change.notes);
}

// === What the log holds

void visitFields(Maybe<CommittedSolve> auto& solve, auto&& visit) {
  visit("solving", solve.solving);
  visit("objective", solve.objective);
  visit("change", solve.change);
  visit("is_step", solve.is_step);
}

void visitFields(Maybe<FollowedMotion> auto& motion, auto&& visit) {
  visit("causal", motion.causal);
  visit("smoothness", motion.smoothness);
  visit("fade_s", motion.fade_s);
  visit("acceleration_limit", motion.acceleration_limit);
  visit("starts", motion.starts);
  visit("seed", motion.seed);
}

// === Edits: each lists its own (edit.h)

template <class T>
concept IsEdit = requires {
  T::kKind;
};

template <class T>
requires IsEdit<std::remove_const_t<T>>

void visitFields(T& edit, auto&& visit) {
  std::remove_const_t<T>::fields(edit, visit);
}

template <class... Edits>
constexpr std::array<std::string_view, sizeof...(Edits)> kindsOf(
    std::type_identity<std::variant<Edits...>> /*edits*/) {
  return {Edits::kKind...};
}

/// The kinds of edits by their place in `Edit`, as files spell them.
inline constexpr auto kEditKinds = kindsOf(std::type_identity<Edit>());

/// Likewise of what is edited at a time.
inline constexpr auto kTimedKinds = kindsOf(std::type_identity<TimedChange>());

}  // namespace handgraft::session
