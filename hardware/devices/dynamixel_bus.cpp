#include "hardware/devices/dynamixel_bus.h"

#include <utility>

#include "core/base/error.h"
#include "hardware/devices/stream_replies.h"

namespace handgraft::devices {

namespace dxl = protocols::dynamixel;

namespace {

constexpr int kAttempts = 3;

void putValue(std::int64_t value, int size, protocols::ByteBuffer& out) {
  for (int i = 0; i < size; ++i)
    out.push(static_cast<std::uint8_t>(value >> (8 * i) & 0xFF));
}

std::int64_t valueOf(protocols::Bytes bytes, bool is_signed) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value |= std::uint64_t{bytes[i]} << (8 * i);
  const std::uint64_t top = std::uint64_t{1} << (8 * bytes.size() - 1);
  if (is_signed && (value & top) != 0) value -= 2 * top;
  return static_cast<std::int64_t>(value);
}

}  // namespace

DynamixelBus::DynamixelBus(ByteChannel& bytes, Clock clock, Duration patience)
    : bytes_(bytes), clock_(std::move(clock)), patience_(patience) {}

std::optional<std::uint16_t> DynamixelBus::ping(std::uint8_t id) {
  dxl::encodePing(id, out_);
  const auto status = askOne(id, 3);
  if (!status || status->data.size() != 3)
    return std::nullopt;  // an error may come without data
  return protocols::numberAt<std::uint16_t>(status->data, 0);
}

std::int64_t DynamixelBus::read(std::uint8_t id, const Register& entry) {
  dxl::encodeRead(id, entry.address, entry.size, out_);
  const auto status = askOne(id, entry.size);
  check(status, id, entry.address);
  return valueOf(status->data, entry.is_signed);
}

void DynamixelBus::write(std::uint8_t id, const Register& entry, std::int64_t value) {
  protocols::ByteBuffer data;
  putValue(value, entry.size, data);
  writeBytes(id, entry.address, data.bytes());
}

void DynamixelBus::writeBytes(std::uint8_t id, std::uint16_t address, protocols::Bytes data) {
  dxl::encodeWrite(id, address, data, out_);
  check(askOne(id, 0), id, address);
}

void DynamixelBus::ensure(std::uint8_t id, const Register& entry, std::int64_t value) {
  if (read(id, entry) != value) write(id, entry, value);
}

void DynamixelBus::reboot(std::uint8_t id) {
  dxl::encodeReboot(id, out_);
  static_cast<void>(askOne(id, 0));  // it may be gone before it answers
}

void DynamixelBus::writeAll(std::span<const std::uint8_t> ids,
                            const Register& entry,
                            std::int64_t value) {
  protocols::ByteBuffer data;
  for (std::size_t i = 0; i < ids.size(); ++i)
    putValue(value, entry.size, data);
  dxl::encodeSyncWrite(entry.address, entry.size, ids, data.bytes(), out_);
  bytes_.send(out_.bytes());
}

void DynamixelBus::writeEach(std::span<const std::uint8_t> ids,
                             const Register& entry,
                             std::span<const std::int32_t> values) {
  protocols::ByteBuffer data;
  for (const std::int32_t value : values)
    putValue(value, entry.size, data);
  dxl::encodeSyncWrite(entry.address, entry.size, ids, data.bytes(), out_);
  bytes_.send(out_.bytes());
}

void DynamixelBus::wait(Duration time) {
  const TimePoint deadline = clock_() + time;
  std::array<std::uint8_t, 64> ignored{};
  while (clock_() < deadline)
    static_cast<void>(bytes_.receive(ignored, deadline));
}

const DeviceCounters& DynamixelBus::counters() {
  counters_ = withFramesOf(reader_, counters_);
  return counters_;
}

void DynamixelBus::ask() {
  bytes_.discard();
  reader_.clear();
  bytes_.send(out_.bytes());
}

std::optional<DynamixelBus::Status> DynamixelBus::askOne(std::uint8_t id, std::size_t size) {
  std::optional<Status> answer;
  for (int attempt = 0; attempt < kAttempts && !answer; ++attempt) {
    ask();
    listen([&](const Status& status, bool& is_done) {
      // An error comes without data.
      const bool fits = status.data.size() == size || status.error != dxl::Error::kNone;
      if (status.id != id || !fits) return false;
      answer_.clear();
      answer_.append(status.data);
      answer = status;
      answer->data = answer_.bytes();
      is_done = true;
      return true;
    });
    if (!answer) ++counters_.missed;
  }
  return answer;
}

void DynamixelBus::fail(std::uint8_t id, std::uint16_t address, const char* what) const {
  throw DeviceError(fmt::format("Dynamixel motor {}, register {}: {}", id, address, what));
}

void DynamixelBus::check(const std::optional<Status>& status,
                         std::uint8_t id,
                         std::uint16_t address) const {
  if (!status) fail(id, address, "no answer");
  switch (status->error) {
    case dxl::Error::kNone:
      return;
    case dxl::Error::kDataRange:
      return fail(id, address, "value out of range");
    case dxl::Error::kDataLimit:
      return fail(id, address, "value beyond a limit");
    case dxl::Error::kAccess:
      return fail(id, address, "not permitted now");
    default:
      return fail(id, address, "instruction failed");
  }
}

}  // namespace handgraft::devices
