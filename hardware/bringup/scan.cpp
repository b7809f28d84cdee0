#include "hardware/bringup/scan.h"

#include <array>
#include <chrono>
#include <set>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/devices/serial_port.h"
#include "hardware/devices/slcan_channel.h"
#include "hardware/protocols/ability_hand.h"
#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/dynamixel_table.h"
#include "hardware/protocols/odrive_can.h"

namespace handgraft::bringup {

namespace {

namespace ah = protocols::ability_hand;
namespace dxl = protocols::dynamixel;
namespace odrive = protocols::odrive;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// From the factory first; then what hands are set to.
constexpr std::array kDynamixelRates = {57'600,    1'000'000, 2'000'000,
                                        3'000'000, 4'000'000, 115'200};
constexpr std::array kAbilityHandRates = {460'800, 1'000'000};
constexpr std::array kCanRates = {500'000, 250'000, 1'000'000};
constexpr int kSlcanRate = 115'200;
// 253 motors answer a broadcast in turn, each in its own 3 ms at the slowest rate.
constexpr milliseconds kBroadcast(800);
constexpr milliseconds kReply(60);
constexpr milliseconds kHeartbeats(400);  // axes tell of themselves every 100 ms

/// Hands whole frames that arrive within `time` to `use`.
template <class Framing, class Use>
void listen(devices::ByteChannel& bytes, Clock::duration time, Use&& use) {
  protocols::StreamReader<Framing> reader;
  const Clock::time_point deadline = Clock::now() + time;
  std::array<std::uint8_t, 512> chunk;
  while (Clock::now() < deadline) {
    const std::size_t count = bytes.receive(chunk, deadline);
    if (count == 0) break;
    reader.feed({chunk.data(), count}, use);
  }
  reader.settle(use);
}

void findDynamixels(const std::string& port, int baud, std::vector<Found>& found) {
  devices::SerialPort bytes(port, baud);
  bytes.open();
  protocols::ByteBuffer question;
  dxl::encodePing(dxl::kBroadcastId, question);
  bytes.discard();
  bytes.send(question.bytes());
  listen<dxl::Framing>(bytes, kBroadcast, [&](protocols::Bytes frame) {
    const auto status = dxl::statusOf(dxl::packetOf(frame));
    if (!status || status->data.size() != 3) return;
    const auto number = protocols::numberAt<std::uint16_t>(status->data, 0);
    const auto model = dxl::modelNumbered(number);
    found.push_back({"dynamixel", baud, status->id,
                     model
                         ? fmt::format("{}{}", model->name,
                                       model->current_unit_mA > 0 ? "" : ", no current control")
                         : fmt::format("model {}, not supported", number)});
  });
}

void findAbilityHand(const std::string& port, int baud, std::vector<Found>& found) {
  devices::SerialPort bytes(port, baud);
  bytes.open();
  protocols::ByteBuffer question;
  ah::encodeReadOnly(ah::kDefaultAddress, ah::Reply::kMotors, question);
  bytes.discard();
  bytes.send(question.bytes());
  bool has_answered = false;
  listen<ah::Framing>(bytes, kReply, [&](protocols::Bytes content) {
    has_answered = has_answered || ah::stateOf(content).has_value();
  });
  if (has_answered)
    found.push_back({"ability_hand", baud, ah::kDefaultAddress, "PSYONIC Ability Hand"});
}

void findODrives(const std::string& port, int bit_rate, std::vector<Found>& found) {
  devices::SerialPort bytes(port, kSlcanRate);
  devices::SlcanChannel can(bytes, bit_rate, Clock::now);
  try {
    can.open();
  } catch (const TransportError&) {
    return;  // no adapter, or not at this rate
  }
  std::set<int> nodes;
  protocols::CanFrame frame;
  const Clock::time_point deadline = Clock::now() + kHeartbeats;
  while (Clock::now() < deadline && can.receive(frame, deadline)) {
    const auto address = odrive::addressOf(frame);
    const auto heartbeat = odrive::heartbeatOf(frame);
    if (!address || !heartbeat || !nodes.insert(address->node).second) continue;
    found.push_back(
        {"odrive", kSlcanRate, address->node,
         fmt::format("axis, {}, error 0x{:X}; can_bitrate {}",
                     heartbeat->state == odrive::AxisState::kIdle ? "idle" : "not idle",
                     heartbeat->error, bit_rate)});
  }
  can.close();
}

}  // namespace

std::vector<Found> scan(const std::string& port) {
  std::vector<Found> found;
  for (const int baud : kDynamixelRates) {
    findDynamixels(port, baud, found);
    // On a pty any rate is the same; so is a bus whose rate was found.
    if (!found.empty()) return found;
  }
  for (const int baud : kAbilityHandRates) {
    findAbilityHand(port, baud, found);
    if (!found.empty()) return found;
  }
  for (const int bit_rate : kCanRates) {
    findODrives(port, bit_rate, found);
    if (!found.empty()) return found;
  }
  return found;
}

std::string scanText(const std::string& port, const std::vector<Found>& found) {
  if (found.empty()) {
    return fmt::format(
        "{}: nobody answers. Is the device's power on? Does an Ability Hand have byte stuffing "
        "switched on? Is another program using the port?\n",
        port);
  }
  std::string text;
  std::string ids;
  for (const Found& each : found) {
    text += fmt::format("{}: {} at {} baud: id {}: {}\n", port, each.kind, each.baud, each.id,
                        each.what);
    ids += (ids.empty() ? "" : ",") + std::to_string(each.id);
  }
  return text + fmt::format(
                    "next: handgraft bridge config make HAND.urdf --kind {} --port {} "
                    "--baud {} --ids {} --out hand.yaml\n",
                    found.front().kind, port, found.front().baud, ids);
}

}  // namespace handgraft::bringup
