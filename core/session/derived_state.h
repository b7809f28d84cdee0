#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/optimize/solver.h"
#include "core/session/document.h"
#include "core/session/models.h"
#include "core/transfer/patch_transfer.h"
#include "core/transfer/staged_transfer.h"
#include "core/transfer/suggestion.h"

namespace handgraft::hand {
class FingerCoordinates;
}  // namespace handgraft::hand

namespace handgraft::placement {
class HandPoseGuesser;
class SkinFaces;
struct HandPoseGuess;
struct Posture;
}  // namespace handgraft::placement

namespace handgraft::quality {
struct ContactSide;
}  // namespace handgraft::quality

namespace handgraft::session {

/// One patch of a session: where it is on the object, where on the hand, what came of it.
struct SessionPatch {
  contact::Patch patch;  ///< with the document's root, direction and effective weight
  std::string site;
  std::optional<transfer::PatchPlacement> placement;
  std::string dropped;
  transfer::PatchTransfer transferred;
  transfer::StagedTransfer stages;  ///< what `transferred` was made with, kept for the next
  bool up_to_date = false;          ///< `transferred` answers the present roots and directions
  bool direction_is_open = false;
  bool root_is_open = false;
};

/// From which side each point of the patches that are laid and count is to be touched.
std::vector<quality::ContactSide> contactSides(const std::vector<SessionPatch>& patches);

/// How a solve runs, beyond what the session's way of solving says.
struct SolveRun {
  int threads = 1;
  /// Roots and directions that nobody chose stay where the last solve left them, as in the
  /// paper's way: for what follows an edit, which is to stay where it was put. Unless the
  /// start is not known and nothing is reached from there: then the search is a whole one.
  bool places_stay = false;
  /// As optimize::SolveOptions.
  std::function<void(const hand::HandPose&, const optimize::Terms&)> on_improvement;
};

/// A pose that answers a document, not yet taken.
struct Solution {
  optimize::SolveReport report;
  optimize::PoseProblem problem;  ///< that it answers, with the start and prior it had
  SolverSettings solving;
  /// The document with the pose as start and prior, and the roots and directions found on the
  /// way.
  Document document;
  std::vector<SessionPatch> patches;  ///< laid as in `problem`
  unsigned long long revision = 0;    ///< of the session that was solved
};

/// Patches that an answer misses: all of them where the hand is inside the object.
std::ptrdiff_t failedPatches(const optimize::PoseProblem& posed,
                             const optimize::SolveReport& solved);

/// None of the patches that count is reached.
bool reachesNothing(const optimize::PoseProblem& posed, const optimize::SolveReport& solved);

/// Patches that count and are dropped or missed, then the objective; points that are lost count
/// as if they were far off. Less is better.
std::pair<std::ptrdiff_t, double> worthOf(const Solution& solution);

/// All that follows from a document and is dear to make: charts, laid patches, directions and
/// starts that were found. What it answers depends on the document alone, never on what was
/// asked before.
class DerivedState {
 public:
  explicit DerivedState(std::shared_ptr<ModelCache> cache);
  ~DerivedState();
  DerivedState(DerivedState&&) noexcept;
  DerivedState& operator=(DerivedState&&) noexcept;

  /// Works on `document` from now on; what still holds is kept.
  /// Errors: InvalidInput if a model cannot be found; then it works on what it did.
  void follow(const Document& document, const Progress& progress);

  /// What `solve` of the document that is followed comes to by the solution's settings, found
  /// elsewhere: it is given, not searched for, until another document is followed. Charts that
  /// it was laid with are shared.
  void expect(std::shared_ptr<const Solution> solution);

  /// Takes patches that were laid for the document that is followed.
  void adopt(std::vector<SessionPatch> patches);

  [[nodiscard]] const Document& document() const { return document_; }

  [[nodiscard]] const Models& models() const { return models_; }

  [[nodiscard]] const std::vector<SessionPatch>& patches() const { return patches_; }

  /// Lays what is not up to date; directions that nobody gave are found first.
  void transfer(const Progress& progress);

  /// Directions alone, where one is missing.
  void findOpenDirections(const Progress& progress);

