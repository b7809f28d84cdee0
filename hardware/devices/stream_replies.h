#pragma once

#include <array>

#include "hardware/devices/byte_channel.h"
#include "hardware/devices/device.h"

namespace handgraft::devices {

/// Reads from the wire until a frame comes that `is_reply` takes for the answer, or until
/// `deadline`: whether one came. All other frames are counted as stray, and an answer that did
/// not come as missed. `reader` is a protocols::StreamReader.
template <class Reader, class IsReply>
bool awaitReply(ByteChannel& bytes,
                Reader& reader,
                TimePoint deadline,
                DeviceCounters& counters,
                const IsReply& is_reply) {
  bool has_come = false;
  const auto look = [&](protocols::Bytes content) {
    if (!has_come && is_reply(content)) {
      has_come = true;
    } else {
      ++counters.stray;
    }
  };
  std::array<std::uint8_t, 256> chunk{};
  for (bool is_open = true; is_open && !has_come;) {
    const std::size_t count = bytes.receive(chunk, deadline);
    is_open = count > 0;
    if (is_open)
      reader.feed({chunk.data(), count}, look);
    else
      reader.settle(look);
  }
  if (!has_come) ++counters.missed;
  return has_come;
}

/// `counters` with what `reader` saw on the wire.
template <class Reader>
DeviceCounters withFramesOf(const Reader& reader, DeviceCounters counters) {
  counters.frames = reader.counters().frames;
  counters.damaged = reader.counters().damaged;
  counters.garbage_bytes = reader.counters().garbage_bytes;
  return counters;
}

}  // namespace handgraft::devices
