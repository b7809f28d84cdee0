#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/surface_point.h"
#include "core/hand/kinematics.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/problem_options.h"
#include "core/session/edit.h"
#include "core/session/solver_settings.h"
#include "core/transfer/patch_placement.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::session {

/// What may be edited of a patch; its outline is the contact set's.
struct DocumentPatch {
  std::string name;
  bool enabled = true;
  double weight = 1.0;
  geometry::SurfacePoint root_O;
  /// Missing until it is found; found ones come with a committed solve.
  std::optional<Eigen::Vector3d> direction_O;
  /// Nobody chose the direction on the object: it may change with every committed solve.
  bool direction_is_open = false;
  std::string site;  ///< it was laid on first; empty if it has none
  /// Missing when the hand has no place for it; `dropped` says why.
  std::optional<transfer::PatchPlacement> placement;
  std::string dropped;
  /// Nobody chose the root on the hand: it may slide along its finger with every solve.
  bool root_is_open = false;

  /// Its weight in the problem.
  [[nodiscard]] double effectiveWeight() const { return enabled ? weight : 0.0; }
};

/// A degree of freedom of the hand.
struct DocumentJoint {
  double lower = 0.0;  ///< rad or m; infinite where there is none
  double upper = 0.0;
  bool locked = false;
  double soft_weight = 0.0;  ///< 0: not held softly
  double soft_value = 0.0;
};

/// A place of the hand that was dragged somewhere: a contact of its own, until it is let go.
struct PinnedPoint {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_W = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d> target_R_WL;  ///< missing: the link turns as it likes
  double weight = 1.0;                         ///< as DragEdit's
};

/// All that is editable of one grasp problem, and nothing that follows from it: a value.
///
/// Everything a session shows is a function of this and of the models it names. Compared to the
/// byte. A few kilobytes.
struct Document {
  std::string hand;  ///< names of models
  std::string object;
  std::string contacts;
  Pose X_WO = Pose::Identity();
  std::vector<DocumentPatch> patches;  ///< in the order of the contact set
  std::vector<DocumentJoint> joints;   ///< in the order of the hand's dofs
  std::vector<PinnedPoint> held;       ///< at most one a link, in the order of their drags
  hand::HandPose prior;
  hand::HandPose start;
  bool start_is_known = false;  ///< found by a solve or set by the user, not the rest pose
  /// `start` answers everything else as it stands: an edit clears it, a commit sets it.
  bool is_solved = false;
  optimize::Weights weights;
  optimize::PriorShares prior_shares;
  SolverSettings solving;
  transfer::TransferOptions transfer;
  /// Of a motion's: what holds about one of its times, the later over the earlier.
  std::vector<TimedEdit> timed;
  /// On the matching, and what was dropped or carried on the way; for people.
  std::vector<std::string> notes;
};

bool operator==(const Document& a, const Document& b);

/// The document as bytes: equal for equal documents alone.
std::string bytesOf(const Document& document);

/// What makes one document of another: values of the second wherever they differ.
///
/// Small for the edits people make (a weight: some 300 bytes), so that histories may be long.
struct DocumentChange {
  std::optional<std::string> hand;
  std::optional<std::string> object;
  std::optional<std::string> contacts;
  std::optional<Pose> X_WO;
  std::optional<std::size_t> patch_count;  ///< where they were not as many; then all are here
  std::vector<std::pair<std::size_t, DocumentPatch>> patches;  ///< by index
  std::optional<std::size_t> joint_count;
  std::vector<std::pair<std::size_t, DocumentJoint>> joints;
  std::optional<std::vector<PinnedPoint>> held;
  std::optional<hand::HandPose> start;
  std::optional<hand::HandPose> prior;
  bool prior_is_start = false;  ///< the second's are the same, and `start` is given
  std::optional<bool> start_is_known;
  std::optional<bool> is_solved;
  std::optional<optimize::Weights> weights;
  std::optional<optimize::PriorShares> prior_shares;
  std::optional<SolverSettings> solving;
  std::optional<transfer::TransferOptions> transfer;
  std::optional<std::vector<TimedEdit>> timed;
  std::optional<std::vector<std::string>> notes;
};

/// `applyTo(from, changeBetween(from, to)) == to`.
DocumentChange changeBetween(const Document& from, const Document& to);

/// Errors: InvalidInput if an index lies beyond the document's lists, which a change made for
/// another document may have.
Document applyTo(Document document, const DocumentChange& change);

}  // namespace handgraft::session