  /// The problem as it stands, in W. Transfer first (BrokenContract).
  [[nodiscard]] optimize::PoseProblem problem(const SolverSettings& solving) const;

  /// Searches; the document and the patches stay as they are. From more starts than by default
  /// it finds nothing worse than from those, and for a document that is solved nothing worse
  /// than what stands.
  /// Errors: InvalidInput if no patch has a point on the hand, or all are switched off.
  Solution solve(const SolverSettings& solving, const SolveRun& run, const Progress& progress);

  /// What a short search comes to: patches are laid as drafts, and nothing is begun again.
  /// Errors: as `solve`.
  Solution solveRoughly(const SolverSettings& solving, const Progress& progress);

  /// The document's start as it stands, judged without a search.
  Solution judge(const Progress& progress);

  std::vector<transfer::Suggestion> suggest(std::size_t patch,
                                            const transfer::SuggestOptions& options,
                                            const Progress& progress);

 private:
  struct Search;
  struct Drafts;
  struct NewBeginnings;

  void followPatch(std::size_t index, const DocumentPatch& patch, bool keeps_found);
  [[nodiscard]] const placement::HandPoseGuesser& placer(const Progress& progress);
  [[nodiscard]] const hand::FingerCoordinates& coordinates();
  /// Takes start and directions from the placement that a full transfer and a short solve like
  /// best.
  void choosePlacement(const std::vector<placement::HandPoseGuess>& placements,
                       const Progress& progress);
  void transferPatches(const Progress& progress);
  /// Sets the open directions as `pose` shows them; true if one turned by more than a degree.
  bool takeDirectionsFrom(const hand::HandPose& pose);
  /// Slides open places on the hand to where `pose` shows their contacts (place_slider.h), and
  /// sets the open directions; true if one moved or turned.
  bool takePlacesFrom(const hand::HandPose& pose);
  /// The links that a patch on that site may slide on, a flag a link.
  const std::vector<char>& linksOf(const std::string& site);
  /// Patches that an answer misses (failedPatches), then its objective; points that are lost
  /// count as if they were far off. Less is better.
  using Worth = std::pair<std::ptrdiff_t, double>;

