// Bytes as they come from a Dynamixel bus: through framing and decoders, however split, and as
// the answers to the driver. The first byte says which, and whether checksums are made right.

#include <cstdint>
#include <vector>

#include "hardware/devices/dynamixel_hand.h"

#include "tests/fuzz/wire_promises.h"
#include "tests/hardware/emulators/dynamixel_emulator.h"

namespace {

using namespace handgraft::protocols;  // NOLINT(google-build-using-namespace): all of it
using namespace handgraft::fuzz;       // NOLINT(google-build-using-namespace): all of it
namespace devices = handgraft::devices;

void usePacket(Bytes frame) {
  const dynamixel::Packet packet = dynamixel::packetOf(frame);
  ByteBuffer wire;
  dynamixel::encode(packet, wire);
  checkFrame<dynamixel::Framing>(wire.bytes(), frame);
  if (const auto status = dynamixel::statusOf(packet)) {
    dynamixel::encodeStatus(*status, wire);
    checkFrame<dynamixel::Framing>(wire.bytes(), frame);
  }
}

void makePacket(Bytes content, ByteBuffer& wire) {
  if (content.size() < 2) return dynamixel::encodePing(1, wire);
  // Mostly answers of the motors that there are: others would be passed over.
  const bool is_answer = content[1] < 0xC0;
  const auto id = static_cast<std::uint8_t>(is_answer ? content[0] % 4 : content[0] % 0xFD);
  dynamixel::encode({id, is_answer ? std::uint8_t{0x55} : content[1], content.subspan(2)},
                    wire);
}

/// An answer of register contents, as a cycle asks for them.
void makeBlock(Bytes content, ByteBuffer& wire) {
  std::vector<std::uint8_t> bytes(content.begin(), content.end());
  if (bytes.empty() || bytes[0] % 8 == 7) return makePacket(content, wire);
  const auto id = static_cast<std::uint8_t>(1 + bytes[0] % 2);
  bytes.resize(15);
  bytes[0] = bytes[0] < 0xC0 ? 0 : bytes[0];  // mostly no error
  dynamixel::encode({id, 0x55, bytes}, wire);
}

devices::DynamixelConfig twoMotors() {
  devices::DynamixelConfig config;
  config.motors.resize(2);
  config.motors[0].scale = config.motors[1].scale = {0.01, 0.0, 1, -1.0, 1.0};
  config.motors[0].id = 1;
  config.motors[1].id = 2;
  return config;
}

void failUnderPower(Bytes bytes, std::size_t step) {
  handgraft::test::DynamixelEmulator emulator({1, 2});
  FailingWire wire(emulator, bytes, step);
  devices::DynamixelHand hand(twoMotors(), wire, wire.clock());
  drive(hand, &wire.is_failing);
}

void driveHand(Bytes bytes, std::size_t step) {
  Answers answers(bytes, step);
  devices::DynamixelHand hand(twoMotors(), answers, answers.clock());
  drive(hand);
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  Bytes bytes(data + 2, size - 2);
  const std::size_t step = 1 + data[1];
  std::vector<std::uint8_t> wires;
  const int what = data[0] % 6;
  if (what == 2 || what == 3) bytes = wires = framed(bytes, makePacket);
  if (what == 4) bytes = wires = framed(bytes, makeBlock);
  if (what == 0 || what == 2) checkStream<dynamixel::Framing>(bytes, step, usePacket);
  if (what == 1 || what == 3) driveHand(bytes, step);
  if (what == 4 || what == 5) failUnderPower(bytes, step);
  return 0;
}
