#pragma once

#include <string>
#include <string_view>

#include "server/reading/read_model.h"

/// What goes between the server and the process that reads for it, as bytes.
namespace handgraft::server {

std::string pack(const ReadRequest& request);

/// Errors: InvalidInput if the bytes are no request.
ReadRequest unpackRequest(std::string_view bytes);

std::string pack(const ReadModel& model);

/// What was read, for sure: whatever the bytes are, what comes back keeps the promises of its
/// types (finite, indices in range, names that exist, sizes within bounds), and no more memory
/// is taken than in proportion to the bytes. Contacts are checked against the object they lie
/// on.
///
/// Errors: InvalidInput. Cost: O(bytes), and building the meshes.
ReadModel unpackModel(std::string_view bytes, const io::MeshFile* object = nullptr);

}  // namespace handgraft::server
