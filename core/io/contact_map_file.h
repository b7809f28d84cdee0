#pragma once

#include <filesystem>
#include <string>

#include "core/contact/contact_map.h"

namespace handgraft::io {

/// Where a file keeps its contact.
struct ContactMapSource {
  /// The vertex property with the values; any name.
  std::string value_property = "contact";
  /// The vertex property with the index of the touching segment. A map without the default one
  /// has no labels; a name that was asked for must be there.
  std::string label_property = "link";
  /// A colour scale (color_map.h) that shows the values: then they are read from the vertices'
  /// red, green and blue instead, or from the picture. Empty: values.
  std::string color_scale{};
  /// A PNG painted onto the mesh by its texture coordinates (texture_map.h); needs a colour
  /// scale. Empty: none.
  std::filesystem::path picture{};
};

/// Whether a file of contacts is a map, not a set: by a picture that goes with it, by its name
/// or by its first bytes.
bool isContactMap(const std::filesystem::path& path, const ContactMapSource& source = {});

/// Reads a contact map: a PLY with its values or colours per vertex, or a mesh with texture
/// coordinates and a picture. Names of the segments come from a header comment that lists
/// `0=name 1=name ...`. Colours are bytes, or fractions of 1.
/// Errors: InvalidInput naming the file and what it lacks, or how far its colours are off the
/// scale.
contact::ContactMap readContactMap(const std::filesystem::path& path,
                                   const ContactMapSource& source = {});

}  // namespace handgraft::io
