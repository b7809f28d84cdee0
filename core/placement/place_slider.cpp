#include "core/placement/place_slider.h"

#include <cmath>
#include <numbers>

#include "core/placement/open_directions.h"

namespace handgraft::placement {

namespace {

constexpr double kSamePlace = 0.001;  // m
constexpr double kSameTurn = 5.0 * std::numbers::pi / 180.0;

// Of a contact on the hand from the finger's bone.
constexpr double kMostTurn = std::numbers::pi / 4.0;

}  // namespace

std::optional<transfer::PatchPlacement> slidPlace(const SkinFaces& faces,
                                                  const hand::FingerCoordinates& coordinates,
                                                  const hand::LinkPoses& X_SW,
                                                  const std::vector<char>& permitted,
                                                  const ContactAt& contact,
                                                  const transfer::PatchPlacement& placement) {
  const geometry::TriangleMesh& skin_S = faces.skin().mesh();
  transfer::PatchPlacement slid = placement;
  bool any = false;
  const auto root_S = rootShownBy(faces, X_SW, permitted, contact.p_W, contact.n_W);
  if (root_S && (positionOf(skin_S, *root_S) - positionOf(skin_S, placement.root_S)).norm() >=
                    kSamePlace) {
    slid = movedTo(skin_S, placement, *root_S);
    any = true;
  }
  const auto bone_S = contact.d_W ? coordinates.towardsWrist(slid.root_S) : std::nullopt;
  const auto direction_S = bone_S ? skinDirectionShownBy(faces.skin(), X_SW, slid.root_S,
                                                         *bone_S, *contact.d_W, kMostTurn)
                                  : std::nullopt;
  if (direction_S && direction_S->dot(slid.direction_S) <= std::cos(kSameTurn)) {
    slid.direction_S = *direction_S;
    any = true;
  }
  if (!any) return std::nullopt;
  return slid;
}

}  // namespace handgraft::placement
