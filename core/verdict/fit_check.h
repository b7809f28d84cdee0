#pragma once

#include <memory>
#include <vector>

#include "core/geometry/surface_locator.h"
#include "core/optimize/reach.h"
#include "core/quality/clearance.h"
#include "core/session/session.h"

namespace handgraft::verdict {

/// A patch whose finger is too thick for the place.
struct MissingClearance {
  int patch = -1;
  double missing_m = 0.0;  ///< by which it would have to enter the object
};

/// Why no pose can bring a hand's places onto an object's patches: known before any search.
struct FitFindings {
  std::vector<MissingClearance> clearances;
  std::vector<optimize::SpanMisfit> spans;

  /// Some finger is too thick, or two patches lie closer than the hand can bring its places.
  [[nodiscard]] bool tooLarge() const;
  /// Two patches lie farther apart than the hand can spread its places.
  [[nodiscard]] bool tooSmall() const;
};

/// Checks sizes; remembers what it found until what that rests on changes. One a session.
///
/// Frames: all that is compared is fixed to the object or the hand, so that moving the object
/// changes nothing.
class FitCheck {
 public:
  FitCheck();
  ~FitCheck();
  FitCheck(FitCheck&&) noexcept;
  FitCheck& operator=(FitCheck&&) noexcept;

  /// Of the session's patches as they are laid (transfer first) and of its limits. Roots that
  /// were found, not chosen, slide while solving: spans between those are not told.
  /// Cost: 10-50 ms anew, of which 10 us a patch and 0.1 ms a pair where there is nothing to
  /// tell; some us while nothing changes.
  /// `answer`, a solved pose, saves the proof for spans where it reaches all patches.
  const FitFindings& of(const session::Session& session,
                        const optimize::PoseProblem& problem,
                        const optimize::SolveReport* answer = nullptr);

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace handgraft::verdict
