#pragma once

#include <vector>

#include "core/contact/contact_map.h"
#include "core/contact/contact_set.h"
#include "server/reading/byte_stream.h"

/// Contacts as bytes and back, as packed_parts.h has hands and meshes.
namespace handgraft::server {

void put(ByteWriter& out, hand::Chirality side);
void put(ByteWriter& out, const contact::Patch& patch);
void put(ByteWriter& out, const std::vector<contact::PartDirection>& posture);
void put(ByteWriter& out, const contact::ContactSet& set);
void put(ByteWriter& out, const contact::ContactMap& map);

hand::Chirality takeSide(ByteReader& in);
/// All else is checked by contact::validate.
contact::Patch takePatch(ByteReader& in);
std::vector<contact::PartDirection> takePosture(ByteReader& in);
/// On `mesh_O`.
contact::ContactSet takeContactSet(ByteReader& in, const geometry::TriangleMesh& mesh_O);
contact::ContactMap takeContactMap(ByteReader& in);

}  // namespace handgraft::server
