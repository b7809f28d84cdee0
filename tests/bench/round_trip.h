#pragma once

#include <string>
#include <vector>

#include "core/contact/patch.h"
#include "core/hand/skin.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::bench {

/// A patch laid from one surface onto another and back again.
struct RoundTrip {
  std::string from;
  std::string to;
  std::string method;
  int points = 0;  ///< that went both ways
  int lost = 0;    ///< on either way
  double mean_mm = 0.0;
  double max_mm = 0.0;
};

/// Lays `patch` from `object_O` onto the skin, reads what came of it as a patch of the skin,
/// and lays that back onto the object: distances to the points that it started with. Added to
/// `result`.
void goRoundTrip(const geometry::TriangleMesh& object_O,
                 const contact::Patch& patch,
                 const hand::Skin& skin,
                 const transfer::PatchPlacement& placement,
                 geometry::LogMapMethod method,
                 RoundTrip& result);

/// Patches of 5, 10 and 20 mm between a sphere, an ellipsoid and a prism of a hand's or an
/// object's size, of about `vertex_count` vertices each.
std::vector<RoundTrip> smoothRoundTrips(int vertex_count);

}  // namespace handgraft::bench
