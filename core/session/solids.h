#pragma once

#include <memory>

#include "core/base/progress.h"
#include "core/optimize/avoidance.h"
#include "core/quality/penetration.h"
#include "core/session/models.h"

namespace handgraft::session {

// Hands and objects as solids. They are made once for each skin and each mesh, when first asked
// for, shared by all who hold these, and forgotten with them. Safe from several threads; who
// asks for what another one is making waits for it, and may be cancelled while it waits.

/// `skin` of this `model`. Errors: Cancelled on wish. Cost: some 0.3 s the first time.
std::shared_ptr<const hand::HandSolid> solidOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const Progress& progress);
std::shared_ptr<const geometry::DistanceGrid> solidOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O, const Progress& progress);

/// Makes both where they are missing, so that what is below waits for nothing.
/// Errors: Cancelled on wish.
void makeSolids(const Hand& hand,
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
    const Progress& progress);

}  // namespace handgraft::session
