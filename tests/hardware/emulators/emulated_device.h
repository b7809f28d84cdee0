#pragma once

#include <algorithm>
#include <chrono>
#include <deque>
#include <random>
#include <utility>
#include <vector>

#include "hardware/devices/byte_channel.h"

#include "tests/hardware/protocols/hex.h"

namespace handgraft::test {

using devices::Duration;
using devices::TimePoint;

/// What can be wrong with what a device says.
struct Ailments {
  bool is_mute = false;       ///< it hears and moves, but says nothing
  bool repeats = false;       ///< says everything twice
  Duration delay{};           ///< before everything it says
  double flip_rate = 0.0;     ///< of messages with one wrong bit
  double drop_rate = 0.0;     ///< of messages with one missing byte
  double garbage_rate = 0.0;  ///< of messages with a few random bytes before them
};

/// A device at the other end of a wire, in whatever time it is told.
class EmulatedDevice {
 public:
  virtual ~EmulatedDevice() = default;

  /// Takes what came over the wire.
  virtual void hear(protocols::Bytes bytes, TimePoint now) = 0;

  /// Moves on to `now`: motion, watchdogs, what it says by itself.
  virtual void advance(TimePoint now) = 0;

  /// What it has said that has arrived by `now`.
  ByteVector takeOutput(TimePoint now) {
    ByteVector bytes;
    while (!said_.empty() && said_.front().due <= now) {
      bytes.insert(bytes.end(), said_.front().bytes.begin(), said_.front().bytes.end());
      said_.pop_front();
    }
    return bytes;
  }

  /// Bytes that come from elsewhere on the wire, at `due`.
  void inject(ByteVector bytes, TimePoint due) {
    const auto later = std::find_if(said_.begin(), said_.end(), [&](const Message& message) {
      return message.due > due;
    });
    said_.insert(later, {due, std::move(bytes)});
  }

  Ailments ailments;

 protected:
  /// Says one message, as well as its ailments permit.
  void say(protocols::Bytes wire, TimePoint now) {
    if (ailments.is_mute) return;
    ByteVector message = vectorOf(wire);
    if (happens(ailments.flip_rate)) {
      std::uint8_t& byte = message[random_() % message.size()];
      byte = static_cast<std::uint8_t>(byte ^ 1U << random_() % 8);
    }
    if (happens(ailments.drop_rate)) {
      message.erase(message.begin() + static_cast<std::ptrdiff_t>(random_() % message.size()));
    }
    if (happens(ailments.garbage_rate)) {
      ByteVector garbage(1 + random_() % 9);
      for (std::uint8_t& byte : garbage)
        byte = static_cast<std::uint8_t>(random_());
      message.insert(message.begin(), garbage.begin(), garbage.end());
    }
    for (int i = 0; i < (ailments.repeats ? 2 : 1); ++i)
      said_.push_back({now + ailments.delay, message});
  }

 private:
  struct Message {
    TimePoint due;
    ByteVector bytes;
  };

  bool happens(double rate) {
    return rate > 0.0 && std::uniform_real_distribution<double>()(random_) < rate;
  }

  std::deque<Message> said_;
  std::mt19937 random_{42};
};

/// A servo that runs to its goal at a constant speed, in any unit.
struct EmulatedServo {
  double position = 0.0;
  double goal = 0.0;
  double speed = 1.0;     ///< units per second
  double velocity = 0.0;  ///< what it had in the last step

  void move(double seconds, bool is_powered) {
    if (seconds <= 0.0) return;
    const double before = position;
    const double way = speed * seconds;
    if (is_powered) position += std::clamp(goal - position, -way, way);
    velocity = (position - before) / seconds;
  }
};

inline double secondsOf(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace handgraft::test
