#include "hardware/protocols/modbus_rtu.h"

namespace handgraft::protocols::modbus {

namespace {

constexpr std::size_t kCrc = 2;
constexpr std::size_t kNoFrame = 0;

void putHighFirst(std::uint16_t value, ByteBuffer& out) {
  out.push(static_cast<std::uint8_t>(value >> 8));
  out.push(static_cast<std::uint8_t>(value & 0xFF));
}

std::uint16_t highFirstAt(Bytes bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void seal(ByteBuffer& out) {
  out.put(crcOf(out.bytes()));
}

/// Cuts a frame whose whole size `sizeOf` tells once it is known: kNoFrame if none begins here.
template <class SizeOf>
Cut cutBySize(Bytes window, ByteBuffer& frame, std::size_t least, SizeOf&& size_of) {
  if (window.size() < least) return {Cut::Kind::kIncomplete, 0};
  const std::size_t size = size_of(window);
  if (size == kNoFrame) return {Cut::Kind::kGarbage, 1};
  if (window.size() < size) return {Cut::Kind::kIncomplete, 0};
  const Bytes content = window.first(size - kCrc);
  if (numberAt<std::uint16_t>(window, size - kCrc) != crcOf(content))
    return {Cut::Kind::kDamaged, 1};
  frame.clear();
  frame.append(content);
  return {Cut::Kind::kFrame, size};
}

}  // namespace

std::uint16_t crcOf(Bytes bytes) {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      const bool is_odd = (crc & 1U) != 0;
      crc = static_cast<std::uint16_t>(crc >> 1);
      if (is_odd) crc = static_cast<std::uint16_t>(crc ^ 0xA001);
    }
  }
  return crc;
}

void encodeRead(std::uint8_t device,
                std::uint16_t address,
                std::uint16_t count,
                ByteBuffer& out) {
  out.clear();
  out.push(device);
  out.push(kReadRegisters);
  putHighFirst(address, out);
  putHighFirst(count, out);
  seal(out);
}

void encodeWrite(std::uint8_t device,
                 std::uint16_t address,
                 std::span<const std::uint16_t> values,
                 ByteBuffer& out) {
  HANDGRAFT_REQUIRE(!values.empty() && values.size() <= kMostRegisters);
  out.clear();
  out.push(device);
  out.push(kWriteRegisters);
  putHighFirst(address, out);
  putHighFirst(static_cast<std::uint16_t>(values.size()), out);
  out.push(static_cast<std::uint8_t>(2 * values.size()));
  for (const std::uint16_t value : values)
    putHighFirst(value, out);
  seal(out);
}

void encodeReadReply(std::uint8_t device,
                     std::span<const std::uint16_t> values,
                     ByteBuffer& out) {
  HANDGRAFT_REQUIRE(!values.empty() && values.size() <= kMostRegisters);
  out.clear();
  out.push(device);
  out.push(kReadRegisters);
  out.push(static_cast<std::uint8_t>(2 * values.size()));
  for (const std::uint16_t value : values)
    putHighFirst(value, out);
  seal(out);
}

void encodeWriteReply(std::uint8_t device,
                      std::uint16_t address,
                      std::uint16_t count,
                      ByteBuffer& out) {
  out.clear();
  out.push(device);
  out.push(kWriteRegisters);
  putHighFirst(address, out);
  putHighFirst(count, out);
  seal(out);
}

std::optional<Reply> replyOf(Bytes content) {
  if (content.size() < 3) return std::nullopt;
  Reply reply{content[0], content[1], 0, 0, {}};
  if ((reply.function & kException) != 0) {
    if (content.size() != 3) return std::nullopt;
    reply.exception = content[2];
  } else if (reply.function == kReadRegisters) {
    if (content.size() != 3U + content[2] || content[2] % 2 != 0) return std::nullopt;
    reply.values = content.subspan(3);
  } else if (reply.function == kWriteRegisters) {
    if (content.size() != 6) return std::nullopt;
    reply.address = highFirstAt(content, 2);
  } else {
    return std::nullopt;
  }
  return reply;
}

std::optional<Request> requestOf(Bytes content) {
  if (content.size() < 6) return std::nullopt;
  Request request{content[0], content[1], highFirstAt(content, 2), highFirstAt(content, 4), {}};
  if (request.function == kReadRegisters) {
    if (content.size() != 6) return std::nullopt;
  } else if (request.function == kWriteRegisters) {
    const std::size_t bytes = content.size() > 6 ? content[6] : 0;
    if (content.size() != 7 + bytes || bytes != std::size_t{2} * request.count)
      return std::nullopt;
    request.values = content.subspan(7);
  } else {
    return std::nullopt;
  }
  return request;
}

std::uint16_t registerAt(Bytes values, std::size_t index) {
  HANDGRAFT_REQUIRE(2 * index + 1 < values.size());
  return highFirstAt(values, 2 * index);
}

Cut ReplyFraming::cut(Bytes window, ByteBuffer& frame) const {
  return cutBySize(window, frame, 3, [](Bytes bytes) -> std::size_t {
    if (bytes[1] == kReadRegisters) {
      const bool is_ours = bytes[2] % 2 == 0 && bytes[2] > 0 && bytes[2] <= 2 * kMostRegisters;
      return is_ours ? 3U + bytes[2] + kCrc : kNoFrame;
    }
    if (bytes[1] == kWriteRegisters) return 6 + kCrc;
    const std::uint8_t failed = bytes[1] & static_cast<std::uint8_t>(~kException);
    const bool is_exception =
        (bytes[1] & kException) != 0 && (failed == kReadRegisters || failed == kWriteRegisters);
    return is_exception ? 3 + kCrc : kNoFrame;
  });
}

Cut RequestFraming::cut(Bytes window, ByteBuffer& frame) const {
  return cutBySize(window, frame, 7, [](Bytes bytes) -> std::size_t {
    if (bytes[1] == kReadRegisters) return 6 + kCrc;
    if (bytes[1] != kWriteRegisters || bytes[6] > 2 * kMostRegisters) return kNoFrame;
    return 7U + bytes[6] + kCrc;
  });
}

}  // namespace handgraft::protocols::modbus
