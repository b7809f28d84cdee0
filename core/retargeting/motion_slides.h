#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/trajectory.h"
#include "core/manipulation/transfer_patches.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::retargeting {

/// A motion on a hand, of which a document speaks.
struct MotionScene {
  const session::Document& document;
  const hand::Hand& hand;
  const std::shared_ptr<const geometry::TriangleMesh>& object_O;
  const contact::ContactSet& grasp;  ///< stands for the motion (graspOf)
  const MotionSolving& solving;
};

/// What slides find beside the places that keys then have.
struct SlidPatches {
  std::vector<hand::HandPose> poses_O;  ///< of each frame: what shows the places
  /// Charts of each key, where every key was looked at.
  std::optional<manipulation::MotionCharts> charts;
};

/// Slides the patches of each key on the hand to where the hand shows them as it follows the
/// motion, ten times, as grasps do.
///
/// Looks at a frame each 50 ms: hands and areas move little in between, and whoever calls
/// solves all of them anyway. `known`: poses to set out from. Keys keep their places where
/// slides do not make the whole better. Errors: as solveOffline. Cost: some ten short solves of
/// those frames, and as many log maps as keys.
SlidPatches slidePatches(const MotionScene& scene,
                         const std::vector<manipulation::FramePose>& known,
                         const Progress& progress,
                         manipulation::Motion& motion);

}  // namespace handgraft::retargeting
