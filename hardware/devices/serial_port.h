#pragma once

#include <string>

#include "hardware/devices/byte_channel.h"

namespace handgraft::devices {

/// A tty: eight bits, no parity, one stop bit, nothing translated, nobody else may open it.
///
/// Any rate that the driver can do is permitted, standard or not. Where a USB adapter can
/// answer with low latency, it is asked to. Nothing allocates once it is open, but errors.
class SerialPort final : public ByteChannel {
 public:
  /// Errors: InvalidInput for a rate outside 300 to 12,000,000 bit/s.
  SerialPort(std::string path, int bits_per_second);
  ~SerialPort() override;

  /// Errors: TransportError also if it is no tty, is in use, or cannot do the rate within 3 %,
  /// which is what a UART bears.
  void open() override;
  void close() override;
  void send(protocols::Bytes bytes) override;
  std::size_t receive(std::span<std::uint8_t> into, TimePoint deadline) override;
  void discard() override;

 private:
  void claim();
  void configure() const;
  // Waits for `events`; false at the deadline. Throws when the other end is gone.
  bool waitFor(short events, TimePoint deadline);
  [[noreturn]] void fail(const char* what);

  std::string path_;
  int bits_per_second_;
  int file_ = -1;
};

}  // namespace handgraft::devices
