#pragma once

#include <string>

#include "idl/edits.h"

namespace handgraft::client {

/// A patch's root moved to a place on the skin.
v1::EditBody rootEdit(const std::string& patch, const v1::SurfacePoint& root_S);

/// A patch's direction on the hand turned about the outward normal, counter-clockwise.
v1::EditBody directionEdit(const std::string& patch, double angle_rad);

}  // namespace handgraft::client
