#include "hardware/bringup/scan.h"

#include <array>
#include <chrono>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/devices/serial_port.h"
#include "hardware/devices/slcan_channel.h"
#include "hardware/devices/socket_can_channel.h"
#include "hardware/protocols/ability_hand.h"
#include "hardware/protocols/allegro_can.h"
#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/dynamixel_table.h"
#include "hardware/protocols/inspire_table.h"
#include "hardware/protocols/modbus_rtu.h"
#include "hardware/protocols/odrive_can.h"

namespace handgraft::bringup {

namespace {

namespace ah = protocols::ability_hand;
namespace allegro = protocols::allegro;
namespace dxl = protocols::dynamixel;
namespace inspire = protocols::inspire;
namespace modbus = protocols::modbus;
namespace odrive = protocols::odrive;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// From the factory first; then what hands are set to.
constexpr std::array kDynamixelRates = {57'600,    1'000'000, 2'000'000,
                                        3'000'000, 4'000'000, 115'200};
constexpr std::array kAbilityHandRates = {460'800, 1'000'000};
constexpr std::array kInspireRates = {115'200, 57'600, 19'200};
constexpr std::uint8_t kInspireAddress = 1;  // from the factory
constexpr std::array kCanRates = {500'000, 250'000, 1'000'000};
constexpr int kSlcanRate = 115'200;
// 253 motors answer a broadcast in turn, each in its own 3 ms at the slowest rate.
constexpr milliseconds kBroadcast(800);
constexpr milliseconds kReply(60);
constexpr int kAttempts = 3;
constexpr milliseconds kHeartbeats(400);  // axes tell of themselves every 100 ms

/// Hands whole frames that arrive within `time` to `use`.
template <class Framing, class Use>
void listen(devices::ByteChannel& bytes, Clock::duration time, Use&& use) {
  protocols::StreamReader<Framing> reader;
  const Clock::time_point deadline = Clock::now() + time;
  std::array<std::uint8_t, 512> chunk{};
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
    found.push_back(
        {"dynamixel", baud, 0, status->id,
         model ? fmt::format("{}{}", model->name,
                             model->current_unit_milliamp > 0 ? "" : ", no current control")
               : fmt::format("model {}, not supported", number)});
  });
}

/// Whether somebody answers a question in a frame that is `theirs`; on a busy machine an answer
/// may be late.
template <class Framing, class Theirs>
bool answers(const std::string& port,
             int baud,
             const protocols::ByteBuffer& question,
             Theirs&& theirs) {
  devices::SerialPort bytes(port, baud);
  bytes.open();
  bool has_answered = false;
  for (int attempt = 0; attempt < kAttempts && !has_answered; ++attempt) {
    bytes.discard();
    bytes.send(question.bytes());
    listen<Framing>(bytes, kReply, [&](protocols::Bytes frame) {
      has_answered = has_answered || theirs(frame);
    });
  }
  return has_answered;
}

void findAbilityHand(const std::string& port, int baud, std::vector<Found>& found) {
  protocols::ByteBuffer question;
  ah::encodeReadOnly(ah::kDefaultAddress, ah::Reply::kMotors, question);
  const auto is_state = [](protocols::Bytes content) {
    return ah::stateOf(content).has_value();
  };
  if (answers<ah::Framing>(port, baud, question, is_state))
    found.push_back({"ability_hand", baud, 0, ah::kDefaultAddress, "PSYONIC Ability Hand"});
}

void findInspire(const std::string& port, int baud, std::vector<Found>& found) {
  protocols::ByteBuffer question;
  modbus::encodeRead(kInspireAddress, inspire::kAngleAct, inspire::kMotorCount, question);
  const auto are_angles = [](protocols::Bytes content) {
    const auto reply = modbus::replyOf(content);
    return reply && reply->device == kInspireAddress &&
           reply->values.size() == 2 * inspire::kMotorCount;
  };
  if (answers<modbus::ReplyFraming>(port, baud, question, are_angles))
    found.push_back({"inspire", baud, 0, kInspireAddress, "Inspire RH56"});
}

/// Axes tell of themselves; only where none does an Allegro Hand is asked, whose frames would
/// mean other things to an axis.
void findOnBus(devices::CanChannel& can, int baud, int bit_rate, std::vector<Found>& found) {
  std::set<int> nodes;
  protocols::CanFrame frame;
  Clock::time_point deadline = Clock::now() + kHeartbeats;
  while (Clock::now() < deadline && can.receive(frame, deadline)) {
    const auto address = odrive::addressOf(frame);
    const auto heartbeat = odrive::heartbeatOf(frame);
    if (!address || !heartbeat || !nodes.insert(address->node).second) continue;
    found.push_back(
        {"odrive", baud, bit_rate, address->node,
         fmt::format("axis, {}, error 0x{:X}",
                     heartbeat->state == odrive::AxisState::kIdle ? "idle" : "not idle",
                     heartbeat->error)});
  }
  if (!nodes.empty()) return;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    can.send(allegro::askFor(allegro::Command::kFingerPose, 0));
    deadline = Clock::now() + kReply;
    while (Clock::now() < deadline && can.receive(frame, deadline)) {
      const auto pose = allegro::poseOf(frame);
      if (!pose || pose->finger != 0) continue;
      found.push_back({"allegro", baud, bit_rate, 0, "Allegro Hand"});
      return;
    }
  }
}

void findBehindAdapter(const std::string& port, int bit_rate, std::vector<Found>& found) {
  devices::SerialPort bytes(port, kSlcanRate);
  devices::SlcanChannel can(bytes, bit_rate, Clock::now);
  try {
    can.open();
    findOnBus(can, kSlcanRate, bit_rate, found);
    can.close();
  } catch (const TransportError&) {
    // No adapter, not at this rate, or nobody on its bus takes a frame.
  }
}

/// Whose bit rate was set when it was brought up.
void findOnInterface(const std::string& name, std::vector<Found>& found) {
  std::vector<int> nodes(odrive::kHighestNode + 1);
  std::iota(nodes.begin(), nodes.end(), 0);
  devices::SocketCanChannel can(devices::canInterface(name, nodes));
  can.open();
  findOnBus(can, 0, 0, found);
}

}  // namespace

std::vector<Found> scan(const std::string& port) {
  std::vector<Found> found;
  if (port.empty() || port.front() != '/') {
    findOnInterface(port, found);
    return found;
  }
  for (const int baud : kDynamixelRates) {
    findDynamixels(port, baud, found);
    // On a pty any rate is the same; so is a bus whose rate was found.
    if (!found.empty()) return found;
  }
  for (const int baud : kAbilityHandRates) {
    findAbilityHand(port, baud, found);
    if (!found.empty()) return found;
  }
  for (const int baud : kInspireRates) {
    findInspire(port, baud, found);
    if (!found.empty()) return found;
  }
  for (const int bit_rate : kCanRates) {
    findBehindAdapter(port, bit_rate, found);
    if (!found.empty()) return found;
  }
  return found;
}

namespace {

std::string rateText(const Found& found) {
  if (found.baud == 0) return "the bit rate of its bus";
  const std::string text = fmt::format("{} baud", found.baud);
  return found.can_bitrate == 0 ? text
                                : fmt::format("{}, can_bitrate {}", text, found.can_bitrate);
}

}  // namespace

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
    text += fmt::format("{}: {} at {}: id {}: {}\n", port, each.kind, rateText(each), each.id,
                        each.what);
    ids += (ids.empty() ? "" : ",") + std::to_string(each.id);
  }
  const Found& first = found.front();
  text += fmt::format("next: handgraft bridge config make HAND.urdf --kind {} --port {}",
                      first.kind, port);
  const bool is_adapter = first.baud > 0 && first.can_bitrate > 0;  // whose own rate is nominal
  if (first.baud > 0 && !is_adapter) text += fmt::format(" --baud {}", first.baud);
  if (first.can_bitrate > 0) text += fmt::format(" --can-bitrate {}", first.can_bitrate);
  // Motors of a hand that comes as a whole have places, which it cannot tell.
  const bool has_ids = first.kind == "dynamixel" || first.kind == "odrive";
  if (has_ids) text += " --ids " + ids;
  return text + " --out hand.yaml\n";
}

}  // namespace handgraft::bringup
