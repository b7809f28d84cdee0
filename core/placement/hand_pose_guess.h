#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/contact/patch.h"
#include "core/geometry/solid.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"
#include "core/optimize/pose_problem.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::placement {

/// A patch's root and the place on the hand that shall meet it: all that is known of a contact
/// before its outline is laid onto the skin.
struct Anchor {
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> direction_O;  ///< unit tangent, where it is known
  int link = 0;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_L = Eigen::Vector3d::Zero();
};

/// The hand's side of an anchor, from a place on the skin; nothing if no link is near it.
std::optional<Anchor> anchorAt(const hand::Skin& skin,
                               const transfer::PatchPlacement& placement);

/// The anchor with the object's side from a patch: its root, and its direction if that counts
/// as known.
Anchor withObjectSide(Anchor anchor,
                      const contact::Patch& patch,
                      const geometry::TriangleMesh& object_O,
                      bool direction_is_known);

/// The pose problem of anchors alone: a pair per root, and a second one, a short way along the
/// direction, where that is known. The prior holds the joints near rest and leaves the root
/// free.
///
/// Frames: X_WO places the anchors' object side.
optimize::PoseProblem anchorProblem(std::shared_ptr<const hand::HandModel> model,
                                    const std::vector<Anchor>& anchors,
                                    const Pose& X_WO);

/// Joints on the way from rest (share 0) to the middle of their range (share 1).
Eigen::VectorXd curledPose(const hand::HandModel& model, double share);

/// A hand held against an object.
struct HandPoseGuess {
  hand::HandPose pose;
  double score = 0.0;  ///< objective of the anchors plus the charge for depth inside the object
};

/// Finds poses that bring a hand's anchors onto an object from the outside.
///
/// Roots and normals leave the hand much freedom, so poses are compared by their objective plus
/// a charge for skin that lies inside the object. Source: none; the paper lets the user choose
/// directions.
class HandPoseGuesser {
 public:
  /// Keeps its own copies of what it needs of the skin, and shares the object.
  HandPoseGuesser(std::shared_ptr<const hand::HandModel> model,
                  const hand::Skin& skin,
                  std::shared_ptr<const geometry::Solid> object_O);

  /// Poses found from `starts` deterministic starts, best first.
  /// Errors: Cancelled on wish. Cost: about a millisecond a start.
  [[nodiscard]] std::vector<HandPoseGuess> place(const std::vector<Anchor>& anchors,
                                                 const Pose& X_WO,
                                                 int starts,
                                                 const Progress& progress) const;

  /// Mean square depth of the hand's skin inside the object, m^2; thin walls count little.
  [[nodiscard]] double meanSquareDepth(const hand::HandPose& pose, const Pose& X_WO) const;

  /// What that depth adds to an objective over `pair_count` pairs, to rank poses.
  [[nodiscard]] double depthCharge(const hand::HandPose& pose,
                                   const Pose& X_WO,
                                   std::size_t pair_count) const;

 private:
  struct Sample {
    int link;
    Eigen::Vector3d p_L;
  };

  std::shared_ptr<const hand::HandModel> model_;
  std::vector<Sample> samples_;
  std::shared_ptr<const geometry::Solid> object_O_;
};

}  // namespace handgraft::placement
