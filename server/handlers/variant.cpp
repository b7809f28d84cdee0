#include "server/handlers/variant.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/base/limit_note.h"
#include "core/hand/variant.h"
#include "core/io/urdf_text.h"
#include "core/io/urdf_writer.h"
#include "idl/json.h"
#include "server/handlers/enter_model.h"
#include "server/messages/study_messages.h"

namespace handgraft::server {

namespace {

/// Two requests of the same content have the same.
std::string contentOf(const v1::VariantRequest& request, const StoredHand& hand) {
  ContentHash hash;
  hash.addText("variant");
  hash.addText(hand.name);
  hash.addText(hand.origin.content);
  for (const v1::HandChange& change : request.changes()) {
    hash.addNumber(static_cast<std::uint32_t>(change.property()));
    hash.addText(change.target());
    hash.addNumber(change.value());
  }
  return hash.finish();
}

std::string textOf(const hand::HandChange& change) {
  return fmt::format("{}.{} = {:.6g}", change.target.empty() ? "hand" : change.target,
                     hand::nameOf(change.property), change.value);
}

/// On limits that were changed and are hardly meant.
std::vector<std::string> notesOnLimits(const hand::HandModel& parent,
                                       const std::vector<hand::HandChange>& changes,
                                       const hand::HandModel& variant) {
  std::vector<std::string> notes;
  for (int dof = 0; dof < parent.dofCount(); ++dof) {
    const std::string& joint = parent.dofJoint(dof).name;
    const bool is_set =
        std::any_of(changes.begin(), changes.end(), [&](const hand::HandChange& change) {
          return change.target == joint && !hand::changesShape(change.property);
        });
    if (!is_set) continue;
    const bool slides = parent.dofJoint(dof).type == hand::JointType::kPrismatic;
    const std::string note =
        limitNote(joint, slides, {variant.lower()[dof], variant.upper()[dof]},
                  {parent.lower()[dof], parent.upper()[dof]});
    if (!note.empty()) notes.push_back(note);
  }
  return notes;
}

}  // namespace

StoredHand variantHand(const v1::VariantRequest& request, const StoredHand& parent) {
  validateName(request.name());
  std::vector<hand::HandChange> changes;
  std::string text;
  for (const v1::HandChange& change : request.changes()) {
    changes.push_back(changeFrom(change));
    text += (text.empty() ? "" : ", ") + textOf(changes.back());
  }
  auto variant = std::make_shared<const hand::HandVariant>(
      hand::makeVariant(parent.hand->model(), request.name(), changes));

  StoredHand stored;
  stored.name = request.name();
  stored.origin.content = contentOf(request, parent);
  stored.urdf = io::kinematicUrdfText(
      variant->model,
      fmt::format("Links and joints of a variant of hand '{}', written by "
                  "handgraft; no meshes",
                  parent.name),
      io::effortLimitsOf(parent.urdf));
  stored.notes = parent.notes;
  stored.notes.push_back(
      fmt::format("a variant of hand {}{}{}; its skin is that hand's{}",
                  handgraft::quoted(parent.name), text.empty() ? "" : ": ", text,
                  variant->shape_changed ? ", bent along, and no new one was wrapped" : ""));
  for (const std::string& note : notesOnLimits(parent.hand->model(), changes, variant->model))
    stored.notes.push_back(note);
  stored.mirrored = parent.mirrored;
  for (const hand::NamedPose& pose : parent.poses)
    stored.poses.push_back({pose.name, hand::poseOfVariant(*variant, pose.q)});
  stored.floating_base = parent.floating_base;
  stored.hand = variantOf(parent.hand, std::move(variant));
  return stored;
}

v1::ModelList makeVariant(const v1::VariantRequest& request,
                          HandlerContext& context,
                          const RequestKey& by) {
  const auto parent = context.models.hand(request.hand());
  return enterModel(variantHand(request, *parent), context, by, "make_variant", [&] {
    return ModelRecipe{kVariantForm, idl::jsonText(request), "", parent->origin.row,
                       parent->name};
  });
}

}  // namespace handgraft::server
