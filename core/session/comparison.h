#pragma once

#include <string>
#include <vector>

#include "core/session/derived_state.h"
#include "core/session/document.h"

namespace handgraft::session {

/// One thing in which two documents differ.
struct Difference {
  std::string what;  ///< "joint thumb_mcp", "patch index mean", "objective"
  std::string a;     ///< with its unit
  std::string b;
  double change = 0.0;  ///< b - a in that unit; NaN if they are no numbers
};

/// Where two documents differ, of those things that people look at: models, the object's and
/// the hand's pose, joints, limits, locks, patches, weights, and how well each patch fits.
///
/// `fit_a`, `fit_b` are judged for them; null leaves fits out. Rows: models first, then the
/// objective and the patches' fits, then poses, joints and settings; what is alike is left out.
std::vector<Difference> differencesBetween(const Document& a,
                                           const Document& b,
                                           const std::vector<std::string>& joints_a,
                                           const std::vector<std::string>& joints_b,
                                           const optimize::SolveReport* fit_a,
                                           const optimize::SolveReport* fit_b);

}  // namespace handgraft::session
