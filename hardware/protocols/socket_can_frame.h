#pragma once

#include <linux/can.h>

#include "hardware/protocols/can_frame.h"

namespace handgraft::protocols {

/// A frame as the kernel's CAN sockets carry it.
struct can_frame toSocketCan(const CanFrame& frame);

/// What a CAN socket said: a frame, or trouble on the bus.
struct SocketCanMessage {
  bool is_error = false;    ///< an error frame of the kernel; `frame` is empty
  std::uint32_t error = 0;  ///< CAN_ERR_* of linux/can/error.h
  CanFrame frame;
};

/// A length beyond 8 is taken for 8, as the kernel does.
SocketCanMessage fromSocketCan(const struct can_frame& raw);

}  // namespace handgraft::protocols
