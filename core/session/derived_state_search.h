#pragma once

#include <vector>

#include "core/optimize/solver.h"
#include "core/session/derived_state.h"

/// What a search and its further beginnings share; of nobody else's business.
namespace handgraft::session {

inline constexpr int kWorseSlides = 3;  ///< in a row

/// Small steps from a pose that is out of the object stay where they are out of it.
optimize::SolveOptions stepOf(optimize::SolveOptions options);

/// The objective; a point that is lost no longer counts, and that alone makes nothing better.
double costOf(const optimize::PoseProblem& posed, const optimize::SolveReport& solved);

/// Deep inside the object, or through a wall of it.
bool isInside(const optimize::SolveReport& solved);

/// Brings the patches and the start back to what the document says, unless told to keep them.
struct DerivedState::Search {
  explicit Search(DerivedState& owner)
      : derived(owner),
        patches(owner.patches_),
        start(owner.start_),
        start_is_known(owner.start_is_known_) {}

  ~Search() {
    derived.patches_ = std::move(patches);
    derived.start_ = std::move(start);
    derived.start_is_known_ = start_is_known;
  }

  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  /// As it stands from now on.
  void keep() {
    patches = derived.patches_;
    start = derived.start_;
    start_is_known = derived.start_is_known_;
  }

  DerivedState& derived;
  std::vector<SessionPatch> patches;
  hand::HandPose start;
  bool start_is_known;
};

}  // namespace handgraft::session
