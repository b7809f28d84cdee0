#pragma once

#include "hardware/devices/byte_channel.h"
#include "hardware/protocols/can_frame.h"

namespace handgraft::devices {

/// CAN frames to and from a bus, over whatever carries them.
///
/// Errors: as ByteChannel; also TransportError when the controller has left the bus.
class CanChannel {
 public:
  virtual ~CanChannel() = default;
  CanChannel() = default;
  CanChannel(const CanChannel&) = delete;
  CanChannel& operator=(const CanChannel&) = delete;

  virtual void open() = 0;
  virtual void close() = 0;
  virtual void send(const protocols::CanFrame& frame) = 0;

  /// Waits for a frame; false at the deadline. One that came before is returned even if the
  /// deadline has passed.
  virtual bool receive(protocols::CanFrame& frame, TimePoint deadline) = 0;

  /// What the carrier complained about or could not read, since the start.
  [[nodiscard]] virtual std::uint64_t damaged() const = 0;
};

}  // namespace handgraft::devices
