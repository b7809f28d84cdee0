#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include <Eigen/Core>

#include "idl/models.h"

namespace handgraft::client {

/// A point that moves with a link of a hand.
struct HandPoint {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
};

/// What people call so: a site; with `_tip` behind a site's name, the vertex of its link that
/// lies furthest from the wrist; a link's origin. `with_meshes`, the same hand, is asked for
/// where a vertex is meant.
/// Errors: InvalidInput if the hand has neither such a site nor such a link; what `with_meshes`
/// throws.
HandPoint handPointNamed(const v1::HandDescription& hand,
                         const std::string& name,
                         const std::function<const v1::HandDescription&()>& with_meshes);

/// The palm's site; on a hand without one, its root link. Errors: InvalidInput without links.
HandPoint palmPointOf(const v1::HandDescription& hand);

/// Null if there is none.
const v1::SiteInfo* siteNamed(const v1::HandDescription& hand, const std::string& name);

/// Errors: InvalidInput for a link that the hand has not.
std::size_t linkIndex(const v1::HandDescription& hand, const std::string& name);

}  // namespace handgraft::client
