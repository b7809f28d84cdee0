#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "hardware/protocols/bytes.h"

namespace handgraft::devices {

using TimePoint = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

/// The time. Injected, so that tests run in a time of their own.
using Clock = std::function<TimePoint()>;

/// A stream of bytes to and from a device: a serial port, or what stands for one in tests.
///
/// Errors: all but `close` throw TransportError when the wire is gone or not open; it then
/// stays so until `open`.
class ByteChannel {
 public:
  virtual ~ByteChannel() = default;
  ByteChannel() = default;
  ByteChannel(const ByteChannel&) = delete;
  ByteChannel& operator=(const ByteChannel&) = delete;

  /// Opens it, anew if it was open.
  virtual void open() = 0;
  virtual void close() = 0;

  /// Hands all of `bytes` over to the system; does not wait until they are on the wire.
  virtual void send(protocols::Bytes bytes) = 0;

  /// Waits until something has come, or `deadline`: how many bytes were put into `into`; 0 at
  /// the deadline. What came before is returned even if the deadline has passed.
  virtual std::size_t receive(std::span<std::uint8_t> into, TimePoint deadline) = 0;

  /// Forgets what has come and was not received.
  virtual void discard() = 0;
};

}  // namespace handgraft::devices
