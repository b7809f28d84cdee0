#pragma once

#include <optional>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/retargeting/live_grasp.h"

namespace handgraft::retargeting {

/// m; so deep nobody holds an object.
inline constexpr double kDeep = 0.002;

/// A pose that was looked for, and what holds the object in it.
struct LookedFor {
  LiveGrasp grasp;
  double depth = 0.0;  ///< m, in the object
};

/// The best pose that shows what `from` sees, from many starts; where touches leave it open
/// held as the demonstrator's hand is, whose `posture` it is. Fingers as `from` has them, or
/// dealt out anew: of ways that reach as much, the one that leaves fingers for what may touch
/// next. Nothing where no touch has a place on the hand.
///
/// Deterministic. Errors: Cancelled on wish. Cost: 10 to 150 ms.
std::optional<LookedFor> lookFor(LiveGrasp from,
                                 bool deals_anew,
                                 const std::vector<contact::PartDirection>& posture,
                                 const Progress& progress);

}  // namespace handgraft::retargeting
