#pragma once

#include <vector>

#include "core/optimize/local_search.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

/// Adds the ends of one solver's searches, entry i from start i, to `minima`: those that are
/// the same pose count as one, sorted by objective, the best `kMostMinima` kept. Searches left
/// before their end are none, unless they are better than all that ended.
void rankMinima(const hand::HandModel& model,
                const std::vector<LocalResult>& results,
                const std::string& solver,
                std::vector<Minimum>& minima);

inline constexpr std::size_t kMostMinima = 8;

/// Poses that nobody would tell apart: objectives within 0.1 %, the root within 1 mm and 0.02
/// rad, joints within 0.02 rad (1 mm where they slide).
bool isSameMinimum(const hand::HandModel& model, const Minimum& a, const Minimum& b);

}  // namespace handgraft::optimize
