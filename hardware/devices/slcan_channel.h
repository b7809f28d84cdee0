#pragma once

#include <array>

#include "hardware/devices/can_channel.h"
#include "hardware/protocols/slcan.h"

namespace handgraft::devices {

/// A CAN bus behind an adapter that speaks lines of text on a tty.
///
/// The adapter's answers to frames are neither waited for nor needed: some give none.
class SlcanChannel final : public CanChannel {
 public:
  /// `bytes` and `clock` have to live as long as this.
  /// Errors: InvalidInput for a bit rate that adapters have no command for.
  SlcanChannel(ByteChannel& bytes, int bits_per_second, Clock clock);

  /// Errors: TransportError also if the adapter refuses the bit rate or to join the bus.
  void open() override;
  /// Asks the adapter to leave the bus, without waiting.
  void close() override;
  void send(const protocols::CanFrame& frame) override;
  bool receive(protocols::CanFrame& frame, TimePoint deadline) override;
  [[nodiscard]] std::uint64_t damaged() const override;

 private:
  static constexpr std::size_t kChunk = 256;     // bytes at a time
  static constexpr std::size_t kQueue = kChunk;  // a line has more than a byte

  void command(const char* text);
  void expectAnswer(const char* text, bool is_refusable);
  void take(protocols::Bytes content);
  bool fill(TimePoint deadline);

  ByteChannel& bytes_;
  int rate_digit_;
  Clock clock_;
  protocols::StreamReader<protocols::slcan::Framing> reader_;
  std::array<protocols::CanFrame, kQueue> queue_;
  std::size_t first_ = 0, last_ = 0;  // of what is in the queue
  int done_ = 0, refused_ = 0;        // answers since the last command
  std::uint64_t errors_ = 0;
};

}  // namespace handgraft::devices
