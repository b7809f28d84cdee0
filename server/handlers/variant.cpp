#include "server/handlers/variant.h"

#include <cstring>
#include <utility>
#include <vector>

#include "core/hand/variant.h"
#include "core/io/urdf_writer.h"
#include "server/messages/study_messages.h"

namespace handgraft::server {

namespace {

/// Two requests of the same content have the same; FNV-1a.
std::uint64_t fingerprintOf(const v1::VariantRequest& request, const StoredHand& hand) {
  std::uint64_t print = 14695981039346656037ull;
  const auto take = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i)
      print = (print ^ bytes[i]) * 1099511628211ull;
  };
  take("variant", 7);
  take(hand.name.c_str(), hand.name.size() + 1);
  take(&hand.origin.fingerprint, sizeof(hand.origin.fingerprint));
  for (const v1::HandChange& change : request.changes()) {
    const auto property = static_cast<unsigned>(change.property());
    const double value = change.value();
    take(&property, sizeof(property));
    take(change.target().c_str(), change.target().size() + 1);
    take(&value, sizeof(value));
  }
  return print;
}

std::string textOf(const hand::HandChange& change) {
  return fmt::format("{}.{} = {:.6g}", change.target.empty() ? "hand" : change.target,
                     hand::nameOf(change.property), change.value);
}

}  // namespace

v1::ModelList makeVariant(const v1::VariantRequest& request, Workshop& workshop) {
  validateName(request.name());
  const auto parent = workshop.models.hand(request.hand());
  std::vector<hand::HandChange> changes;
  std::string text;
  for (const v1::HandChange& change : request.changes()) {
    changes.push_back(changeFrom(change));
    text += (text.empty() ? "" : ", ") + textOf(changes.back());
  }
  auto variant = std::make_shared<const hand::HandVariant>(
      hand::makeVariant(parent->hand->model(), request.name(), changes));

  StoredHand stored;
  stored.name = request.name();
  stored.origin.fingerprint = fingerprintOf(request, *parent);
  stored.urdf = io::kinematicUrdfText(
      variant->model, fmt::format("Links and joints of a variant of hand '{}', written by "
                                  "handgraft; no meshes",
                                  parent->name));
  stored.notes = parent->notes;
  stored.notes.push_back(
      fmt::format("a variant of hand {}{}{}; its skin is that hand's{}",
                  handgraft::quoted(parent->name), text.empty() ? "" : ": ", text,
                  variant->shape_changed ? ", bent along, and no new one was wrapped" : ""));
  stored.mirrored = parent->mirrored;
  for (const hand::NamedPose& pose : parent->poses)
    stored.poses.push_back({pose.name, hand::poseOfVariant(*variant, pose.q)});
  stored.floating_base = parent->floating_base;
  stored.hand = variantOf(parent->hand, std::move(variant));

  v1::ModelList reply;
  reply.models().push_back(summaryOf(stored));
  workshop.models.add(std::move(stored));
  return reply;
}

}  // namespace handgraft::server
