// Bytes as they come over a wire: through each framing and decoder, however split; and as the
// answers of a device to its driver. The first byte says which.

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "hardware/devices/ability_hand_device.h"
#include "hardware/devices/dynamixel_hand.h"
#include "hardware/devices/odrive_hand.h"
#include "hardware/devices/slcan_channel.h"

namespace {

/// Ends the process by an exception that nobody catches, so that libFuzzer keeps the input.
void promise(bool is_kept, const char* what) {
  if (!is_kept) throw handgraft::BrokenContract(what);
}

using namespace handgraft::protocols;  // NOLINT(google-build-using-namespace): all of it
namespace devices = handgraft::devices;

/// Feeds `bytes` in pieces of `step`, and then nothing more.
template <class F, class Use>
void feed(Bytes bytes, std::size_t step, Use use) {
  StreamReader<F> reader;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    reader.feed(bytes.subspan(at, std::min(step, bytes.size() - at)), use);
    promise(reader.pending() < F::kLongest, "memory is bounded");
  }
  reader.settle(use);
  promise(reader.pending() == 0, "nothing is left");
}

/// `wire` is one frame, and its content is `content`.
template <class F>
void expectFrame(Bytes wire, Bytes content) {
  StreamReader<F> reader;
  int count = 0;
  reader.feed(wire, [&](Bytes found) {
    ++count;
    promise(std::equal(found.begin(), found.end(), content.begin(), content.end()),
            "what is written is read back");
  });
  promise(count == 1, "what is written is one frame");
}

void useDynamixel(Bytes frame) {
  const dynamixel::Packet packet = dynamixel::packetOf(frame);
  ByteBuffer wire;
  dynamixel::encode(packet, wire);
  expectFrame<dynamixel::Framing>(wire.bytes(), frame);
  if (const auto status = dynamixel::statusOf(packet)) {
    dynamixel::encodeStatus(*status, wire);
    expectFrame<dynamixel::Framing>(wire.bytes(), frame);
  }
}

void useAbilityHand(Bytes content) {
  ByteBuffer wire;
  ability_hand::encodeFrame(content, wire);
  expectFrame<ability_hand::Framing>(wire.bytes(), content);
  static_cast<void>(ability_hand::commandOf(content));
  if (const auto state = ability_hand::stateOf(content)) {
    ability_hand::encodeState(*state, wire);
    expectFrame<ability_hand::Framing>(wire.bytes(), content);
  }
}

void useSlcan(Bytes content) {
  const slcan::Line line = slcan::lineOf(content);
  if (line.kind != slcan::Line::Kind::kFrame) return;
  ByteBuffer again;
  slcan::encode(line.frame, again);
  promise(slcan::lineOf(again.bytes()).frame == line.frame, "a CAN frame is read back");
  static_cast<void>(odrive::heartbeatOf(line.frame));
  static_cast<void>(odrive::encoderEstimatesOf(line.frame));
  static_cast<void>(odrive::inputPositionOf(line.frame));
  static_cast<void>(odrive::errorReportOf(line.frame));
}

/// A wire on which everything that is asked is answered by the next few bytes.
class Answers final : public devices::ByteChannel {
 public:
  Answers(Bytes bytes, std::size_t step) : bytes_(bytes), step_(step) {}

  void open() override {}

  void close() override {}

  void send(Bytes) override {}

  void discard() override {}

  std::size_t receive(std::span<std::uint8_t> into, devices::TimePoint deadline) override {
    // Now and then nothing comes in time.
    const std::size_t count = std::min({step_, bytes_.size(), into.size()});
    if (count == 0 || ++calls_ % 5 == 0) {
      now_ = std::max(now_, deadline) + std::chrono::microseconds(1);
      return 0;
    }
    std::copy_n(bytes_.begin(), count, into.begin());
    bytes_ = bytes_.subspan(count);
    now_ += std::chrono::microseconds(10);
    return count;
  }

  devices::Clock clock() {
    return [this] {
      return now_;
    };
  }

 private:
  Bytes bytes_;
  std::size_t step_;
  unsigned calls_ = 0;
  devices::TimePoint now_{std::chrono::seconds(1)};
};

/// Frames whose checksums are right and whose contents are pieces of `bytes`: chance alone
/// would hardly make one.
template <class Frame>
std::vector<std::uint8_t> framed(Bytes bytes, Frame frame) {
  std::vector<std::uint8_t> wires;
  while (!bytes.empty()) {
    const std::size_t count = std::min<std::size_t>(bytes[0] % 80, bytes.size() - 1);
    ByteBuffer wire;
    frame(bytes.subspan(1, count), wire);
    wires.insert(wires.end(), wire.bytes().begin(), wire.bytes().end());
    bytes = bytes.subspan(1 + count);
  }
  return wires;
}

std::vector<std::uint8_t> framedFor(int device, Bytes bytes) {
  if (device == 0) {
    return framed(bytes, [](Bytes content, ByteBuffer& wire) {
      const std::uint8_t id = content.empty() ? 1 : content[0] % 4;
      dynamixel::encode({id, 0x55, content}, wire);
    });
  }
  if (device == 1) return framed(bytes, ability_hand::encodeFrame);
  return framed(bytes, [](Bytes content, ByteBuffer& wire) {
    const std::uint32_t id = content.empty() ? 1 : content[0] % 0x40U;
    slcan::encode(makeCanFrame(id, content.first(std::min<std::size_t>(content.size(), 8))),
                  wire);
  });
}

void drive(devices::Device& device) {
  devices::DeviceState state(device.motorCount());
  const std::vector<double> targets(device.motorCount(), 0.1);
  try {
    device.open();
    device.arm();
    for (int i = 0; i < 20; ++i) {
      if (!device.read(state) || !device.write(targets)) device.reset();
    }
  } catch (const handgraft::DeviceError&) {
  } catch (const handgraft::TransportError&) {
  }
  device.stop();
  promise(!device.isArmed(), "a stop disarms");
}

/// A driver, and what its device answers.
void driveDevice(int device, Bytes bytes, std::size_t step) {
  const devices::MotorScale scale{0.01, 0.0, 1, -1.0, 1.0};
  Answers answers(bytes, step);
  if (device == 0) {
    devices::DynamixelConfig config;
    config.motors.resize(2);
    config.motors[0].scale = config.motors[1].scale = scale;
    config.motors[1].id = 2;
    devices::DynamixelHand hand(config, answers, answers.clock());
    drive(hand);
  } else if (device == 1) {
    devices::AbilityHandDevice hand({}, answers, answers.clock());
    drive(hand);
  } else {
    devices::SlcanChannel can(answers, 500000, answers.clock());
    devices::ODriveConfig config;
    config.axes.resize(1);
    config.axes[0].scale = scale;
    devices::ODriveHand hand(config, can, answers.clock());
    drive(hand);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const Bytes bytes(data + 2, size - 2);
  const std::size_t step = 1 + data[1];
  const int what = data[0] % 9;
  if (what == 0) feed<dynamixel::Framing>(bytes, step, useDynamixel);
  if (what == 1) feed<ability_hand::Framing>(bytes, step, useAbilityHand);
  if (what == 2) feed<slcan::Framing>(bytes, step, useSlcan);
  if (what >= 3 && what < 6) driveDevice(what - 3, bytes, step);
  if (what >= 6) driveDevice(what - 6, framedFor(what - 6, bytes), step);
  return 0;
}
