#include "hardware/protocols/slcan.h"

#include <algorithm>
#include <array>
#include <optional>

namespace handgraft::protocols::slcan {

namespace {

constexpr std::uint8_t kReturn = 0x0D;
constexpr std::uint8_t kBell = 0x07;
constexpr std::size_t kTimeStampDigits = 4;
constexpr std::size_t kLongestLine = 31;  // without its CR; the longest frame has 30 digits

std::optional<unsigned> digitOf(std::uint8_t c) {
  if (c >= '0' && c <= '9') return c - unsigned{'0'};
  if (c >= 'A' && c <= 'F') return c - unsigned{'A'} + 10U;
  if (c >= 'a' && c <= 'f') return c - unsigned{'a'} + 10U;
  return std::nullopt;
}

// The number of hexadecimal digits; nothing if one is none.
std::optional<std::uint32_t> numberOf(Bytes digits) {
  std::uint32_t number = 0;
  for (const std::uint8_t c : digits) {
    const auto digit = digitOf(c);
    if (!digit) return std::nullopt;
    number = number << 4 | *digit;
  }
  return number;
}

void putDigits(std::uint32_t number, int count, ByteBuffer& out) {
  for (int i = count - 1; i >= 0; --i)
    out.push(static_cast<std::uint8_t>("0123456789ABCDEF"[number >> (4 * i) & 0xFU]));
}

std::optional<CanFrame> frameOf(Bytes line) {
  if (line.empty()) return std::nullopt;
  const auto letter = static_cast<char>(line[0]);
  CanFrame frame;
  frame.is_extended = letter == 'T' || letter == 'R';
  frame.is_remote = letter == 'r' || letter == 'R';
  if (!frame.is_extended && !frame.is_remote && letter != 't') return std::nullopt;

  const std::size_t id_digits = frame.is_extended ? 8 : 3;
  if (line.size() < 1 + id_digits + 1) return std::nullopt;
  const auto id = numberOf(line.subspan(1, id_digits));
  const auto size = digitOf(line[1 + id_digits]);
  if (!id || *id > (frame.is_extended ? kHighestExtendedId : kHighestStandardId) || !size ||
      *size > 8) {
    return std::nullopt;
  }
  frame.id = *id;
  frame.size = static_cast<std::uint8_t>(*size);

  const Bytes rest = line.subspan(1 + id_digits + 1);
  const std::size_t data_digits = 2 * frame.bytes().size();
  if (rest.size() != data_digits && rest.size() != data_digits + kTimeStampDigits)
    return std::nullopt;
  if (!numberOf(rest.subspan(data_digits))) return std::nullopt;
  for (std::size_t i = 0; 2 * i < data_digits; ++i) {
    const auto byte = numberOf(rest.subspan(2 * i, 2));
    if (!byte) return std::nullopt;
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  return frame;
}

}  // namespace

Cut Framing::cut(Bytes window, ByteBuffer& frame) const {
  using Kind = Cut::Kind;
  if (window[0] == kBell) {
    frame.clear();
    frame.push(kBell);
    return {Kind::kFrame, 1};
  }
  const auto end = std::find_if(window.begin(), window.end(), [](std::uint8_t byte) {
    return byte == kReturn || byte == kBell;
  });
  const auto before = static_cast<std::size_t>(end - window.begin());
  // A line that goes on for too long is none. Its last digits stay with its CR, however it
  // comes in pieces: cut off elsewhere, its end could be taken for a frame.
  if (before > kLongestLine) return {Kind::kGarbage, before - kLongestLine};
  if (end == window.end()) return {};
  if (*end == kBell) return {Kind::kGarbage, before};  // it breaks off
  frame.clear();
  frame.append(window.first(before + 1));
  return {Kind::kFrame, before + 1};
}

Line lineOf(Bytes content) {
  using Kind = Line::Kind;
  if (content.empty()) return {};
  if (content[0] == kBell) return {Kind::kError, {}};
  if (content.back() != kReturn) return {};
  const Bytes line = content.first(content.size() - 1);
  if (line.empty() || (line.size() == 1 && (line[0] == 'z' || line[0] == 'Z')))
    return {Kind::kDone, {}};
  if (const auto frame = frameOf(line)) return {Kind::kFrame, *frame};
  return {};
}

void encode(const CanFrame& frame, ByteBuffer& out) {
  HANDGRAFT_REQUIRE(frame.size <= 8);
  HANDGRAFT_REQUIRE(frame.id <= (frame.is_extended ? kHighestExtendedId : kHighestStandardId));
  const char letter = frame.is_remote ? 'r' : 't';
  out.clear();
  out.push(static_cast<std::uint8_t>(frame.is_extended ? letter - 'a' + 'A' : letter));
  putDigits(frame.id, frame.is_extended ? 8 : 3, out);
  putDigits(frame.size, 1, out);
  for (const std::uint8_t byte : frame.bytes())
    putDigits(byte, 2, out);
  out.push(kReturn);
}

int bitRateDigit(int bits_per_second) {
  constexpr std::array kRates = {10000,  20000,  50000,  100000, 125000,
                                 250000, 500000, 800000, 1000000};
  const auto found = std::find(kRates.begin(), kRates.end(), bits_per_second);
  return found == kRates.end() ? -1 : static_cast<int>(found - kRates.begin());
}

}  // namespace handgraft::protocols::slcan
