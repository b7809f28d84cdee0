#pragma once

#include <array>

#include "hardware/devices/device.h"
#include "hardware/devices/motor_scale.h"
#include "hardware/protocols/ability_hand.h"

namespace handgraft::devices {

struct AbilityHandConfig {
  std::uint8_t address = protocols::ability_hand::kDefaultAddress;
  /// Which of its replies the hand is asked for; what the others have is NaN or 0.
  protocols::ability_hand::Reply reply = protocols::ability_hand::Reply::kMotors;
  /// rad, in the hand's own order: index, middle, ring, pinky, thumb flexor, thumb rotator,
  /// which flexes negatively.
  std::array<double, protocols::ability_hand::kMotorCount> lower{0, 0, 0, 0, 0, -1.74};
  std::array<double, protocols::ability_hand::kMotorCount> upper{1.74, 1.74, 1.74,
                                                                 1.74, 1.74, 0};
  /// Which of its motors is which of ours.
  std::array<std::size_t, protocols::ability_hand::kMotorCount> order{0, 1, 2, 3, 4, 5};
  Duration reply_timeout = std::chrono::milliseconds(5);
  int tolerated_misses = 3;  ///< answers in a row
  /// Our own longest silence while armed. The hand goes its own way after 300 ms.
  Duration longest_gap = std::chrono::milliseconds(100);
  Duration hot_patience = std::chrono::milliseconds(500);  ///< that a motor may be held back
};

/// A PSYONIC Ability Hand on a UART, in position mode.
///
/// Every command is answered by one reply, so that a cycle takes one exchange: `write` sends
/// the targets, the `read` after it takes what the hand answered. Without a write, `read` asks.
///
/// The hand has no switch for its motors. Armed means that it obeys us (API mode); it ends by
/// the exit command or 300 ms of silence, and then the hand obeys its wearer again, who may
/// move it. No answer tells the mode, so an exit is sent three times and taken for done.
class AbilityHandDevice final : public Device {
 public:
  /// `bytes` has to live as long as this. Errors: InvalidInput for limits beyond 150 degrees,
  /// timings that are not positive, or a gap that is not shorter than the hand's 300 ms.
  AbilityHandDevice(AbilityHandConfig config, ByteChannel& bytes, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override;
  [[nodiscard]] DeviceCounters counters() const override;

  /// Uncalibrated, six of each finger and the thumb; nothing unless a reply with touch is asked
  /// for.
  [[nodiscard]] std::span<const double> touch() const override;

 private:
  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;

  void send();
  void askForState();
  // Waits for the reply to what was sent; false at the timeout.
  bool takeReply();
  // Asks until a reply comes; throws DeviceError without.
  void askSurely();
  void watchLimited(TimePoint now);

  AbilityHandConfig config_;
  ByteChannel& bytes_;
  Clock clock_;
  std::array<MotorScale, protocols::ability_hand::kMotorCount> scales_;
  protocols::StreamReader<protocols::ability_hand::Framing> reader_;
  protocols::ByteBuffer out_;
  protocols::ability_hand::State last_;
  TimePoint time_;        // of `last_`
  TimePoint sent_time_;   // of the last command
  bool is_owed_ = false;  // a reply
  bool obeys_ = false;    // API mode
  int misses_ = 0;
  std::array<double, protocols::ability_hand::kTouchCount> touch_{};
  std::array<TimePoint, protocols::ability_hand::kMotorCount> free_time_;  // last not limited
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
