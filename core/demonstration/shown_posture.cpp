#include "core/demonstration/shown_posture.h"

#include <algorithm>

#include "core/hand/hand_location.h"

namespace handgraft::demonstration {

std::vector<contact::PartDirection> shownPosture(const std::vector<hand::TurnedPart>& parts,
                                                 const hand::LinkPoses& X_SO) {
  std::vector<contact::PartDirection> posture;
  posture.reserve(parts.size());
  for (const hand::TurnedPart& part : parts) {
    const Eigen::Matrix3d R_OS = X_SO[static_cast<std::size_t>(part.link)].linear().transpose();
    posture.push_back({part.name, R_OS * part.outward_S, R_OS * part.palmar_S});
  }
  return posture;
}

manipulation::DemonstratorKey shownAt(int frame,
                                      const hand::Hand& hand,
                                      const std::vector<hand::TurnedPart>& parts,
                                      const hand::HandPose& pose,
                                      const Pose& X_WO) {
  const hand::HandPose pose_O{inverse(X_WO) * pose.X_WH, pose.q};
  const auto palm = std::find_if(parts.begin(), parts.end(), [](const hand::TurnedPart& part) {
    return part.name == hand::kPalmPart;
  });
  const int link = palm != parts.end() ? palm->link : 0;
  const hand::LinkPoses X_OL = forwardKinematics(*hand.model, pose_O);
  return {frame, X_OL[static_cast<std::size_t>(link)],
          shownPosture(parts, hand.skin->fromWorld(*hand.model, pose_O))};
}

}  // namespace handgraft::demonstration
