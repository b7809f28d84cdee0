#include "hardware/devices/examples/line_wire.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "hardware/devices/stream_replies.h"

namespace handgraft::devices {

namespace {

unsigned sumOf(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text)
    sum ^= static_cast<unsigned char>(c);
  return sum;
}

std::string_view textOf(protocols::Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

protocols::Cut LineFraming::cut(protocols::Bytes window, protocols::ByteBuffer& frame) const {
  using Kind = protocols::Cut::Kind;
  const auto end = std::find(window.begin(), window.end(), '\n');
  if (end == window.end()) {
    return window.size() < kLongest ? protocols::Cut{}
                                    : protocols::Cut{Kind::kGarbage, window.size()};
  }
  const auto size = static_cast<std::size_t>(end - window.begin());
  const std::string_view line = textOf(window.first(size));
  if (size < 4 || line[size - 3] != '*') return {Kind::kGarbage, size + 1};
  unsigned sum = 0;
  const auto [rest, error] =
      std::from_chars(line.data() + size - 2, line.data() + size, sum, 16);
  const bool is_number = error == std::errc() && rest == line.data() + size;
  if (!is_number || sum != sumOf(line.substr(0, size - 3))) return {Kind::kDamaged, size + 1};
  frame.clear();
  frame.append(window.first(size - 3));
  return {Kind::kFrame, size + 1};
}

void LineFraming::encode(std::string_view text, protocols::ByteBuffer& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out.clear();
  for (const char c : text)
    out.push(static_cast<std::uint8_t>(c));
  const unsigned sum = sumOf(text);
  for (const char c : {'*', kDigits[sum >> 4U], kDigits[sum & 15U], '\n'})
    out.push(static_cast<std::uint8_t>(c));
}

bool LineState::parse(std::string_view text) {
  LineState told;
  const char* at = text.data();
  const char* const end = at + text.size();
  char before = '=';
  for (int* each : {&told.state, &told.watchdog_ms, &told.broken_motor, &told.position[0],
                    &told.position[1], &told.position[2]}) {
    if (at == end || *at != before) return false;
    const auto [rest, error] = std::from_chars(at + 1, end, *each);
    if (error != std::errc()) return false;
    at = rest;
    before = ',';
  }
  const auto motors = static_cast<int>(told.position.size());
  if (at != end || told.state < kOff || told.state > kBroken || told.broken_motor < -1 ||
      told.broken_motor >= motors) {
    return false;
  }
  *this = told;
  return true;
}

void LineWire::say(std::string_view text) {
  bytes_.discard();
  reader_.clear();
  LineFraming::encode(text, out_);
  bytes_.send(out_.bytes());
}

void LineWire::sayTargets(const LineUnits& units) {
  std::array<char, 64> text{};
  const auto end =
      fmt::format_to_n(text.data(), text.size(), ">{},{},{}", units[0], units[1], units[2]);
  say({text.data(), end.size});
}

bool LineWire::hear() {
  return awaitReply(bytes_, reader_, clock_() + reply_timeout_, counters_,
                    [&](protocols::Bytes frame) {
                      if (!told_.parse(textOf(frame))) return false;
                      time_ = clock_();
                      return true;
                    });
}

DeviceCounters LineWire::counters() const {
  return withFramesOf(reader_, counters_);
}

}  // namespace handgraft::devices
