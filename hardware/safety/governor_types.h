#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hardware/safety/joint_limiter.h"

namespace handgraft::safety {

using Time = std::chrono::steady_clock::time_point;
using Milliseconds = std::chrono::milliseconds;

/// README of this folder has the table of what leads where.
enum class GovernorState {
  kDisconnected,  ///< no device; motors off as far as we know
  kIdle,          ///< device readable, motors off
  kArmed,         ///< motors follow the stream
  kHolding,       ///< motors brake, then stand still under power, then go off
  kFault,         ///< motors off; latched until `reset` and the cause gone
  kEStop,         ///< motors brake and go off, or are cut; latched until `reset`
};

/// Why a sample was not followed. kAccepted first; the rest in the order of the checks.
enum class SampleVerdict {
  kAccepted,
  kNotFinite,
  kWrongLength,
  kWrongNames,
  kRepeated,   ///< the same number again
  kLate,       ///< a smaller number than the newest
  kBackwards,  ///< its sender's clock ran backwards
  kTooOld,     ///< it took too long on its way, told by its sender's clock
  kCount,
};

/// Why a request was not obeyed.
enum class Refusal {
  kNone,
  kNotConnected,
  kEStop,          ///< reset first
  kFault,          ///< reset first
  kNoFreshStream,  ///< no valid sample within the stale time
  kNotMeasured,    ///< no fresh measured pose
  kOutOfRange,     ///< measured far outside the limits: calibration or encoder
  kMotorsOutside,  ///< a motor stands far outside its own range, whatever the joints say
  kMotorsOn,       ///< the device reports power that nobody ordered, or brakes still
  kNothingToReset,
  kCount,
};

/// What led to kFault; kept while latched.
enum class FaultCause {
  kNone,
  kDevice,          ///< the device says so; its code is told beside
  kDeviceLost,      ///< disconnected under power
  kDeviceSilent,    ///< measured state too old under power
  kBadMeasurement,  ///< wrong length or not finite
  kOutOfRange,      ///< measured far outside the limits under power
  kMotorsOutside,   ///< a motor far outside its own range under power
  kNoPower,         ///< motors did not go on when ordered
  kPowerLost,       ///< motors went off by themselves: the device's own watchdog or shutdown
  kStaysOn,         ///< motors did not go off when ordered
  kOverruns,        ///< too many late periods one after another
  kGap,             ///< one period far too late: we were suspended
  kOutput,          ///< the last assertion: what was to leave broke a limit
  kCount,
};

/// Why the hand holds.
enum class HoldCause { kNone, kDisarmed, kStale, kStreamChanged, kMotorLimited };

const char* toString(GovernorState state);
const char* toString(SampleVerdict verdict);
const char* toString(Refusal refusal);
const char* toString(FaultCause cause);
const char* toString(HoldCause cause);

/// How an emergency stop ends motion; IEC 60204-1 calls them categories 1 and 0.
enum class StopMode {
  kBrake,  ///< decelerate within the limits, then power off
  kCut,    ///< the device's own stop frame is the next on the wire
};

/// A distance that a joint may be off, by whether it turns or slides.
struct Distance {
  double rad = 0;
  double m = 0;

  [[nodiscard]] double of(const JointLimits& joint) const { return joint.slides ? m : rad; }
};

struct GovernorOptions {
  std::vector<std::string> names;   ///< of the joints, unique
  std::vector<JointLimits> limits;  ///< one per joint
  double period_s = 0.01;

  Milliseconds stale_after{100};  ///< without a valid sample: hold
  Milliseconds hold_for{1000};    ///< from the beginning of a hold to power off
  Distance near{0.1, 1e-3};       ///< arming farther from the first target: ramp
  double ramp_share = 0.1;        ///< of each velocity limit, until the target is near
  Distance step{0.5, 5e-3};       ///< a target jumps farther, or is so far from rest: ramp
  StopMode stop_mode = StopMode::kBrake;
  Milliseconds brake_within{1000};  ///< after it power goes off, whatever still moves

  Milliseconds device_silent_after{100};  ///< age of the measured state
  Milliseconds power_within{2000};        ///< from the order to the device's report
  Milliseconds reset_within{3000};        ///< for the device to clear its faults
  Milliseconds limited_for{1000};         ///< a motor that does not obey: hold
  Distance outside{0.2, 2e-3};            ///< beyond the limits: a broken measurement

  unsigned overruns_in_a_row = 10;
  Milliseconds longest_gap{100};  ///< between two ticks under power
};

/// One pose that the stream asks for.
struct TargetSample {
  std::uint64_t stream = 0;    ///< who speaks: another value is another stream
  std::uint64_t sequence = 0;  ///< grows within a stream
  std::int64_t source_ns = 0;  ///< the sender's clock; 0: not told
  std::span<const std::string> names;
  std::span<const double> joint_rad;  ///< m of a joint that slides, as everywhere
};

/// What the device says of itself, once a period.
struct DeviceReport {
  bool connected = false;        ///< it answers, and its position has been read
  bool powered = false;          ///< all motors on
  std::uint32_t fault_code = 0;  ///< 0: none
  bool limited = false;          ///< a motor says that it does not obey (hot, stalled, limited)
  Time measured_at{};
  std::span<const double> position;  ///< rad, one per joint
  bool motors_outside = false;       ///< a motor stands far outside its own range
};

enum class Power {
  kOff,
  kOn,
  kCut,  ///< off by the device's own emergency stop, before anything else
};

/// What the device is to do now.
struct MotorOrder {
  Power power = Power::kOff;
  bool clear_faults = false;          ///< once after an accepted `reset`
  std::span<const double> positions;  ///< rad, one per joint, under power; else empty
};

struct GovernorCounters {
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;
  Time::duration longest_gap{};
  std::array<std::uint64_t, static_cast<std::size_t>(SampleVerdict::kCount)> samples{};
  std::array<std::uint64_t, static_cast<std::size_t>(Refusal::kCount)> refusals{};
  std::array<std::uint64_t, static_cast<std::size_t>(FaultCause::kCount)> faults{};
  std::uint64_t clamped_samples = 0;  ///< accepted, with a target outside the limits
  std::uint64_t stale_streams = 0;
  std::uint64_t emergency_stops = 0;
  std::uint64_t at_velocity = 0;      ///< joint periods at the velocity limit
  std::uint64_t at_acceleration = 0;  ///< joint periods at the acceleration limit
};

}  // namespace handgraft::safety
