#pragma once

#include <algorithm>
#include <numbers>

#include "idl/models.h"

namespace handgraft::client {

/// In what people are told a joint's values; messages and files have rad and m.
struct JointUnit {
  double scale = 1.0;  ///< times a message's value
  const char* name = "";
};

inline JointUnit unitOf(v1::JointKind kind) {
  return kind == v1::JOINT_PRISMATIC ? JointUnit{1e3, "mm"}
                                     : JointUnit{180.0 / std::numbers::pi, "deg"};
}

/// Of the largest number of all joints, where it is not said which joint's that is.
inline JointUnit unitOfLargest(const v1::HandDescription& hand) {
  const bool slides =
      std::any_of(hand.joints().begin(), hand.joints().end(), [](const v1::JointInfo& joint) {
        return joint.kind() == v1::JOINT_PRISMATIC;
      });
  return slides ? JointUnit{1.0, "rad or m"} : unitOf(v1::JOINT_REVOLUTE);
}

}  // namespace handgraft::client
