#pragma once

#include <array>

#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// A number that a joint has besides its place and its axis. Whatever reads, writes, sends,
/// checks or scales joints goes through kJointNumbers: a new number is a member of Joint and a
/// row below, and a field of JointInfo (idl/models.idl) for clients to see it. Packed hands
/// (server/reading) hold these numbers in this order and are kept on disk: with a new one the
/// form that a store reads rises (server/store/model_recipe.h).
struct JointNumber {
  const char* name;  ///< of the field of JointInfo as well: "velocity_limit"
  double Joint::*value;
  /// Where a URDF has it, <limit velocity="...">; null of the range, which has rules of its
  /// own. What stands there is finite and not negative.
  const char* urdf_element;
  const char* urdf_attribute;
  bool scales_with_slider;  ///< of a slider it is a length, or one per time
};

inline constexpr std::array kJointNumbers = {
    JointNumber{"lower", &Joint::lower, nullptr, nullptr, true},
    JointNumber{"upper", &Joint::upper, nullptr, nullptr, true},
    JointNumber{"velocity_limit", &Joint::velocity_limit, "limit", "velocity", true},
};

}  // namespace handgraft::hand
