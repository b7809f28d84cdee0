#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/geometry/triangle_mesh.h"

/// What skins are made with, by CGAL. Built without it (HANDGRAFT_WITH_CGAL=OFF) nothing is
/// wrapped or remeshed (InvalidInput), and a skin that is given is taken to cross itself
/// nowhere.
namespace handgraft::hand {

/// Wraps triangles, which may be open, crossing and turned, from outside: what a ball of radius
/// `alpha_m` cannot pass stays shut; the wrap stands off by `offset_m`.
///
/// The result is closed, 2-manifold, oriented and without self-intersection; perhaps of several
/// pieces and with handles. Faces without area do not count. Errors: InvalidInput if no face
/// has one. Cancelled on wish, soon; reports "wrapping" with a share that grows. Deterministic.
/// Cost: about 0.1 ms a vertex of the wrap. Source: Portaneri et al. 2022, "Alpha wrapping with
/// an offset".
geometry::TriangleMesh wrapped(const geometry::TriangleMesh& triangles,
                               double alpha_m,
                               double offset_m,
                               const Progress& progress);

/// A closed surface with edges of about `edge_m` and even triangles: isotropic remeshing, its
/// vertices on the surface given. Same topology; may cross itself where the surface is thinner
/// than an edge is long. Cost: about 0.05 ms a vertex.
geometry::TriangleMesh remeshed(const geometry::TriangleMesh& mesh, double edge_m);

/// Faces that pierce or overlap another one, in ascending order. Exact. Cost: O(F log F).
std::vector<int> selfIntersectingFaces(const geometry::TriangleMesh& mesh);

}  // namespace handgraft::hand
