#pragma once

#include <string>
#include <string_view>

#include "server/reading/read_model.h"

/// What goes between the server and the process that reads for it, as bytes.
namespace handgraft::server {

std::string pack(const ReadRequest& request);

/// Errors: InvalidInput if the bytes are no request.
ReadRequest unpackRequest(std::string_view bytes);

/// In the newest form.
std::string pack(const ReadModel& model);

/// Forms of packed models, which stores and session files keep. Up to 1 they do not say which
/// faces of an object are turned, nor which hand touched; up to 2 not how a motion's
/// demonstrator went.
inline constexpr int kPackedForm = 3;

/// What was read, for sure: whatever the bytes are, what comes back keeps the promises of its
/// types (finite, indices in range, names that exist, sizes within bounds), and no more memory
/// is taken than in proportion to the bytes. Contacts are checked against the object they lie
/// on.
///
/// `form`: 1 to kPackedForm. Errors: InvalidInput. Cost: O(bytes), and building the meshes.
ReadModel unpackModel(std::string_view bytes,
                      const io::MeshFile* object = nullptr,
                      int form = kPackedForm);

}  // namespace handgraft::server
