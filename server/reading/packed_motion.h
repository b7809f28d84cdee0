#pragma once

#include "core/manipulation/motion.h"
#include "server/reading/byte_stream.h"

/// Motions as bytes and back, as packed_parts.h has hands and meshes.
namespace handgraft::server {

void put(ByteWriter& out, const manipulation::Motion& motion);

/// On `mesh_O`.
manipulation::Motion takeMotion(ByteReader& in, const geometry::TriangleMesh& mesh_O);

}  // namespace handgraft::server
