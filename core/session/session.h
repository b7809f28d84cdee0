#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/optimize/solver.h"
#include "core/session/comparison.h"
#include "core/session/derived_state.h"
#include "core/session/document.h"
#include "core/session/edit.h"
#include "core/session/history.h"
#include "core/session/log.h"
#include "core/session/models.h"

namespace handgraft::session {

/// What became of an edit.
struct EditResult {
  unsigned long long revision = 0;  ///< after it
  std::string message;              ///< for people, if there is something to say: "2 mm short"
};

/// A session as a file holds it (core/io/session_file.h).
struct SavedSession {
  LogStart first;
  std::vector<LogEntry> log;
  History history;
  unsigned long long revision = 0;
};

/// The editable state of one grasp problem, with its history. Not thread-safe: its owner
/// serialises the calls.
///
/// What is edited is a value (`document`); edits, undo and committed solves replace it, and
/// nothing else does. All that follows from it (`patches`, `problem`) is made when asked for.
/// The same first document, edits and committed solves give the same bytes, whatever was
/// solved, shown or cancelled in between.
///
/// Frames: the object is placed by X_WO; everything the models say stays in O, S and L.
class Session {
 public:
  /// Matches patches to sites by name; patches c1, c2, ... and sites f1, f2, ... have none and
  /// are matched by geometry (site_assignment.h).
  ///
  /// Errors: InvalidInput if two patches share a name, a name is neither a finger's, nor
  /// `palm`, nor one of the hand's sites (naming those), no patch has a site on the hand
  /// (naming both lists), the set does not fit the mesh, or the options are out of range. A
  /// finger that this hand lacks is no error: the patch is dropped and says so. Cancelled on
  /// wish. Cost: some milliseconds; where the hand cannot have all patches together up to a
  /// dozen solves (best_way.h).
  Session(SessionModels models,
          const Pose& X_WO,
          const optimize::Weights& weights,
          const transfer::TransferOptions& transfer_options = {},
          const Progress& progress = Progress());

  /// The same with the models' own names and no others to swap to.
  Session(hand::Hand hand,
          std::shared_ptr<const geometry::TriangleMesh> object_O,
          const contact::ContactSet& contacts,
          const Pose& X_WO,
          const optimize::Weights& weights,
          const transfer::TransferOptions& transfer_options = {});

  /// A session as it was saved. Errors: InvalidInput if the models lack something that it
  /// names, or one of its documents breaks what documents promise (apply_edit.h).
  Session(SessionModels models, SavedSession saved);

  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  // === Edits

  /// Applies an edit whole or not at all: InvalidInput names the patch, joint or value, and
  /// leaves the session as it was. Counts the revision, also for undo, redo and snapshots.
  ///
  /// A root that moves takes its direction along by the rotation between the two normals. A
  /// root on the hand brings a dropped patch back, its direction pointing to the hand's root.
  /// Cost: some 10 us; a drag and the first edit of a direction that is open lay patches; a
  /// hand's or an object's swap may take as long as opening a session. Cancelled on wish.
  ///
  /// `keep` is told of the entry of the log and of what is about to stand, once nothing else
  /// can fail: what it throws passes through, and leaves the session as it was.
  using Keep = std::function<void(const LogEntry& entry, const EditResult& result)>;
  EditResult apply(const Edit& edit,
                   const Progress& progress = Progress(),
                   const Keep& keep = Keep());

  [[nodiscard]] unsigned long long revision() const { return revision_; }

  [[nodiscard]] const Document& document() const { return history_.present(); }

  [[nodiscard]] const History& history() const { return history_; }

  [[nodiscard]] const Log& log() const { return log_; }

  [[nodiscard]] SavedSession saved() const;

  /// Where `a` and `b` differ, names of snapshots, or empty for the present; fits included
  /// where both can be laid. Errors: InvalidInput for a name that is not there.
  std::vector<Difference> compare(const std::string& a,
                                  const std::string& b,
                                  const Progress& progress);

  // === Solves

  /// Lays every patch that is not up to date onto the skin, with the charts that it has where
  /// they still hold (StagedTransfer). Directions that the contact set leaves open are found
  /// first, by a solve over roots and normals alone. Changes nothing of the document.
  void transferPatches(const Progress& progress);

  /// Solves the document as it stands, and changes nothing. Transfers what is not up to date.
  /// Open directions are found anew from the solved pose, up to twice, and kept when the
  /// objective falls; then open roots slide, up to twelve times, and the best of it is kept; in
  /// the paper's way neither. Errors: InvalidInput if no patch has a point on the hand, or all
  /// are switched off.
  Solution solve(const SolverSettings& solving, const SolveRun& run, const Progress& progress);

