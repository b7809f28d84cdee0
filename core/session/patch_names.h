#pragma once

#include <string>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/contact_site.h"

namespace handgraft::session {

/// Patches c1, c2, ... and sites f1, f2, ...: names that say nothing about the finger.
bool isAnonymousPatch(const std::string& name);
bool isAnonymousSite(const std::string& name);

/// `thumb`, `index`, `middle`, `ring`, `little`: as people's are called.
bool isFinger(const std::string& name);

/// The names, for messages.
std::string namesOf(const std::vector<hand::ContactSite>& sites);

/// Mesh, names and weights of a contact set; the hand's sites decide which names are known.
/// Errors: InvalidInput naming the set and the patch.
void validateSet(const contact::ContactSet& set,
                 const geometry::TriangleMesh& object_O,
                 const std::vector<hand::ContactSite>& sites);

}  // namespace handgraft::session
