#include "hardware/protocols/ability_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace handgraft::protocols::ability_hand {

namespace {

constexpr std::uint8_t kFlag = 0x7E;
constexpr std::uint8_t kEscape = 0x7D;
constexpr std::uint8_t kEscapeBit = 0x20;
constexpr std::size_t kShortestContent = 3;  // bytes between the flags, as they are sent

constexpr std::size_t kMotorReplySize = 38;  // variant 3, without its checksum
constexpr std::size_t kTouchReplySize = 71;  // variants 1 and 2
constexpr std::size_t kTouchBytes = 45;
constexpr std::size_t kMotorCommandSize = 14;

constexpr std::uint8_t kGripHeader = 0x1D;
constexpr std::uint8_t kReadRegisterHeader = 0xDA;
constexpr std::uint8_t kWriteRegisterHeader = 0xDE;

std::uint8_t sumOf(Bytes bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes)
    sum += byte;
  return static_cast<std::uint8_t>(sum);
}

bool unstuff(Bytes stuffed, ByteBuffer& frame) {
  for (std::size_t i = 0; i < stuffed.size(); ++i) {
    std::uint8_t byte = stuffed[i];
    if (byte == kEscape) {
      if (++i == stuffed.size()) return false;
      byte = stuffed[i] ^ kEscapeBit;
      if (byte != kFlag && byte != kEscape) return false;
    }
    frame.push(byte);
  }
  return true;
}

bool isReply(std::uint8_t low_bits) {
  return low_bits <= static_cast<std::uint8_t>(Reply::kMotors);
}

bool isMotorMode(Mode mode) {
  return mode == Mode::kPosition || mode == Mode::kVelocity || mode == Mode::kTorque ||
         mode == Mode::kVoltage;
}

std::uint8_t headerOf(Mode mode, Reply reply) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(mode) | static_cast<unsigned>(reply));
}

// Twelve bits each, packed low bits first. Differs: a table of the ICD words it the other way
// round; its own C routine and recorded replies are as here.
std::uint16_t touchAt(Bytes packed, std::size_t i) {
  const std::size_t at = 3 * (i / 2);
  return static_cast<std::uint16_t>(i % 2 == 0 ? packed[at] | (packed[at + 1] & 0x0FU) << 8
                                               : static_cast<unsigned>(packed[at + 1] >> 4) |
                                                     packed[at + 2] << 4U);
}

}  // namespace

Cut Framing::cut(Bytes window, ByteBuffer& frame) const {
  using Kind = Cut::Kind;
  if (window[0] != kFlag) {
    const auto flag = std::find(window.begin(), window.end(), kFlag);
    return {Kind::kGarbage, static_cast<std::size_t>(flag - window.begin())};
  }
  const auto end = std::find(window.begin() + 1, window.end(), kFlag);
  if (end == window.end()) {
    return window.size() < kLongest ? Cut{} : Cut{Kind::kGarbage, window.size()};
  }
  // The closing flag stays: it may open the next frame.
  const auto size = static_cast<std::size_t>(end - window.begin());
  const Bytes stuffed = window.subspan(1, size - 1);
  if (stuffed.size() < kShortestContent) return {Kind::kIdle, size};
  frame.clear();
  if (!unstuff(stuffed, frame) || sumOf(frame.bytes()) != 0) return {Kind::kDamaged, size};
  frame.pop();
  return {Kind::kFrame, size};
}

void encodeFrame(Bytes content, ByteBuffer& out) {
  const auto put = [&](std::uint8_t byte) {
    if (byte == kFlag || byte == kEscape) {
      out.push(kEscape);
      byte ^= kEscapeBit;
    }
    out.push(byte);
  };
  out.clear();
  out.push(kFlag);
  for (const std::uint8_t byte : content)
    put(byte);
  put(static_cast<std::uint8_t>(-sumOf(content)));
  out.push(kFlag);
}

// === Commands

void encodeCommand(
    std::uint8_t address, Mode mode, Reply reply, const Counts& counts, ByteBuffer& out) {
  HANDGRAFT_REQUIRE(isMotorMode(mode));
  ByteBuffer content;
  content.push(address);
  content.push(headerOf(mode, reply));
  for (const std::int16_t count : counts) {
    HANDGRAFT_REQUIRE(count != std::numeric_limits<std::int16_t>::min());
    content.put(count);
  }
  encodeFrame(content.bytes(), out);
}

void encodeReadOnly(std::uint8_t address, Reply reply, ByteBuffer& out) {
  encodeFrame(std::array{address, headerOf(Mode::kReadOnly, reply)}, out);
}

void encodeSimple(std::uint8_t address, Simple command, ByteBuffer& out) {
  encodeFrame(std::array{address, static_cast<std::uint8_t>(command)}, out);
}

void encodeGrip(std::uint8_t address, std::uint8_t grip, std::uint8_t speed, ByteBuffer& out) {
  encodeFrame(std::array{address, kGripHeader, grip, speed}, out);
}

