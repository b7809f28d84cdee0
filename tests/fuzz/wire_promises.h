#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "hardware/devices/device.h"
#include "hardware/protocols/stream_reader.h"

#include "tests/fuzz/promise.h"
#include "tests/hardware/emulators/emulated_device.h"

/// What must hold of every protocol on a wire: of its frames, however they are split, and of a
/// driver whatever its device answers.
namespace handgraft::fuzz {

using protocols::ByteBuffer;
using protocols::Bytes;
using Frames = std::vector<std::vector<std::uint8_t>>;

/// What a reader finds in `bytes`, fed in pieces of `step`, and then nothing more.
template <class F>
Frames framesIn(Bytes bytes, std::size_t step) {
  Frames found;
  const auto keep = [&](Bytes frame) {
    found.emplace_back(frame.begin(), frame.end());
  };
  protocols::StreamReader<F> reader;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    reader.feed(bytes.subspan(at, std::min(step, bytes.size() - at)), keep);
    HANDGRAFT_PROMISE(reader.pending() < F::kLongest);
  }
  HANDGRAFT_PROMISE(reader.counters().garbage_bytes <= bytes.size());
  reader.settle(keep);
  HANDGRAFT_PROMISE(reader.pending() == 0);
  HANDGRAFT_PROMISE(reader.counters().frames == found.size());
  return found;
}

/// Each frame in `bytes` goes to `use`; the same ones are found however the bytes are split.
template <class F, class Use>
void checkStream(Bytes bytes, std::size_t step, Use use) {
  const Frames frames = framesIn<F>(bytes, step);
  HANDGRAFT_PROMISE(framesIn<F>(bytes, std::max<std::size_t>(bytes.size(), 1)) == frames);
  HANDGRAFT_PROMISE(framesIn<F>(bytes, 1) == frames);
  for (const std::vector<std::uint8_t>& frame : frames)
    use(Bytes(frame));
}

/// `wire` is one frame, and its content is `content`.
template <class F>
void checkFrame(Bytes wire, Bytes content) {
  const Frames found = framesIn<F>(wire, wire.size());
  HANDGRAFT_PROMISE(found.size() == 1);
  HANDGRAFT_PROMISE(
      std::equal(found[0].begin(), found[0].end(), content.begin(), content.end()));
}

/// Pieces of `bytes` as they are, or as frames with a right checksum: chance alone would hardly
/// make one. `frame(content, wire)` makes a frame.
template <class Frame>
std::vector<std::uint8_t> framed(Bytes bytes, Frame frame) {
  std::vector<std::uint8_t> wires;
  while (!bytes.empty()) {
    const bool is_garbage = bytes[0] >= 0xE0;
    const std::size_t count = std::min<std::size_t>(bytes[0] % 80, bytes.size() - 1);
    const Bytes content = bytes.subspan(1, count);
    ByteBuffer wire;
    if (is_garbage) {
      wire.append(content);
    } else {
      frame(content, wire);
    }
    wires.insert(wires.end(), wire.bytes().begin(), wire.bytes().end());
    bytes = bytes.subspan(1 + count);
  }
  return wires;
}

/// A wire on which everything that is asked is answered by the next few bytes.
class Answers final : public devices::ByteChannel {
 public:
  Answers(Bytes bytes, std::size_t step) : bytes_(bytes), step_(step) {}

  void open() override {}

  void close() override {}

  void send(Bytes) override {}

  void discard() override {}

  std::size_t receive(std::span<std::uint8_t> into, devices::TimePoint deadline) override {
    // Now and then nothing comes in time.
    const std::size_t count = std::min({step_, bytes_.size(), into.size()});
    if (count == 0 || ++calls_ % 5 == 0) {
      now_ = std::max(now_, deadline) + std::chrono::microseconds(1);
      return 0;
    }
    std::copy_n(bytes_.begin(), count, into.begin());
    bytes_ = bytes_.subspan(count);
    now_ += std::chrono::microseconds(10);
    return count;
  }

  devices::Clock clock() {
    return [this] {
      return now_;
    };
  }

 private:
  Bytes bytes_;
  std::size_t step_;
  unsigned calls_ = 0;
  devices::TimePoint now_{std::chrono::seconds(1)};
};

/// A wire to an emulated device that is healthy until `failing` is set, and from then on is
/// answered by the next few bytes.
class FailingWire final : public devices::ByteChannel {
 public:
  FailingWire(test::EmulatedDevice& device, Bytes bytes, std::size_t step)
      : device_(device), answers_(bytes, step) {}

  void open() override {}

  void close() override {}

  void send(Bytes bytes) override {
    if (!is_failing) device_.hear(bytes, now_);
  }

  void discard() override {
    if (!is_failing) device_.takeOutput(now_);
  }

  std::size_t receive(std::span<std::uint8_t> into, devices::TimePoint deadline) override {
    if (is_failing) {
      const std::size_t count = answers_.receive(into, deadline);
      now_ = count > 0 ? now_ + std::chrono::microseconds(10)
                       : std::max(now_, deadline) + std::chrono::microseconds(1);
      return count;
    }
    while (waiting_.empty()) {
      const test::ByteVector more = device_.takeOutput(now_);
      waiting_.insert(waiting_.end(), more.begin(), more.end());
      if (!waiting_.empty()) break;
      if (now_ >= deadline) return 0;
      now_ += std::chrono::microseconds(500);
      device_.advance(now_);
    }
    const std::size_t count = std::min(into.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, into.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  devices::Clock clock() {
    return [this] {
      return now_;
    };
  }

  bool is_failing = false;

 private:
  test::EmulatedDevice& device_;
  Answers answers_;
  test::ByteVector waiting_;
  devices::TimePoint now_{std::chrono::seconds(1)};
};

/// Opens, arms, runs for a while, heals and stops: whatever the device says to that, or once it
/// is under power if `fail` says when it begins to fail.
inline void drive(devices::Device& device, bool* fail = nullptr) {
  devices::DeviceState state(device.motorCount());
  const std::vector<double> targets(device.motorCount(), 0.1);
  try {
    device.open();
    device.arm();
    if (fail != nullptr) {
      HANDGRAFT_PROMISE(device.read(state) && device.write(targets));
      *fail = true;
    }
    for (int i = 0; i < 20; ++i) {
      if (!device.read(state) || !device.write(targets)) device.reset();
    }
  } catch (const DeviceError&) {
  } catch (const TransportError&) {
  }
  device.stop();
  HANDGRAFT_PROMISE(!device.isArmed());
}

}  // namespace handgraft::fuzz
