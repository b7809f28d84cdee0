#pragma once

#include <string_view>

#include "hardware/bridge/motion_state.h"
#include "hardware/config/hand_config.h"

namespace handgraft::bridge {

/// Whether the zeros of a hand's motors are known. Incremental encoders forget theirs when they
/// restart: a marked one tells that by its count; any other may have restarted whenever it was
/// not heard of for long.
class EncoderZeroMonitor {
 public:
  explicit EncoderZeroMonitor(const config::HandConfig& config);

  [[nodiscard]] bool areKnown() const { return are_known_; }

  /// Why they are not; empty: they are.
  [[nodiscard]] const FixedText& why() const { return why_; }

  /// The device may have restarted: it was opened, or its wire was lost.
  void noteAway() { was_away_ = true; }

  /// It was heard of all the time.
  void noteHeard() { was_away_ = false; }

  void find();
  void lose(std::string_view why);

  /// Looks at what was measured by `now`. Allocates nothing.
  void see(const config::HandConfig& config,
           const devices::DeviceState& measured,
           devices::TimePoint now);

 private:
  void loseFor(std::string_view motor, std::string_view why);

  bool are_known_;
  bool was_away_ = true;  // whether it restarted since it was homed, only a mark tells
  FixedText why_;
};

}  // namespace handgraft::bridge
