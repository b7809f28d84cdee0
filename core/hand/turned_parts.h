#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/anatomy.h"

namespace handgraft::hand {

/// A part of a hand as contacts name it (hand_location.h), and how it is turned.
struct TurnedPart {
  std::string name;                                     ///< partName, or kPalmPart
  int link = 0;                                         ///< that it moves with
  Eigen::Vector3d outward_S = Eigen::Vector3d::Zero();  ///< unit, along the bone
  Eigen::Vector3d palmar_S = Eigen::Vector3d::Zero();   ///< unit
};

/// Each segment, and the palm where there is one.
std::vector<TurnedPart> turnedParts(const Anatomy& anatomy);

}  // namespace handgraft::hand
