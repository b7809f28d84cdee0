#include "server/handlers/variant.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/hand/variant.h"
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
      variant->model, fmt::format("Links and joints of a variant of hand '{}', written by "
                                  "handgraft; no meshes",
                                  parent.name));
  stored.notes = parent.notes;
  stored.notes.push_back(
      fmt::format("a variant of hand {}{}{}; its skin is that hand's{}",
                  handgraft::quoted(parent.name), text.empty() ? "" : ": ", text,
                  variant->shape_changed ? ", bent along, and no new one was wrapped" : ""));
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
