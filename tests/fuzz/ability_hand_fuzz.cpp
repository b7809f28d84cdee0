// Bytes as they come from an Ability Hand, and as they come to it: through stuffing, checksum
// and decoders, however split, and as the answers to the driver. The first byte says which, and
// whether checksums are made right.

#include <cmath>
#include <cstdint>
#include <vector>

#include "hardware/devices/ability_hand_device.h"

#include "tests/fuzz/wire_promises.h"

namespace {

using namespace handgraft::protocols;  // NOLINT(google-build-using-namespace): all of it
using namespace handgraft::fuzz;       // NOLINT(google-build-using-namespace): all of it
namespace devices = handgraft::devices;

void useContent(Bytes content) {
  ByteBuffer wire;
  ability_hand::encodeFrame(content, wire);
  checkFrame<ability_hand::Framing>(wire.bytes(), content);
  if (const auto state = ability_hand::stateOf(content)) {
    ability_hand::encodeState(*state, wire);
    checkFrame<ability_hand::Framing>(wire.bytes(), content);
    for (const std::uint16_t reading : state->touch) {
      HANDGRAFT_PROMISE(reading < 0x1000);
      HANDGRAFT_PROMISE(std::isfinite(ability_hand::touchForce(reading)));
    }
  }
  const auto command = ability_hand::commandOf(content);
  if (!command || !command->counts || command->reply() > ability_hand::Reply::kMotors) return;
  for (const std::int16_t count : *command->counts) {
    if (count < -ability_hand::kLargestCount) return;  // nothing of ours says that
  }
  ability_hand::encodeCommand(command->address, command->mode(), command->reply(),
                              *command->counts, wire);
  checkFrame<ability_hand::Framing>(wire.bytes(), content);
}

/// Contents of any length; or, so that answers are not rare, padded to that of a reply.
void makeFrame(Bytes content, ByteBuffer& wire) {
  std::vector<std::uint8_t> bytes(content.begin(), content.end());
  if (!bytes.empty() && bytes[0] % 4 != 3) {
    const auto variant = static_cast<std::uint8_t>(bytes[0] % 4);
    bytes[0] = static_cast<std::uint8_t>(0x10 + variant);
    bytes.resize(variant == 2 ? 38 : 71);
  }
  ability_hand::encodeFrame(bytes, wire);
}

void driveHand(Bytes bytes, std::size_t step) {
  Answers answers(bytes, step);
  devices::AbilityHandDevice hand({}, answers, answers.clock());
  drive(hand);
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  Bytes bytes(data + 2, size - 2);
  const std::size_t step = 1 + data[1];
  std::vector<std::uint8_t> wires;
  if (data[0] % 4 >= 2) bytes = wires = framed(bytes, makeFrame);
  if (data[0] % 2 == 0) checkStream<ability_hand::Framing>(bytes, step, useContent);
  if (data[0] % 2 == 1) driveHand(bytes, step);
  return 0;
}
