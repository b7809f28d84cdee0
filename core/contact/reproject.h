#pragma once

#include <optional>
#include <string>

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// The same patches on another mesh of the same object: roots, axes and interpolation
/// boundaries go to the nearest places of its surface, to a place that faces the same way where
/// there is one near.
///
/// Boundaries are left empty, since they are edges of the first mesh; directions stay. A patch
/// whose root or more than half of whose points have no place within `reach_m` is dropped, with
/// a note; so are single points. Roots that lie more than 2 mm off in the median are noted.
/// Frames: both meshes in O, metres. Errors: InvalidInput if more than half of the patches are
/// dropped: another object or frame. Cost: O((F + points) log F).
ContactSet reproject(const ContactSet& set,
                     const geometry::TriangleMesh& from_O,
                     const geometry::TriangleMesh& to_O,
                     double reach_m = 0.005);

/// What to say where a twentieth of a contact map's mesh or more lies over 4 mm off the
/// object's surface: a map of another object, or moved along it, whose contacts may well lie on
/// it. Units: metres. Cost: O(log F) for each of 1,000 vertices.
std::optional<std::string> noteOnOtherShape(const geometry::TriangleMesh& map_O,
                                            const geometry::TriangleMesh& object_O);

}  // namespace handgraft::contact
