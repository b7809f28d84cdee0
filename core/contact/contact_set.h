#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/contact/patch.h"
#include "core/hand/digits.h"

namespace handgraft::contact {

// Bounds of memory: what a file or a map asks for must not grow without end.
inline constexpr std::size_t kMostPatches = 1000;
inline constexpr std::size_t kMostPoints = 100'000;  ///< interpolation points of all patches
inline constexpr std::size_t kMostParts = 1000;      ///< of a posture

/// Which way a part of the hand that touched was turned, in O: what its contacts leave open.
struct PartDirection {
  std::string part;  ///< a segment (`index_proximal`, hand::placeNamed) or `palm`
  Eigen::Vector3d outward_O = Eigen::Vector3d::Zero();  ///< unit, away from the wrist
  /// Unit, at right angles to it: where the part closes to. Zero where nobody knows.
  Eigen::Vector3d palmar_O = Eigen::Vector3d::Zero();
};

/// The patches of one grasp on one object.
struct ContactSet {
  std::string name;
  /// What the object is called; empty when the file does not say.
  std::string object;
  std::vector<Patch> patches;
  /// Which hand touched, where its maker says.
  hand::Chirality side = hand::Chirality::kUnknown;
  /// The posture of the hand that touched, touching or not; empty where nobody knows.
  std::vector<PartDirection> posture;
  /// Remarks of whoever made it ("dropped 2 specks below 30 mm2"), shown to the user.
  std::vector<std::string> notes;
};

}  // namespace handgraft::contact
