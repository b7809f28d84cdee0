#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"
#include "core/hand/skin.h"
#include "core/optimize/solver.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::session {

/// A hand ready for use; shared by all sessions.
struct Hand {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
  std::vector<hand::ContactSite> sites;
};

// === Edits: what a user may change (idl/edits.idl says the same on the wire)
enum class Side { kObject, kHand };
struct ObjectPoseEdit { Pose X_WO; };
struct PatchWeightEdit { std::string patch; double weight; };
struct PatchRootEdit { std::string patch; Side side; geometry::SurfacePoint root; };
struct PatchDirectionEdit { std::string patch; Side side; double angle_rad; };
struct JointLimitEdit { std::string joint; double lower; double upper; };
struct JointLockEdit { std::string joint; bool locked; };
struct PriorEdit {
  std::optional<Pose> X_WH;
  std::vector<std::string> joints;
  std::vector<double> q;
};
struct WeightsEdit { optimize::Weights weights; };
using Edit = std::variant<ObjectPoseEdit, PatchWeightEdit, PatchRootEdit, PatchDirectionEdit,
                          JointLimitEdit, JointLockEdit, PriorEdit, WeightsEdit>;

/// One patch in a session: where it is on the object, where on the hand, what came of it.
struct SessionPatch {
  contact::Patch patch;
  /// Missing when the hand has no finger for it; `dropped` says so.
  std::optional<transfer::Placement> placement;
  std::string dropped;
  transfer::PatchTransfer transferred;
  bool up_to_date = false;  ///< `transferred` answers the present roots and directions
};

/// The editable state of one grasp problem. Not thread-safe: its owner serialises the calls.
///
/// Frames: the object is placed by X_WO; everything the models say stays in O, S and L.
class Session {
 public:
  /// Matches patches to sites by name. Errors: InvalidInput if no patch has a site on the hand
  /// (naming both lists), or if the set does not fit the mesh.
  Session(Hand hand,
          std::shared_ptr<const geometry::TriangleMesh> object_O,
          const contact::ContactSet& contacts,
          const Pose& X_WO,
          const optimize::Weights& weights);

  /// Applies an edit whole or not at all: InvalidInput names the patch, joint or value, and leaves
  /// the session as it was. Counts the revision.
  void apply(const Edit& edit);

  /// Lays every patch that is not up to date onto the skin. Directions that the contact set leaves
  /// open are found first, by a solve over roots and normals alone.
  void transferPatches(const Progress& progress);

  /// The problem as it stands, in W, start and prior included. Transfer first (BrokenContract).
  [[nodiscard]] optimize::PoseProblem problem() const;

  /// Transfers what is not up to date, solves, keeps the pose as the next prior and start (paper,
  /// III-E), and returns the report.
  optimize::SolveReport optimize(const optimize::SolveOptions& options, const Progress& progress);

  [[nodiscard]] const Hand& hand() const { return hand_; }
  [[nodiscard]] const geometry::TriangleMesh& object() const { return *object_O_; }
  [[nodiscard]] const std::vector<SessionPatch>& patches() const { return patches_; }
  [[nodiscard]] const Pose& objectPose() const { return X_WO_; }
  [[nodiscard]] unsigned long long revision() const { return revision_; }

 private:
  Hand hand_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  std::vector<SessionPatch> patches_;
  Pose X_WO_;
  optimize::Weights weights_;
  hand::HandPose prior_;
  hand::HandPose start_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  std::vector<bool> locked_;
  unsigned long long revision_ = 0;
};

}  // namespace handgraft::session
