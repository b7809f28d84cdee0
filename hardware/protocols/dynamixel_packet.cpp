#include "hardware/protocols/dynamixel_packet.h"

#include <array>

namespace handgraft::protocols::dynamixel {

namespace {

constexpr std::array<std::uint8_t, 4> kHeader = {0xFF, 0xFF, 0xFD, 0x00};
constexpr std::size_t kLengthAt = 5;
constexpr std::size_t kBodyAt = 7;  // of the instruction, from where stuffing begins
constexpr std::size_t kShortestLength = 3;
constexpr std::uint8_t kAlertBit = 0x80;

constexpr std::array<std::uint16_t, 256> makeCrcTable() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc << 1) ^ ((crc & 0x8000U) != 0 ? 0x8005U : 0U);
    }
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

// Sees FF FF FD go by.
class HeaderWatch {
 public:
  bool endsWith(std::uint8_t byte) {
    last_ = ((last_ << 8) | byte) & 0xFFFFFFU;
    return last_ == 0xFFFFFDU;
  }

 private:
  std::uint32_t last_ = 0;
};

// Drops the byte after each FF FF FD; false if it is no FD.
bool unstuff(Bytes body, ByteBuffer& frame) {
  HeaderWatch watch;
  for (std::size_t i = 0; i < body.size(); ++i) {
    frame.push(body[i]);
    if (!watch.endsWith(body[i])) continue;
    if (++i == body.size() || body[i] != 0xFD) return false;
    watch.endsWith(body[i]);
  }
  return true;
}

// How many bytes at the front cannot begin a header.
std::size_t distanceToHeader(Bytes window) {
  for (std::size_t start = 0; start < window.size(); ++start) {
    const std::size_t count = std::min(kHeader.size(), window.size() - start);
    if (std::equal(kHeader.begin(), kHeader.begin() + static_cast<std::ptrdiff_t>(count),
                   window.begin() + static_cast<std::ptrdiff_t>(start))) {
      return start;
    }
  }
  return window.size();
}

void encodeCall(std::uint8_t id, Instruction instruction, Bytes parameters, ByteBuffer& out) {
  encode({id, static_cast<std::uint8_t>(instruction), parameters}, out);
}

}  // namespace

std::uint16_t crc16(Bytes bytes) {
  static constexpr std::array<std::uint16_t, 256> kTable = makeCrcTable();
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc = ((crc << 8) & 0xFFFFU) ^ kTable[(crc >> 8) ^ byte];
  }
  return static_cast<std::uint16_t>(crc);
}

Cut Framing::cut(Bytes window, ByteBuffer& frame) const {
  using Kind = Cut::Kind;
  if (const std::size_t skip = distanceToHeader(window); skip > 0)
    return {Kind::kGarbage, skip};
  if (window.size() < kBodyAt) return {Kind::kIncomplete, 0};
  const std::uint8_t id = window[4];
  const std::size_t length = numberAt<std::uint16_t>(window, kLengthAt);
  if (id == 0xFD || id == 0xFF || length < kShortestLength || kBodyAt + length > kLongest)
    return {Kind::kGarbage, 1};
  const std::size_t size = kBodyAt + length;
  if (window.size() < size) return {Kind::kIncomplete, 0};
  // After a wrong CRC the length cannot be trusted either, so the search goes on at the very
  // next byte.
  if (crc16(window.first(size - 2)) != numberAt<std::uint16_t>(window, size - 2))
    return {Kind::kDamaged, 1};
  frame.clear();
  frame.push(id);
  if (!unstuff(window.subspan(kBodyAt, length - 2), frame)) return {Kind::kDamaged, 1};
  return {Kind::kFrame, size};
}

Packet packetOf(Bytes frame) {
  HANDGRAFT_REQUIRE(frame.size() >= 2);
  return {frame[0], frame[1], frame.subspan(2)};
}

void encode(const Packet& packet, ByteBuffer& out) {
  ByteBuffer body;
  HeaderWatch watch;
  const auto put = [&](std::uint8_t byte) {
    body.push(byte);
    if (!watch.endsWith(byte)) return;
    body.push(0xFD);
    watch.endsWith(0xFD);
  };
  put(packet.instruction);
  for (const std::uint8_t byte : packet.parameters)
    put(byte);

  out.clear();
  out.append(kHeader);
  out.push(packet.id);
  out.put(static_cast<std::uint16_t>(body.size() + 2));
  out.append(body.bytes());
  out.put(crc16(out.bytes()));
}

std::optional<Status> statusOf(const Packet& packet) {
  if (packet.id > kHighestId || packet.parameters.empty() ||
      packet.instruction != static_cast<std::uint8_t>(Instruction::kStatus)) {
    return std::nullopt;
  }
  const std::uint8_t error = packet.parameters[0];
  return Status{packet.id, (error & kAlertBit) != 0,
                static_cast<Error>(error & static_cast<std::uint8_t>(~kAlertBit)),
                packet.parameters.subspan(1)};
}

void encodeStatus(const Status& status, ByteBuffer& out) {
  ByteBuffer parameters;
  parameters.push(static_cast<std::uint8_t>(static_cast<std::uint8_t>(status.error) |
                                            (status.alert ? kAlertBit : 0)));
  parameters.append(status.data);
  encodeCall(status.id, Instruction::kStatus, parameters.bytes(), out);
}

void encodePing(std::uint8_t id, ByteBuffer& out) {
  encodeCall(id, Instruction::kPing, {}, out);
}

void encodeReboot(std::uint8_t id, ByteBuffer& out) {
  encodeCall(id, Instruction::kReboot, {}, out);
}

void encodeRead(std::uint8_t id, std::uint16_t address, std::uint16_t size, ByteBuffer& out) {
  ByteBuffer parameters;
  parameters.put(address);
  parameters.put(size);
  encodeCall(id, Instruction::kRead, parameters.bytes(), out);
}

void encodeWrite(std::uint8_t id, std::uint16_t address, Bytes data, ByteBuffer& out) {
  ByteBuffer parameters;
  parameters.put(address);
  parameters.append(data);
  encodeCall(id, Instruction::kWrite, parameters.bytes(), out);
}

void encodeSyncRead(std::uint16_t address,
                    std::uint16_t size,
                    std::span<const std::uint8_t> ids,
                    ByteBuffer& out) {
  ByteBuffer parameters;
  parameters.put(address);
  parameters.put(size);
  parameters.append(ids);
  encodeCall(kBroadcastId, Instruction::kSyncRead, parameters.bytes(), out);
}

void encodeSyncWrite(std::uint16_t address,
                     std::uint16_t size,
                     std::span<const std::uint8_t> ids,
                     Bytes data,
                     ByteBuffer& out) {
  HANDGRAFT_REQUIRE(data.size() == ids.size() * size);
  ByteBuffer parameters;
  parameters.put(address);
  parameters.put(size);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    parameters.push(ids[i]);
    parameters.append(data.subspan(i * size, size));
  }
  encodeCall(kBroadcastId, Instruction::kSyncWrite, parameters.bytes(), out);
}

}  // namespace handgraft::protocols::dynamixel
