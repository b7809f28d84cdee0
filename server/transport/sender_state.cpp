#include "server/transport/sender_state.h"

#include "idl/datagrams/rtps.h"

namespace handgraft::server {

namespace wire = idl::rtps;

namespace {

constexpr std::size_t kEntities = 8;  // reader and writer, first in both kinds

}  // namespace

SenderState senderStateOf(std::span<const std::uint8_t> datagram) {
  constexpr std::size_t kSourceAt = 8;
  if (datagram.size() < wire::kMessageHeader) return {};
  SenderState state;
  state.key.assign(datagram.begin() + kSourceAt, datagram.begin() + wire::kMessageHeader);
  bool acknowledges = false;
  for (wire::Bytes rest = datagram.subspan(wire::kMessageHeader); !rest.empty();) {
    if (rest.size() < wire::kSubmessageHeader) return {};
    const wire::Piece piece{rest, (rest[1] & wire::kLittleEndian) != 0};
    // The last one's length may be left out.
    const std::size_t told = piece.u16(2);
    const std::size_t length =
        told == 0 ? rest.size() - wire::kSubmessageHeader : std::size_t{told};
    const wire::Piece body = piece.from(wire::kSubmessageHeader);
    if (!body.fits(0, length)) return {};
    std::size_t part = 0;
    if (rest[0] == wire::kInfoDestination && length == wire::kMessageHeader - kSourceAt) {
      part = length;
    } else if (rest[0] == wire::kHeartbeat && length >= kEntities) {
      part = kEntities;
      state.is_heartbeat = true;
    } else if (rest[0] == wire::kAckNack && length >= kEntities) {
      part = kEntities;
      acknowledges = true;
    } else {
      return {};
    }
    // The flags, too: whether an answer is asked for.
    state.key.append({static_cast<char>(rest[0]), static_cast<char>(rest[1])});
    state.key.append(body.bytes.begin(),
                     body.bytes.begin() + static_cast<std::ptrdiff_t>(part));
    rest = rest.subspan(wire::kSubmessageHeader + length);
  }
  if (!state.is_heartbeat && !acknowledges) return {};
  state.is_heartbeat = !acknowledges;
  return state;
}

}  // namespace handgraft::server
