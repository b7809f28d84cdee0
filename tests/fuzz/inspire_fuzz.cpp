// Bytes as they come from an Inspire hand by Modbus RTU, and as they come to it; and as the
// answers to its driver. The first byte says which, and whether CRCs are made right.

#include <cmath>
#include <cstdint>
#include <vector>

#include "hardware/devices/inspire_hand.h"

#include "tests/fuzz/wire_promises.h"

namespace {

using namespace handgraft::protocols;  // NOLINT(google-build-using-namespace): all of it
using namespace handgraft::fuzz;       // NOLINT(google-build-using-namespace): all of it
namespace devices = handgraft::devices;

void useContent(Bytes content) {
  ByteBuffer wire;
  const auto reply = modbus::replyOf(content);
  if (!reply || reply->function != modbus::kReadRegisters || reply->values.empty()) return;
  std::vector<std::uint16_t> values;
  for (std::size_t i = 0; 2 * i < reply->values.size(); ++i)
    values.push_back(modbus::registerAt(reply->values, i));
  if (values.size() > modbus::kMostRegisters) return;
  modbus::encodeReadReply(reply->device, values, wire);
  checkFrame<modbus::ReplyFraming>(wire.bytes(), content);
}

/// A reply to a read of six or three registers, with a CRC that is right.
void makeFrame(Bytes content, ByteBuffer& wire) {
  std::vector<std::uint16_t> values(content.size() % 2 == 0 ? 6 : 3);
  for (std::size_t i = 0; i < values.size() && 2 * i + 1 < content.size(); ++i)
    values[i] = static_cast<std::uint16_t>(content[2 * i] << 8 | content[2 * i + 1]);
  modbus::encodeReadReply(1, values, wire);
}

void driveHand(Bytes bytes, std::size_t step) {
  Answers answers(bytes, step);
  devices::InspireConfig config;
  config.scales.fill({1e-3, 1000, -1, 0, 1});
  devices::InspireHand hand(config, answers, answers.clock());
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
  if (data[0] % 2 == 0) checkStream<modbus::ReplyFraming>(bytes, step, useContent);
  if (data[0] % 2 == 1) driveHand(bytes, step);
  return 0;
}
