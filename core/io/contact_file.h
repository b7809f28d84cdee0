#pragma once

#include <filesystem>
#include <string>

#include "core/contact/contact_set.h"
#include "core/contact/segmentation.h"
#include "core/io/contact_map_file.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

inline constexpr const char* kContactsFormat = "handgraft-contacts/1";
inline constexpr const char* kContactsFormatWithPlaces = "handgraft-contacts/2";

/// Reads a contact set, format `handgraft-contacts/1` (README of this folder). Indices in it
/// are the object file's own; `object` maps them to the mesh.
/// Errors: InvalidInput naming the file, the patch and the field; more than kMostPatches or
/// kMostPoints (contact_set.h) in all.
contact::ContactSet readContactSet(const std::filesystem::path& path, const MeshFile& object);

/// The text of such a file. What `readContactSet` makes of it is the same set. Errors:
/// InvalidInput for a set on a point cloud's surface, whose places have no index, and for one
/// that does not fit the mesh.
std::string contactSetText(const contact::ContactSet& set, const MeshFile& object);

/// Writes it to a file. Errors: as above, naming the file; InvalidInput if it cannot be
/// written.
void writeContactSet(const std::filesystem::path& path,
                     const contact::ContactSet& set,
                     const MeshFile& object);

/// The object that a contact set, a motion or a demonstration (`.npz`, too) names; empty for a
/// contact map, or where the file does not say. Errors: InvalidInput naming the file if it is
/// none of these.
std::string objectNameIn(const std::filesystem::path& path);

/// Either of the two, by what the file is: a map (a PLY, or a mesh with a picture) is
/// segmented, and its patches are carried onto the object's mesh if it lies on another one.
contact::ContactSet readContacts(const std::filesystem::path& path,
                                 const MeshFile& object,
                                 const contact::SegmentationOptions& options = {},
                                 const ContactMapSource& source = {});

/// Patches of a map on the object's mesh, as `readContacts` makes them; the set has no name
/// yet.
contact::ContactSet contactsFromMap(const contact::ContactMap& map,
                                    const MeshFile& object,
                                    const contact::SegmentationOptions& options = {});

}  // namespace handgraft::io
