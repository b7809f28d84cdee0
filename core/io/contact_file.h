#pragma once

#include <filesystem>
#include <string>

#include "core/contact/contact_map.h"
#include "core/contact/contact_set.h"
#include "core/contact/segmentation.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

/// Reads a contact map: a PLY with vertex properties `contact` and, optionally, `link`. Names
/// of the links come from a header comment that lists `0=name 1=name ...`. Errors: InvalidInput
/// naming the file and what it lacks.
contact::ContactMap readContactMap(const std::filesystem::path& path);

/// Reads a contact set, format `handgraft-contacts/1` (README of this folder). Indices in it
/// are the object file's own; `object` maps them to the mesh.
contact::ContactSet readContactSet(const std::filesystem::path& path, const MeshFile& object);

void writeContactSet(const std::filesystem::path& path,
                     const contact::ContactSet& set,
                     const MeshFile& object);

/// The object that a contact set names; empty for a contact map, or where the file does not
/// say. Errors: InvalidInput naming the file if it is no JSON.
std::string objectNameIn(const std::filesystem::path& path);

/// Either of the two, by what the file is: a map is carried onto the object's mesh if it lies
/// on another one, and segmented.
contact::ContactSet readContacts(const std::filesystem::path& path,
                                 const MeshFile& object,
                                 const contact::SegmentationOptions& options = {});

}  // namespace handgraft::io
