#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// A hand, and apart from it the joints by which its file places it in the world.
struct RootedHand {
  HandModel hand;
  /// From the file's root link to the hand's, which is its last link. Missing where the file
  /// brings no floating base.
  std::optional<HandModel> carrier;
};

/// Cuts off the joints that move a whole hand freely: a chain of links without a surface, from
/// the root on, whose joints span all six freedoms. Poses carry the floating base as X_WH
/// already; a second one on top would leave the optimiser a valley without a floor.
///
/// `solid_links` names the links that have a surface. Chains that span fewer freedoms, and
/// those that a joint of the hand mimics, stay. Cost: O(links).
RootedHand cutFloatingBase(const HandModel& model, const std::set<std::string>& solid_links);

/// Pose of the hand's root link in the frame of the file's root link. Shapes: q of
/// carrier.dofCount() entries.
Pose carriedPose(const HandModel& carrier, const Eigen::VectorXd& q);

}  // namespace handgraft::hand
