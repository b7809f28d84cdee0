#pragma once

#include <array>
#include <string_view>

#include "hardware/devices/byte_channel.h"
#include "hardware/devices/device.h"
#include "hardware/protocols/stream_reader.h"

namespace handgraft::devices {

/// Lines of text: what is said, '*', the XOR of its bytes as two hexadecimal digits, LF.
struct LineFraming {
  static constexpr std::size_t kLongest = 128;

  protocols::Cut cut(protocols::Bytes window, protocols::ByteBuffer& frame) const;

  static void encode(std::string_view text, protocols::ByteBuffer& out);
};

using LineUnits = std::array<int, 3>;  // 0.1 mrad

/// What such a hand answers, whatever it is told: `=state,watchdog_ms,broken motor or -1`, and
/// three positions.
struct LineState {
  enum State { kOff = 0, kOn = 1, kWatchdogFired = 2, kBroken = 3 };

  int state = kOff, watchdog_ms = 0, broken_motor = -1;
  LineUnits position{};

  /// False, and as before, for any other text.
  bool parse(std::string_view text);
};

/// Says one line, hears one answer.
class LineWire {
 public:
  LineWire(ByteChannel& bytes, Clock clock, Duration reply_timeout)
      : bytes_(bytes), clock_(std::move(clock)), reply_timeout_(reply_timeout) {}

  void open() { bytes_.open(); }

  /// What came before is late, and forgotten.
  void say(std::string_view text);
  /// Targets, `>` and three numbers, without the heap.
  void sayTargets(const LineUnits& units);
  /// False if no answer comes in time: `told` is the last one.
  bool hear();

  [[nodiscard]] const LineState& told() const { return told_; }

  [[nodiscard]] TimePoint time() const { return time_; }

  [[nodiscard]] DeviceCounters counters() const;

 private:
  ByteChannel& bytes_;
  Clock clock_;
  Duration reply_timeout_;
  protocols::StreamReader<LineFraming> reader_;
  protocols::ByteBuffer out_;
  LineState told_;
  TimePoint time_;  // of `told_`
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
