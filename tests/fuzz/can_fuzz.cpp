// CAN frames as they come from a text adapter on a tty or from the kernel, through ODrive's
// and the Allegro Hand's decoders; and as the answers to their drivers. The first byte says
// which.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "hardware/devices/allegro_hand.h"
#include "hardware/devices/odrive_hand.h"
#include "hardware/devices/slcan_channel.h"
#include "hardware/protocols/slcan.h"
#include "hardware/protocols/socket_can_frame.h"

#include "tests/fuzz/byte_reader.h"
#include "tests/fuzz/wire_promises.h"
#include "tests/hardware/emulators/odrive_emulator.h"

namespace {

using namespace handgraft::protocols;  // NOLINT(google-build-using-namespace): all of it
using namespace handgraft::fuzz;       // NOLINT(google-build-using-namespace): all of it
namespace devices = handgraft::devices;

bool isSame(const odrive::FloatPair& a, const odrive::FloatPair& b) {
  // Bit for bit: a NaN has to come through as well.
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

void checkPair(const CanFrame& frame,
               odrive::Command command,
               std::optional<odrive::FloatPair> (*decode)(const CanFrame&)) {
  if (const auto pair = decode(frame)) {
    const auto again = decode(odrive::makeFloatPair(5, command, *pair));
    HANDGRAFT_PROMISE(again && isSame(*again, *pair));
  }
}

void useFrame(const CanFrame& frame) {
  HANDGRAFT_PROMISE(frame.size <= 8 && frame.bytes().size() <= 8);
  for (std::size_t i = frame.bytes().size(); i < 8; ++i)
    HANDGRAFT_PROMISE(frame.data[i] == 0);

  if (const auto address = odrive::addressOf(frame)) {
    HANDGRAFT_PROMISE(address->node >= 0 && address->node <= odrive::kHighestNode);
    const auto command = static_cast<odrive::Command>(address->command);
    HANDGRAFT_PROMISE(odrive::idOf(address->node, command) == frame.id);
  }
  for (const auto firmware : {odrive::Firmware::k05, odrive::Firmware::k06}) {
    if (const auto heartbeat = odrive::heartbeatOf(frame, firmware)) {
      HANDGRAFT_PROMISE(odrive::heartbeatOf(odrive::makeHeartbeat(5, *heartbeat, firmware),
                                            firmware) == heartbeat);
    }
  }
  checkPair(frame, odrive::Command::kGetEncoderEstimates, odrive::encoderEstimatesOf);
  checkPair(frame, odrive::Command::kGetIq, odrive::iqOf);
  checkPair(frame, odrive::Command::kGetTemperature, odrive::temperatureOf);
  checkPair(frame, odrive::Command::kSetLimits, odrive::limitsOf);
  if (const auto report = odrive::errorReportOf(frame)) {
    const auto again = odrive::errorReportOf(odrive::makeErrorReport(5, *report));
    HANDGRAFT_PROMISE(again && again->active == report->active &&
                      again->disarm_reason == report->disarm_reason);
  }
  if (const auto pose = allegro::poseOf(frame)) {
    const auto again = allegro::poseOf(allegro::makePose(pose->finger, pose->numbers));
    HANDGRAFT_PROMISE(again && again->finger == pose->finger &&
                      again->numbers == pose->numbers);
  }
  if (const auto torque = allegro::torqueOf(frame)) {
    const auto again = allegro::torqueOf(allegro::setTorque(torque->finger, torque->numbers));
    HANDGRAFT_PROMISE(again && again->numbers == torque->numbers);
  }
  static_cast<void>(allegro::temperatureOf(frame));
  static_cast<void>(odrive::axisStateOf(frame));
  static_cast<void>(odrive::controllerModeOf(frame));
  if (const auto goal = odrive::inputPositionOf(frame);
      goal && std::isfinite(goal->position_rev)) {
    const CanFrame again =
        odrive::setInputPosition(5, goal->position_rev, goal->velocity_rev_s, goal->torque_Nm);
    HANDGRAFT_PROMISE(std::memcmp(again.data.data(), frame.data.data(), 4) == 0);
  }
}

void useLine(Bytes content) {
  const slcan::Line line = slcan::lineOf(content);
  if (line.kind != slcan::Line::Kind::kFrame) return;
  ByteBuffer again;
  slcan::encode(line.frame, again);
  HANDGRAFT_PROMISE(slcan::lineOf(again.bytes()).frame == line.frame);
  useFrame(line.frame);
}

void useKernelFrames(Bytes bytes) {
  ByteReader reader(bytes.data(), bytes.size());
  while (reader.left() > 0) {
    const auto raw = reader.take<struct can_frame>();
    const SocketCanMessage message = fromSocketCan(raw);
    if (message.is_error) continue;
    HANDGRAFT_PROMISE(fromSocketCan(toSocketCan(message.frame)).frame == message.frame);
    useFrame(message.frame);
  }
}

/// A message of an axis, with its command from the first byte and what follows as its content.
CanFrame frameOf(Bytes content) {
  if (content.empty()) return odrive::setAxisState(0, odrive::AxisState::kIdle);
  // Mostly of the only axis there is.
  const std::uint32_t node = content[0] < 0xC0 ? 0 : content[0] % 0x40U;
  const std::uint32_t command = content[0] % 0x20U;
  const Bytes rest = content.subspan(1);
  return makeCanFrame(node << 5 | command, rest.first(std::min<std::size_t>(rest.size(), 8)));
}

void makeLine(Bytes content, ByteBuffer& wire) {
  slcan::encode(frameOf(content), wire);
}

/// What a finger tells: its pose, or its temperatures.
void makeFingerLine(Bytes content, ByteBuffer& wire) {
  if (content.empty()) return;
  const std::size_t finger = content[0] % allegro::kFingerCount;
  const auto command =
      content[0] < 0xC0 ? allegro::Command::kFingerPose : allegro::Command::kTemperature;
  const Bytes rest = content.subspan(1);
  slcan::encode(makeCanFrame(allegro::idOf(command, finger),
                             rest.first(std::min<std::size_t>(rest.size(), 8))),
                wire);
}

devices::ODriveConfig oneAxis() {
  devices::ODriveConfig config;
  config.axes.resize(1);
  config.axes[0].scale = {0.01, 0.0, 1, -1.0, 1.0};
  return config;
}

void driveHand(Bytes bytes, std::size_t step) {
  Answers answers(bytes, step);
  devices::SlcanChannel can(answers, 500000, answers.clock());
  devices::ODriveHand hand(oneAxis(), can, answers.clock());
  drive(hand);
}

void driveAllegro(Bytes bytes, std::size_t step) {
  Answers answers(bytes, step);
  devices::SlcanChannel can(answers, 1000000, answers.clock());
  devices::AllegroConfig config;
  config.scales.fill({allegro::kRadPerCount, 0, 1, -1, 1});
  devices::AllegroHand hand(config, can, answers.clock());
  drive(hand);
}

void failUnderPower(Bytes bytes, std::size_t step) {
  handgraft::test::ODriveEmulator bus({0}, odrive::Firmware::k06);
  handgraft::test::SlcanEmulator adapter(bus);
  FailingWire wire(adapter, bytes, step);
  devices::SlcanChannel can(wire, 500000, wire.clock());
  devices::ODriveHand hand(oneAxis(), can, wire.clock());
  drive(hand, &wire.is_failing);
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  Bytes bytes(data + 2, size - 2);
  const std::size_t step = 1 + data[1];
  const int what = data[0] % 8;
  std::vector<std::uint8_t> wires;
  if (what == 2 || what == 3 || what == 6) bytes = wires = framed(bytes, makeLine);
  if (what == 0 || what == 2) checkStream<slcan::Framing>(bytes, step, useLine);
  if (what == 1 || what == 3) driveHand(bytes, step);
  if (what == 1) driveAllegro(bytes, step);
  if (what == 3) driveAllegro(framed({data + 2, size - 2}, makeFingerLine), step);
  if (what == 4) useKernelFrames(bytes);
  if (what == 5) useFrame(frameOf(bytes));
  if (what == 6 || what == 7) failUnderPower(bytes, step);
  return 0;
}
