#pragma once

#include <cstddef>
#include <vector>

#include "core/base/progress.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

/// Of several ways to lay a document's patches the one that lacks least when it is solved:
/// fewest patches dropped or missed, of as many fewest dropped, then the least objective; of a
/// motion at all of its frames that count.
///
/// By a short search of each, and where none of them reaches all patches by a full one of each,
/// since the short one is no guide then (DECISIONS.md); `until_all`: until one does, in the
/// order that the short ones gave. Deterministic. Errors: Cancelled on
/// wish. Cost: 10 to 20 ms a way, and as much as a solve for each where nothing reaches all.
std::size_t bestWay(const Models& models,
                    const std::vector<Document>& laid,
                    bool until_all,
                    const Progress& progress);

/// The same by full searches alone: where ways differ by what they drop, the short one leaves
/// out what would be reached. A way that cannot lack less than one before it is not looked at.
std::size_t bestSolvedWay(const Models& models,
                          const std::vector<Document>& laid,
                          const Progress& progress);

/// The best of them by short searches alone, best first, `most` at most. To leave ways out that
/// are not worth a full one.
std::vector<std::size_t> likelyWays(const Models& models,
                                    const std::vector<Document>& laid,
                                    std::size_t most,
                                    const Progress& progress);

/// Patches that are laid and that a short search misses.
std::ptrdiff_t missedByShortSearch(const Models& models,
                                   const Document& laid,
                                   const Progress& progress);

}  // namespace handgraft::session
