#pragma once

#include <optional>

#include "core/hand/skin_report.h"
#include "core/session/session.h"
#include "idl/models.h"
#include "server/store/model_store.h"

/// What clients are told of the models there are.
namespace handgraft::server {

/// Most bytes of meshes in a description: what reaches a client in seconds.
inline constexpr std::size_t kMostMeshBytes = 256u << 20;

/// A hand's skin and how it was made.
struct SkinnedHand {
  hand::Hand hand;
  hand::SkinReport report;
};

/// With `skinned` also meshes, poses at the skin's reference, and the report. Sites that were
/// found are told where the hand is ready. Notes are those of the file, then of the skin.
/// Errors: Rejection (ERROR_OVERLOADED) if the meshes are too large to be sent.
v1::HandDescription describe(const StoredHand& hand, const std::optional<SkinnedHand>& skinned);
v1::ObjectDescription describe(const StoredObject& object, bool with_meshes);
v1::ContactsDescription describe(const StoredContacts& contacts, bool with_meshes);
/// Errors: as above, of the file.
v1::MotionDescription describe(const StoredMotion& stored, bool with_file);

/// The URDF that describes the hand: its own, or for a mirrored hand one of its links and
/// joints alone.
std::string urdfOf(const StoredHand& hand);

}  // namespace handgraft::server
