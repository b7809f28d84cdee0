#pragma once

#include <string>

#include "idl/models.h"
#include "idl/sessions.h"

/// The places where a solve's searches ended, best first.
namespace handgraft::client {

/// How far one of them lies from the best one.
struct PoseGap {
  double moved_mm = 0.0;    ///< of the root
  double turned_deg = 0.0;  ///< of the root
  double joint = 0.0;       ///< largest change: degrees, or mm where a joint slides
};

/// Errors: InvalidInput for a pose from the server that is none.
PoseGap gapBetween(const v1::MinimumInfo& a,
                   const v1::MinimumInfo& b,
                   const v1::HandDescription& hand);

namespace text {

/// A row each, from rank 1; the one that was chosen is marked. Empty if there is none.
std::string minima(const v1::PoseSolution& solution, const v1::HandDescription& hand);

}  // namespace text

}  // namespace handgraft::client
