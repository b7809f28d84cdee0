#pragma once

#include <cstdint>
#include <string>

#include "idl/models.h"

namespace handgraft::client::gateway {

/// A model's description for a page: JSON for what is words and numbers, its meshes as they lie
/// in memory, so that they need not be parsed.
///
/// Little-endian: the number of the request that it answers (u32), the length of the JSON
/// (u32), the JSON, blanks up to a multiple of four bytes, then the arrays one after the other.
/// The JSON is `{"description": ModelDescription without meshes, "arrays": [{"name", "type",
/// "at", "count"}]}`; `at` counts bytes from behind the blanks, types are f32, u32 and i32.
/// Names: `links/INDEX/vertices`, `links/INDEX/triangles`, `skin/vertices`, `skin/triangles`,
/// `skin/links` of a hand; `mesh/...` of an object; `map/vertices`, `map/triangles`,
/// `map/values` of contacts.
std::string modelFrame(std::uint32_t request, v1::ModelDescription description);

}  // namespace handgraft::client::gateway
