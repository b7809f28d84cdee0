#pragma once

#include <memory>

#include "tests/hardware/emulators/rig.h"

/// What rig.cpp and can_rigs.cpp share.
namespace handgraft::test {

inline std::unique_ptr<Wire> makeWire(WireKind kind,
                                      EmulatedDevice& device,
                                      int bits_per_second) {
  return kind == WireKind::kVirtual ? makeVirtualWire(device)
                                    : makePty(device, bits_per_second);
}

/// In real time, on a machine with other things to do, answers may take long.
inline Duration replyTimeout(WireKind kind) {
  return std::chrono::milliseconds(kind == WireKind::kVirtual ? 5 : 200);
}

std::unique_ptr<Rig> makeODriveRig(WireKind wire, protocols::odrive::Firmware firmware);
std::unique_ptr<Rig> makeAllegroRig(WireKind wire);

}  // namespace handgraft::test
