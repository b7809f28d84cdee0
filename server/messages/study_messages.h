#pragma once

#include <string>

#include "core/hand/variant.h"
#include "core/sweep/sweep.h"
#include "idl/studies.h"

/// Variants and sweeps, from messages to core types and back; as convert.h, and checked as
/// there.
namespace handgraft::server {

// === From the wire

hand::HandProperty propertyFrom(v1::HandProperty property);
hand::HandChange changeFrom(const v1::HandChange& change);
sweep::SweepAxis axisFrom(const v1::SweepAxis& axis);

// === To the wire

v1::SweepRow toMessage(const sweep::SweepRow& row);

/// Of a motion: what it says of one of its patches; without one, of all of them.
v1::SweepRow toMessage(const sweep::SweepRow& row, const std::string& patch);

}  // namespace handgraft::server
