#pragma once

#include <filesystem>
#include <functional>

#include "core/base/progress.h"
#include "core/cloud/point_cloud_surface.h"
#include "core/contact/contact_map.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

/// What a file's lengths are multiplied with, by how large what it holds is
/// (geometry/main_extent.h), which tells millimetres from metres. Empty: 1.
using LengthScale = std::function<double(double extent)>;

/// An object: a mesh as `readMesh` reads it, or a PLY that lists points and no face, with or
/// without normals `nx ny nz`, through which a surface is laid. Then `cloud_O` holds the file's
/// points, the ways between indices are empty, and the notes say how true the surface is.
/// Faces that look inwards (geometry/inward_faces.h) are turned, and a note says how many.
///
/// Units: the file's, times what `scale` says. Errors: as `readMesh` and `cloud::surfaceOf`,
/// naming the file, and those of `scale` as they are; Cancelled.
MeshFile readObject(const std::filesystem::path& path,
                    const Progress& progress = {},
                    const cloud::SurfaceOptions& options = {},
                    const LengthScale& scale = {});

/// A contact map of points without faces, on a surface through or near them: each vertex takes
/// the values of the nearest 4 points within reach, weighted by inverse squared distance,
/// and the label of the nearest of them that has one; 0 and -1 where there is none. Reach is
/// two spacings of the points, at most `most_reach_m`.
///
/// Frames: map and mesh in O. Errors: InvalidInput if no vertex is within reach of a point:
/// another object or frame. Cost: O((V + N) log N).
contact::ContactMap onSurface(const contact::ContactMap& points,
                              const geometry::TriangleMesh& mesh_O,
                              double most_reach_m);

/// The map with faces: itself if it has some, those that look inwards turned as the object's
/// are; else on the object's surface if the object is
/// points, too, or on one laid through the map's points. Errors: as `onSurface` and
/// `cloud::surfaceOf`.
contact::ContactMap onFaces(contact::ContactMap map, const MeshFile& object);

}  // namespace handgraft::io
