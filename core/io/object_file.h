#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/cloud/point_cloud_surface.h"
#include "core/contact/contact_map.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

/// An object: a mesh as `readMesh` reads it, or a PLY that lists points and no face, with or
/// without normals `nx ny nz`, through which a surface is laid. Then `cloud_O` holds the file's
/// points, the ways between indices are empty, and the notes say how true the surface is.
///
/// Errors: as `readMesh` and `cloud::surfaceOf`, naming the file; Cancelled.
MeshFile readObject(const std::filesystem::path& path,
                    const Progress& progress = {},
                    const cloud::SurfaceOptions& options = {});

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

}  // namespace handgraft::io
