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
#include "core/transfer/staged_transfer.h"
#include "core/transfer/suggestion.h"

namespace handgraft::session {

class HandPlacer;
struct HandPlacement;

/// A hand ready for use; shared by all sessions.
struct Hand {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
  std::vector<hand::ContactSite> sites;
  /// Log maps of the skin, so that sessions share what those keep; a session makes its own
  /// where it is missing.
  std::shared_ptr<const geometry::LogMapper> skin_maps = nullptr;
  /// Nobody chose the sites: they say which finger, and where on it only roughly. Patches on
  /// them may slide.
  bool sites_are_found = false;
};

// === Edits: what a user may change (idl/edits.idl says the same on the wire)
enum class Side { kObject, kHand };

struct ObjectPoseEdit {
  Pose X_WO;
};

struct PatchWeightEdit {
  std::string patch;
  double weight;
};

struct PatchRootEdit {
  std::string patch;
  Side side;
  geometry::SurfacePoint root;
};

struct PatchDirectionEdit {
  std::string patch;
  Side side;
  double angle_rad;
};

struct JointLimitEdit {
  std::string joint;
  double lower;
  double upper;
};

// A locked joint stays where the start has it.
struct JointLockEdit {
  std::string joint;
  bool locked;
};

// Sets the prior and the start; what is not named stays as it was.
struct PriorEdit {
  std::optional<Pose> X_WH;
  std::vector<std::string> joints;
  std::vector<double> q;
};

struct WeightsEdit {
  optimize::Weights weights;
};

using Edit = std::variant<ObjectPoseEdit,
                          PatchWeightEdit,
                          PatchRootEdit,
                          PatchDirectionEdit,
                          JointLimitEdit,
                          JointLockEdit,
                          PriorEdit,
                          WeightsEdit>;

/// One patch in a session: where it is on the object, where on the hand, what came of it.
struct SessionPatch {
  contact::Patch patch;
  /// The site it was laid on first; empty if it has none.
  std::string site;
  /// Missing when the hand has no finger for it; `dropped` says so.
  std::optional<transfer::Placement> placement;
  std::string dropped;
  transfer::PatchTransfer transferred;
  transfer::StagedTransfer stages;  ///< what `transferred` was made with, kept for the next
  bool up_to_date = false;          ///< `transferred` answers the present roots and directions
  /// The contact set left the direction open: `patch.direction_O` is ours, found by a solve,
  /// and may change with the next one. An edit makes it the user's.
  bool direction_is_open = false;
  /// The site was found, not chosen: `placement.root_S` is ours and may slide along the site's
  /// finger or over the palm with every solve. An edit of the hand's side makes it the user's.
  bool root_is_open = false;
};

/// The editable state of one grasp problem. Not thread-safe: its owner serialises the calls.
///
/// Frames: the object is placed by X_WO; everything the models say stays in O, S and L.
class Session {
 public:
  /// Matches patches to sites by name; patches c1, c2, ... and sites f1, f2, ... have none and
  /// are matched by geometry (site_assignment.h).
  ///
  /// Errors: InvalidInput if two patches share a name, a name is neither a finger's, nor
  /// `palm`,
  ///   nor one of the hand's sites (naming those), no patch has a site on the hand (naming both
  ///   lists), the set does not fit the mesh, or the options are out of range. A finger that
  ///   this hand lacks is no error: the patch is dropped and says so.
  Session(Hand hand,
          std::shared_ptr<const geometry::TriangleMesh> object_O,
          const contact::ContactSet& contacts,
          const Pose& X_WO,
          const optimize::Weights& weights,
          const transfer::TransferOptions& transfer_options = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// Applies an edit whole or not at all: InvalidInput names the patch, joint or value, and
  /// leaves the session as it was. Counts the revision.
  ///
  /// A root that moves takes its direction along by the rotation between the two normals. A
  /// root on the hand brings a dropped patch back, its direction pointing to the hand's root.
  void apply(const Edit& edit);

  /// Lays every patch that is not up to date onto the skin, with the charts that it has where
  /// they still hold (StagedTransfer). Directions that the contact set
  /// leaves open are found first, by a solve over roots and normals alone.
  void transferPatches(const Progress& progress);

  /// Placements near the present one that lose fewer of the patch's points (suggestion.h), from
  /// the patches as `transferPatches` leaves them. Moves no patch: a root edit to
  /// `placement.root_S`, then a direction edit by `turned_rad`, both on the hand's side, make a
  /// suggestion come true.
  ///
  /// Errors: InvalidInput for an unknown or dropped patch and for options out of range.
  std::vector<transfer::Suggestion> suggest(const std::string& patch,
                                            const transfer::SuggestOptions& options,
                                            const Progress& progress);

  /// The problem as it stands, in W, start and prior included. Transfer first (BrokenContract).
  /// The pairs' `patch` is the index into `patches()`.
  [[nodiscard]] optimize::PoseProblem problem() const;

  /// Transfers what is not up to date, solves, keeps the pose as the next prior and start
  /// (paper, III-E), and returns the report. Open directions are found anew from the solved
  /// pose, up to twice, and kept when the objective falls; then open roots slide, up to twelve
  /// times, and the best of it is kept. Errors: InvalidInput if no patch has a point on the
  /// hand, or all are switched off.
  optimize::SolveReport optimize(const optimize::SolveOptions& options,
                                 const Progress& progress);

  /// The problem that the last `optimize` answered, with the start and the prior it had;
  /// missing before the first. Edits since then are not in it.
  [[nodiscard]] const std::optional<optimize::PoseProblem>& solvedProblem() const {
    return solved_;
  }

  [[nodiscard]] const Hand& hand() const { return hand_; }

  [[nodiscard]] const geometry::TriangleMesh& object() const { return *object_O_; }

  [[nodiscard]] const std::vector<SessionPatch>& patches() const { return patches_; }

  [[nodiscard]] const Pose& objectPose() const { return X_WO_; }

  [[nodiscard]] const optimize::Weights& weights() const { return weights_; }

  [[nodiscard]] const transfer::TransferOptions& transferOptions() const {
    return transfer_options_;
  }

  [[nodiscard]] unsigned long long revision() const { return revision_; }

  /// Remarks on the matching ("c1 laid on 'thumb'") after those of the contact set.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  void matchByName();
  void matchByGeometry();
  void applyOne(const ObjectPoseEdit& edit);
  void applyOne(const PatchWeightEdit& edit);
  void applyOne(const PatchRootEdit& edit);
  void applyOne(const PatchDirectionEdit& edit);
  void applyOne(const JointLimitEdit& edit);
  void applyOne(const JointLockEdit& edit);
  void applyOne(const PriorEdit& edit);
  void applyOne(const WeightsEdit& edit);
  [[nodiscard]] SessionPatch& patchNamed(const std::string& name);
  [[nodiscard]] const HandPlacer& placer();
  void findOpenDirections(const Progress& progress);
  /// Takes start and directions from the placement that a full transfer and a short solve like
  /// best.
  void choosePlacement(const std::vector<HandPlacement>& placements, const Progress& progress);
  void layPatches(const Progress& progress);
  /// Sets the open directions as `pose` shows them; true if one turned by more than a degree.
  bool takeDirectionsFrom(const hand::HandPose& pose);
  /// Slides the open roots to where `pose` shows the patches' roots, and sets the open
  /// directions; true if a root moved by more than a face or so.
  bool takeRootsFrom(const hand::HandPose& pose);
  /// The links of the finger or palm that a site lies on, a flag a link.
  [[nodiscard]] std::vector<char> linksOfSite(const std::string& site);
  /// One more solve with the open directions as the report's pose shows them; kept, and true,
  /// if the objective falls.
  bool refineDirections(optimize::SolveReport& report,
                        const optimize::SolveOptions& options,
                        const Progress& progress);
  /// Solves after each of a few slides of the open roots; keeps the best of them that loses no
  /// more points, by the objective a point, or what there was.
  void slideRoots(optimize::SolveReport& report,
                  const optimize::SolveOptions& options,
                  const Progress& progress);
  void requirePoints() const;

  Hand hand_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  std::vector<SessionPatch> patches_;
  Pose X_WO_;
  optimize::Weights weights_;
  transfer::TransferOptions transfer_options_;
  transfer::Surfaces surfaces_;
  hand::HandPose prior_;
  hand::HandPose start_;
  bool start_is_known_ = false;  ///< found by a solve or set by the user, not the rest pose
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  std::vector<bool> locked_;
  unsigned long long revision_ = 0;
  std::optional<optimize::PoseProblem> solved_;
  std::vector<std::string> notes_;
  std::unique_ptr<HandPlacer> placer_;       ///< made when first needed
  std::vector<std::string> parts_of_links_;  ///< likewise (hand/hand_parts.h)
};

}  // namespace handgraft::session
