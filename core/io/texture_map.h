#pragma once

#include <filesystem>

#include "core/contact/contact_map.h"
#include "core/io/color_map.h"

namespace handgraft::io {

/// A contact map painted onto a textured mesh: the mesh is a glTF, GLB or COLLADA with texture
/// coordinates, the picture a PNG, the colours those of `scale`.
///
/// The map's mesh is the file's, cut to edges of 2.5 mm (more on an object larger than 0.75
/// m2), since contact is as fine as the picture and not as the mesh beneath it. A vertex takes
/// the mean of the picture over its faces, weighted by area and nearness, about one sample a
/// pixel: what lies between the vertices counts, and speckle evens out. Colours
/// become numbers before they are averaged, since a mean colour may lie off the scale. Vertices
/// that the file repeats along seams of the texture are one. Coordinates outside [0, 1] repeat
/// the picture.
///
/// Units and frames: as readMesh. Errors: InvalidInput naming the file if either cannot be
/// read, if a face has no texture coordinates, or if the colours are not the scale's.
/// Cost: O(F + samples), at most 4e6 samples or one a face.
contact::ContactMap readTextureMap(const std::filesystem::path& mesh,
                                   const std::filesystem::path& picture,
                                   const ColorMap& scale);

}  // namespace handgraft::io
