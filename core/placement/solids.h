#pragma once

#include <memory>

#include "core/base/progress.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/hand.h"
#include "core/optimize/avoidance.h"
#include "core/quality/penetration.h"

namespace handgraft::placement {

// Hands and objects as solids. They are made once for each skin and each mesh, when first asked
// for, shared by all who hold these, and forgotten with them (weak_cache.h).

/// `skin` of this `model`. Errors: Cancelled on wish. Cost: some 0.3 s the first time.
std::shared_ptr<const hand::HandSolid> solidOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const Progress& progress);
std::shared_ptr<const geometry::Solid> solidOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O, const Progress& progress);

/// From now on `solid` is also that of `model`, a hand of the same surfaces and rest pose which
/// differs in how far its joints go; unless that has one already.
void shareSolid(const std::shared_ptr<const hand::HandModel>& model,
                const std::shared_ptr<const hand::HandSolid>& solid);

/// Nearest places on an object, shared likewise: as large as the object's mesh, or larger.
/// Errors: InvalidInput if the mesh has no face. Cost: O(F log F) the first time.
std::shared_ptr<const geometry::SurfaceLocator> locatorOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O);

/// Makes both solids where they are missing, so that what is below waits for nothing.
/// Errors: Cancelled on wish.
void makeSolids(const hand::Hand& hand,
                const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                const Progress& progress);

/// What keeps a hand out of an object that stands at X_WO.
std::shared_ptr<const optimize::Avoidance> avoidanceOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const Pose& X_WO,
    const Progress& progress);

/// Cost: below a millisecond once the solids are there.
quality::Penetration penetrationOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const Pose& X_WO,
    const hand::HandPose& pose,
    const std::vector<quality::ContactSide>& sides,
    const Progress& progress);

/// How deep a pose in O lies inside the object, and no more.
double deepestOf(const std::shared_ptr<const hand::HandModel>& model,
                 const std::shared_ptr<const hand::Skin>& skin,
                 const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                 const hand::HandPose& X_OH,
                 const Progress& progress,
                 const std::vector<quality::ContactSide>& sides = {});

/// How deep a pose in O lies inside the object and in itself, and no more.
quality::Depths depthsOf(const std::shared_ptr<const hand::HandModel>& model,
                         const std::shared_ptr<const hand::Skin>& skin,
                         const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                         const hand::HandPose& X_OH,
                         const Progress& progress,
                         const std::vector<quality::ContactSide>& sides = {});

}  // namespace handgraft::placement