  /// Takes a solution of the present revision: its pose becomes prior and start (paper, III-E),
  /// and what it found of roots and directions stays. No edit: the revision stays. Also to be
  /// called for solutions whose publication nobody saw.
  /// Errors: BrokenContract if the session was edited since it was solved.
  /// Returns the entry of the log.
  std::shared_ptr<const CommittedSolve> commit(Solution solution);

  /// Takes a committed solve of a log, by its value. Errors: InvalidInput if it does not fit.
  void commit(const CommittedSolve& solve);

  /// Writes down that a solve ended without an answer.
  void noteCancelledSolve();

  /// Writes down how the session's motion was solved.
  void noteFollowed(const FollowedMotion& motion);

  /// The start as it stands, judged without a search: the answer after undo, redo, restore and
  /// choice. With the minima of the last committed solution where the start is one of them.
  Solution standing(const Progress& progress);

  /// Somebody edited, and no solution answers what stands; false after undo and redo to
  /// documents that were solved.
  [[nodiscard]] bool needsSolve() const;

  /// `solve` and `commit`, with the document's form of normals and care for depth.
  optimize::SolveReport optimize(const optimize::SolveOptions& options,
                                 const Progress& progress);

  /// The problem that the last committed solution answered, with the start and the prior it
  /// had; missing before the first. Edits since then are not in it.
  [[nodiscard]] const std::optional<optimize::PoseProblem>& solvedProblem() const {
    return solved_;
  }

  /// Rank of the last committed solution's minima that an edit chose; 0 unless it did, and
  /// after every commit.
  [[nodiscard]] int chosenMinimum() const { return chosen_minimum_; }

  /// The last committed solution's minima, best first; empty after a swap of the hand.
  [[nodiscard]] const std::vector<optimize::Minimum>& minima() const { return minima_; }

  // === What follows from the document

  /// The problem as it stands, in W, start and prior included. Transfer first (BrokenContract).
  /// The pairs' `patch` is the index into `patches()`.
  [[nodiscard]] optimize::PoseProblem problem() const;

  /// Placements near the present one that lose fewer of the patch's points (suggestion.h), from
  /// the patches as `transferPatches` leaves them. Moves no patch: a root edit to
  /// `placement.root_S`, then a direction edit by `turned_rad`, both on the hand's side, make a
  /// suggestion come true.
  ///
  /// Errors: InvalidInput for an unknown or dropped patch and for options out of range.
  std::vector<transfer::Suggestion> suggest(const std::string& patch,
                                            const transfer::SuggestOptions& options,
                                            const Progress& progress);

  [[nodiscard]] const std::vector<SessionPatch>& patches() const { return derived_.patches(); }

  [[nodiscard]] const Models& models() const { return derived_.models(); }

  [[nodiscard]] const hand::Hand& hand() const { return *derived_.models().hand; }

  [[nodiscard]] const geometry::TriangleMesh& object() const {
    return *derived_.models().object_O;
  }

  [[nodiscard]] const std::shared_ptr<const geometry::TriangleMesh>& sharedObject() const {
    return derived_.models().object_O;
  }

  /// What follows from documents, beside the session's own, whose charts stay for what is
  /// edited next.
  [[nodiscard]] DerivedState aside() const { return DerivedState(cache_); }

  /// Shared, for fingerprints and swaps.
  [[nodiscard]] ModelCache& cache() { return *cache_; }

  // === Shorthands of the document

  [[nodiscard]] const Pose& objectPose() const { return document().X_WO; }

  [[nodiscard]] const optimize::Weights& weights() const { return document().weights; }

  [[nodiscard]] const transfer::TransferOptions& transferOptions() const {
    return document().transfer;
  }

  /// Remarks on the matching ("c1 laid on 'thumb'") after those of the contact set.
  [[nodiscard]] const std::vector<std::string>& notes() const { return document().notes; }

 private:
  /// Undo, redo, snapshot or restore; what there is to say about it.
  std::string travel(const Edit& edit, History& history) const;

  std::shared_ptr<ModelCache> cache_;
  DerivedState derived_;
  History history_;
  Log log_;
  unsigned long long revision_ = 0;
  std::optional<optimize::PoseProblem> solved_;
  std::vector<optimize::Minimum> minima_;
  int chosen_minimum_ = 0;
};

}  // namespace handgraft::session
