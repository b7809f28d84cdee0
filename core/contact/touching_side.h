#pragma once

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/digits.h"

namespace handgraft::contact {

/// Whether a right or a left hand touched: as its maker says, else by where its fingers'
/// contacts follow each other, seen along the way that its palm faced: as its posture tells,
/// else as the contacts' directions and normals do (of 244 recorded right hands one at most is
/// taken for a left one then, none with postures). Unknown where these disagree, with fewer
/// than two fingers that touched beside the thumb, and where their contacts lie across each
/// other.
hand::Chirality touchingSide(const ContactSet& contacts,
                             const geometry::TriangleMesh& object_O);

}  // namespace handgraft::contact
