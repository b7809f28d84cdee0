#pragma once

#include <array>
#include <optional>
#include <span>

#include "hardware/devices/device.h"
#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/dynamixel_table.h"

namespace handgraft::devices {

/// Questions and answers on a bus of Dynamixel motors.
///
/// The protocol numbers no packets, so an answer is known by its id and length alone: before
/// each question what came late is forgotten, and each id answers once.
class DynamixelBus {
 public:
  using Status = protocols::dynamixel::Status;
  using Register = protocols::dynamixel::Register;

  /// `bytes` has to live as long as this. `patience` is how long an answer may take, that of
  /// the last motor included.
  DynamixelBus(ByteChannel& bytes, Clock clock, Duration patience);

  // === Single motors; asked again when no answer comes. Not for the loop.

  /// The model's number; none if nobody answers.
  std::optional<std::uint16_t> ping(std::uint8_t id);

  /// Errors: DeviceError, naming motor and register, without an answer or with an error.
  std::int64_t read(std::uint8_t id, const Register& entry);
  void write(std::uint8_t id, const Register& entry, std::int64_t value);
  void writeBytes(std::uint8_t id, std::uint16_t address, protocols::Bytes data);
  /// Writes only if it differs: EEPROM wears out.
  void ensure(std::uint8_t id, const Register& entry, std::int64_t value);
  void reboot(std::uint8_t id);

  // === All motors at once

  /// The same value for all; nobody answers.
  void writeAll(std::span<const std::uint8_t> ids, const Register& entry, std::int64_t value);
  /// One value each.
  void writeEach(std::span<const std::uint8_t> ids,
                 const Register& entry,
                 std::span<const std::int32_t> values);

  /// Asks all of `ids` for `size` bytes from `address`, and calls `use(index, status)` for each
  /// answer, until all have come or the patience ends. Returns how many came.
  template <class Use>
  std::size_t readAll(std::span<const std::uint8_t> ids,
                      std::uint16_t address,
                      std::uint16_t size,
                      Use&& use);

  /// Listens to nothing for a while.
  void wait(Duration time);

  [[nodiscard]] const DeviceCounters& counters();

 private:
  // Sends what is in `out_`, having forgotten what came before.
  void ask();
  // Hands the packets that come to `use` until it says true, or the patience ends.
  template <class Use>
  bool listen(Use&& use);
  // Asks what is in `out_` until motor `id` answers with `size` bytes.
  std::optional<Status> askOne(std::uint8_t id, std::size_t size);
  [[noreturn]] void fail(std::uint8_t id, std::uint16_t address, const char* what) const;
  void check(const std::optional<Status>& status, std::uint8_t id, std::uint16_t address) const;

  ByteChannel& bytes_;
  Clock clock_;
  Duration patience_;
  protocols::StreamReader<protocols::dynamixel::Framing> reader_;
  protocols::ByteBuffer out_;
  protocols::ByteBuffer answer_;  // of askOne: the status' bytes
  DeviceCounters counters_;
};

// === Details

template <class Use>
bool DynamixelBus::listen(Use&& use) {
  const TimePoint deadline = clock_() + patience_;
  bool is_done = false;
  const auto look = [&](protocols::Bytes frame) {
    const auto status = protocols::dynamixel::statusOf(protocols::dynamixel::packetOf(frame));
    // Adapters echo what was sent on one wire for both directions; an echo is no status.
    if (is_done || !status || !use(*status, is_done)) ++counters_.stray;
  };
  std::array<std::uint8_t, 512> chunk{};
  while (!is_done) {
    const std::size_t count = bytes_.receive(chunk, deadline);
    if (count == 0) {
      reader_.settle(look);
      break;
    }
    reader_.feed({chunk.data(), count}, look);
  }
  return is_done;
}

template <class Use>
std::size_t DynamixelBus::readAll(std::span<const std::uint8_t> ids,
                                  std::uint16_t address,
                                  std::uint16_t size,
                                  Use&& use) {
  std::array<bool, protocols::dynamixel::kHighestId + 1> has_answered{};
  std::size_t count = 0;
  protocols::dynamixel::encodeSyncRead(address, size, ids, out_);
  ask();
  listen([&](const Status& status, bool& is_done) {
    if (has_answered[status.id] || status.data.size() != size) return false;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] != status.id) continue;
      has_answered[status.id] = true;
      use(i, status);
      is_done = ++count == ids.size();
      return true;
    }
    return false;
  });
  counters_.missed += ids.size() - count;
  return count;
}

}  // namespace handgraft::devices