  Solution solveAnew(const SolverSettings& solving,
                     const SolveRun& run,
                     const Progress& progress);
  /// The standing pose as what a solve gives, with the minima that it found.
  [[nodiscard]] Solution keptInsteadOf(Solution found, Solution standing) const;
  Solution judgeBy(const SolverSettings& solving, const Progress& progress);
  Solution solveOnce(const SolverSettings& solving,
                     const SolveRun& run,
                     const Progress& progress);
  /// A whole search about the patches as they are laid: open roots and directions are found
  /// anew, and stay as the answer has them. Gives the minima from which it went on.
  std::vector<optimize::Minimum> searchAbout(optimize::SolveReport& report,
                                             const SolverSettings& solving,
                                             optimize::SolveOptions options,
                                             const Progress& progress);
  [[nodiscard]] Worth worthOf(const optimize::SolveReport& report,
                              const SolverSettings& solving) const;
  /// How deep a pose lies inside, m; on the wrong side of a wall, how far it has to go back.
  /// `patches`: those that it answers.
  [[nodiscard]] double depthOf(const optimize::SolveReport& report,
                               const std::vector<SessionPatch>& patches,
                               const Progress& progress) const;
  /// True if the other one is better: `worth` and `report` are its, then.
  static bool takeBetter(const Worth& of_other,
                         optimize::SolveReport& other,
                         Worth& worth,
                         optimize::SolveReport& report);
  /// From where the hand has let go of the object, and from `first`, for one that ended inside.
  void approachAnew(const hand::HandPose& first,
                    optimize::SolveReport& report,
                    const SolverSettings& solving,
                    const optimize::SolveOptions& options,
                    const Progress& progress);
  /// Once more from the same place with the joints at rest: fingers that touch nothing, and
  /// bent ones, may have been caught on their way.
  void beginOpen(optimize::SolveReport& report,
                 const SolverSettings& solving,
                 const optimize::SolveOptions& options,
                 const Progress& progress);
  /// For as long as patches are missed: slides with more weight on those, then with everybody's
  /// own again, and takes what is better.
  void reweightMissedPatches(optimize::SolveReport& report,
                             const SolverSettings& solving,
                             const optimize::SolveOptions& options,
                             const Progress& progress);
  /// Multiplies the weights of some patches by `factor`.
  void weigh(const std::vector<int>& patches, double factor);
  /// Moves open roots along their digits to where they are by length instead of by segment;
  /// true if one moved by more than a face or so.
  bool takeRootsByLength();
  /// Moves open roots of patches of which the segment alone is known round it, by `around_rad`
  /// from the pad; true if any moved.
  bool takeRootsAround(const std::vector<int>& patches, double around_rad);
  /// Turns open directions on the object; true if there are any.
  bool turnDirections(const std::vector<int>& patches, double turn_rad);
  /// A search that ran out of evaluations, from where it stands to its end.
  void goOn(optimize::SolveReport& report,
            const SolverSettings& solving,
            optimize::SolveOptions options,
            const Progress& progress);
  /// Puts the other minima of a search beside the report's, as they are where roots have slid
  /// since; the best of all is the report's pose.
  void keepMinima(const std::vector<optimize::Minimum>& found,
                  optimize::SolveReport& report,
                  const SolverSettings& solving,
                  const optimize::SolveOptions& options,
                  const Progress& progress);
  /// One more solve with the open directions as the report's pose shows them; kept, and true,
  /// if the objective falls.
  bool refineDirections(optimize::SolveReport& report,
                        const SolverSettings& solving,
                        const optimize::SolveOptions& options,
                        const Progress& progress);
  /// Slides the open roots to where the hand would touch best if nothing kept it out: what
  /// pushes it out lets it move little.
  std::vector<optimize::Minimum> slideFreely(SolverSettings solving,
                                             optimize::SolveOptions options,
                                             const Progress& progress);
  /// Solves after each of a few slides of the open roots, until so many in a row gain nothing;
  /// keeps the best of them, or what there was. Points that it loses count as if they were far
  /// off.
  void slideRoots(optimize::SolveReport& report,
                  const SolverSettings& solving,
                  optimize::SolveOptions options,
                  const Progress& progress,
                  int worse_at_most);
  /// Whether any patch may slide on the hand.
  [[nodiscard]] bool slides() const;
  /// Lays drafts as the document asks, and solves on from there; also where there are none, if
  /// the search has been a rough one.
  void layDraftsInFull(optimize::SolveReport& report,
                       bool is_rough,
                       const SolverSettings& solving,
                       optimize::SolveOptions options,
                       const Progress& progress);
  /// Whether what contacts leave open is decided by a posture: until a pose is known.
  [[nodiscard]] bool holdsPosture(const SolverSettings& solving) const;
  void holdPosture(optimize::PoseProblem& problem) const;
  [[nodiscard]] Solution answered(optimize::SolveReport report,
                                  const SolverSettings& solving) const;
  void requirePoints() const;

  std::shared_ptr<ModelCache> cache_;
  Models models_;
  Document document_;
  transfer::Surfaces surfaces_;
  std::vector<SessionPatch> patches_;
  std::vector<SessionPatch> spares_;          ///< as last laid about other roots
  hand::HandPose start_;                      ///< the document's, or one that was found
  std::shared_ptr<const Solution> expected_;  ///< null: `solve` has to search
  std::string expected_for_;                  ///< the document that it answers, as bytes
  std::string found_for_;  ///< what the found directions and start depend on, as bytes
  std::unique_ptr<placement::HandPoseGuesser> placer_;          ///< made when first needed
  std::shared_ptr<const hand::FingerCoordinates> coordinates_;  ///< likewise
  std::shared_ptr<const placement::SkinFaces> skin_faces_;      ///< likewise
  std::map<std::string, std::vector<char>> links_of_;           ///< answers of linksOf
  mutable std::unique_ptr<const placement::Posture> posture_;   ///< likewise
  std::unique_ptr<optimize::NearLists> near_;  ///< of the last solve, for the next one
  bool start_is_known_ = false;
  bool uses_drafts_ = false;  ///< while a search goes on
};

}  // namespace handgraft::session
