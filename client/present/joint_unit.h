#pragma once

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

}  // namespace handgraft::client