void encodeReadRegister(std::uint8_t address, std::uint32_t number, ByteBuffer& out) {
  ByteBuffer content;
  content.push(address);
  content.push(kReadRegisterHeader);
  content.put(number);
  encodeFrame(content.bytes(), out);
}

void encodeWriteRegister(std::uint8_t address,
                         std::uint32_t number,
                         std::uint32_t value,
                         ByteBuffer& out) {
  ByteBuffer content;
  content.push(address);
  content.push(kWriteRegisterHeader);
  content.put(number);
  content.put(value);
  encodeFrame(content.bytes(), out);
}

std::optional<Command> commandOf(Bytes content) {
  if (content.size() < 2) return std::nullopt;
  Command command{content[0], content[1], std::nullopt};
  const std::uint8_t header = command.header;
  if (content.size() == 2) {
    const bool is_read_only = command.mode() == Mode::kReadOnly && isReply(header & 0x0F);
    const bool is_simple = header == static_cast<std::uint8_t>(Simple::kExitApi) ||
                           header == static_cast<std::uint8_t>(Simple::kUpsampleThumbOn) ||
                           header == static_cast<std::uint8_t>(Simple::kUpsampleThumbOff);
    if (is_read_only || is_simple) return command;
    return std::nullopt;
  }
  if (content.size() != kMotorCommandSize || !isMotorMode(command.mode()) ||
      !isReply(header & 0x0F)) {
    return std::nullopt;
  }
  command.counts.emplace();
  for (std::size_t i = 0; i < kMotorCount; ++i)
    (*command.counts)[i] = numberAt<std::int16_t>(content, 2 + 2 * i);
  return command;
}

// === Replies

std::optional<State> stateOf(Bytes content) {
  if (content.empty()) return std::nullopt;
  State state;
  state.header = content[0];
  state.reply = static_cast<Reply>(state.header & 0x0F);
  const Mode mode = static_cast<Mode>(state.header & 0xF0);
  const bool has_touch = state.reply != Reply::kMotors;
  if (!isReply(state.header & 0x0F) || (!isMotorMode(mode) && mode != Mode::kReadOnly) ||
      content.size() != (has_touch ? kTouchReplySize : kMotorReplySize)) {
    return std::nullopt;
  }
  Counts& beside = state.reply == Reply::kTouchVelocity ? state.velocity : state.current;
  for (std::size_t i = 0; i < kMotorCount; ++i) {
    state.position[i] = numberAt<std::int16_t>(content, 1 + 4 * i);
    beside[i] = numberAt<std::int16_t>(content, 3 + 4 * i);
  }
  const Bytes rest = content.subspan(1 + 4 * kMotorCount);
  if (has_touch) {
    for (std::size_t i = 0; i < kTouchCount; ++i)
      state.touch[i] = touchAt(rest, i);
  } else {
    for (std::size_t i = 0; i < kMotorCount; ++i)
      state.velocity[i] = numberAt<std::int16_t>(rest, 2 * i);
  }
  state.limited = content.back();
  return state;
}

void encodeState(const State& state, ByteBuffer& out) {
  const Counts& beside = state.reply == Reply::kTouchVelocity ? state.velocity : state.current;
  ByteBuffer content;
  content.push(
      static_cast<std::uint8_t>((state.header & 0xF0U) | static_cast<unsigned>(state.reply)));
  for (std::size_t i = 0; i < kMotorCount; ++i) {
    content.put(state.position[i]);
    content.put(beside[i]);
  }
  if (state.reply == Reply::kMotors) {
    for (const std::int16_t velocity : state.velocity)
      content.put(velocity);
  } else {
    static_assert(std::size_t{2} * kTouchBytes == std::size_t{3} * kTouchCount);
    for (std::size_t i = 0; i < kTouchCount; i += 2) {
      const unsigned first = state.touch[i] & 0xFFFU;
      const unsigned second = state.touch[i + 1] & 0xFFFU;
      content.push(static_cast<std::uint8_t>(first));
      content.push(static_cast<std::uint8_t>(first >> 8 | second << 4));
      content.push(static_cast<std::uint8_t>(second >> 4));
    }
  }
  content.push(state.limited);
  encodeFrame(content.bytes(), out);
}

// === Units

std::int16_t countsOf(double value, double per_count, std::int16_t largest) {
  HANDGRAFT_REQUIRE(std::isfinite(value) && per_count > 0.0);
  const double most = largest;
  return static_cast<std::int16_t>(std::clamp(std::trunc(value / per_count), -most, most));
}

double touchForce(std::uint16_t reading) {
  if (reading == 0) return 0.0;
  const double volt = reading * 3.3 / 4096.0;
  const double ohm = 33000.0 / volt + 10000.0;
  return 121591.0 / ohm + 0.878894;
}

}  // namespace handgraft::protocols::ability_hand
