#pragma once

#include "core/io/motion_plan.h"
#include "server/reading/byte_stream.h"

/// What a hand did, as bytes and back, as packed_parts.h has the parts of models.
namespace handgraft::server {

void put(ByteWriter& out, const io::HandTrajectoryPlan& plan);

/// Errors: InvalidInput.
io::HandTrajectoryPlan takeHandTrajectoryPlan(ByteReader& in);

}  // namespace handgraft::server
