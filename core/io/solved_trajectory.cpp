#include "core/io/solved_trajectory.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace handgraft::io {

HandTrajectory trajectoryOf(const manipulation::Motion& motion,
                            const retargeting::SolvedMotion& solved,
                            std::shared_ptr<const geometry::TriangleMesh> object_O) {
  const std::vector<hand::HandPose>& poses_O = solved.trajectory.poses;
  HANDGRAFT_REQUIRE(!poses_O.empty() && poses_O.size() == motion.X_WO.size());
  HandTrajectory trajectory;
  trajectory.motion = motion.name;
  trajectory.model = solved.problem.model;
  trajectory.patch_names = retargeting::patchNames(motion);
  trajectory.notes = solved.notes;
  const retargeting::MotionFits fits(motion, solved);
  for (int k = 0; k < motion.frameCount(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Pose& X_WO = motion.X_WO[at];
    TrajectoryFrame frame;
    frame.time_s = motion.time_s[at];
    frame.pose_W = {X_WO * poses_O[at].X_WH, poses_O[at].q};
    frame.X_WO = X_WO;
    frame.depths = solved.depths[at];
    for (const retargeting::PatchFrameFit& fit : fits.at(k)) {
      const manipulation::PatchTrack& track =
          motion.tracks[static_cast<std::size_t>(fit.track)];
      const contact::Patch& shape =
          track.keyAt(std::clamp(k, track.begin(), track.end - 1)).patch;
      frame.patches.push_back({fit.patch, fit.presence, fit.mean_mm, fit.normal_deg,
                               fit.reached, X_WO * positionOf(*object_O, shape.root)});
    }
    trajectory.frames.push_back(std::move(frame));
  }
  trajectory.object_O = std::move(object_O);
  return trajectory;
}

}  // namespace handgraft::io
