#include "hardware/protocols/socket_can_frame.h"

#include <algorithm>

namespace handgraft::protocols {

struct can_frame toSocketCan(const CanFrame& frame) {
  HANDGRAFT_REQUIRE(frame.size <= CAN_MAX_DLEN);
  HANDGRAFT_REQUIRE(frame.id <= (frame.is_extended ? kHighestExtendedId : kHighestStandardId));

  struct can_frame raw {};

  raw.can_id = frame.id | (frame.is_extended ? CAN_EFF_FLAG : 0U) |
               (frame.is_remote ? CAN_RTR_FLAG : 0U);
  raw.can_dlc = frame.size;
  std::copy(frame.bytes().begin(), frame.bytes().end(), raw.data);
  return raw;
}

SocketCanMessage fromSocketCan(const struct can_frame& raw) {
  SocketCanMessage message;
  if ((raw.can_id & CAN_ERR_FLAG) != 0) {
    message.is_error = true;
    message.error = raw.can_id & CAN_ERR_MASK;
    return message;
  }
  CanFrame& frame = message.frame;
  frame.is_extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.is_remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & (frame.is_extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.size = std::min<std::uint8_t>(raw.can_dlc, CAN_MAX_DLEN);
  std::copy_n(raw.data, frame.bytes().size(), frame.data.begin());
  return message;
}

}  // namespace handgraft::protocols
