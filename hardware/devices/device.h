#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hardware/devices/byte_channel.h"

namespace handgraft::devices {

/// Why a device must not move. Latched: it stays until `Device::reset`.
struct Fault {
  enum class Kind : std::uint8_t {
    kNone,
    kWire,        ///< the port is gone
    kSilent,      ///< a motor has not answered several times in a row
    kHardware,    ///< the device says so; `code` is its own error
    kHot,         ///< the device holds a motor back for too long; `code` tells which
    kWatchdog,    ///< the device's own watchdog fired
    kPowerLost,   ///< a motor is off that ought to be on
    kStarved,     ///< we were silent for so long that the device may have gone its own way
    kBadTarget,   ///< we were asked to send what is no number
    kNoWatchdog,  ///< the device's own watchdog did not prove itself: it would not stop with us
  };

  Kind kind = Kind::kNone;
  int motor = -1;  ///< index; -1: the whole device
  std::uint32_t code = 0;

  explicit operator bool() const { return kind != Kind::kNone; }
};

/// On one line, for people; without the motor if it is named elsewhere.
std::string describe(const Fault& fault);
std::string describe(Fault::Kind kind);

/// One bit of a device's error.
struct ErrorBit {
  std::uint32_t bit;
  const char* word;
};

/// The words of all bits that are set, joined by ", "; those without one as a number.
std::string wordsOf(std::uint32_t code, std::span<const ErrorBit> bits);

/// A motor without power that does not answer is silent after so long; under power it takes
/// `tolerated_misses` answers.
inline constexpr std::chrono::seconds kIdlePatience(1);

/// What a device measured, one entry per motor; NaN where it does not tell.
struct DeviceState {
  TimePoint time;                     ///< when the oldest of the positions was received
  std::vector<double> position;       ///< rad
  std::vector<double> velocity;       ///< rad/s
  std::vector<double> current;        ///< A
  std::vector<double> temperature;    ///< degrees Celsius
  std::vector<std::uint8_t> limited;  ///< 1: held back by the device, does not quite obey

  explicit DeviceState(std::size_t motors);
};

/// What went over the wire since the start.
struct DeviceCounters {
  std::uint64_t frames = 0;         ///< good ones that came
  std::uint64_t damaged = 0;        ///< with a wrong checksum
  std::uint64_t garbage_bytes = 0;  ///< that belonged to no frame
  std::uint64_t missed = 0;         ///< answers that did not come in time
  std::uint64_t stray = 0;          ///< good frames that answered nothing
};

/// Motors on the other end of a wire, in rad of each motor.
///
/// `open` leaves them off; `arm` switches them on where they stand. Once a period: `read`, then
/// `write` while armed. Whatever goes wrong in between is a fault: it is latched, the motors
/// are cut off as well as the wire permits, and nothing moves until `reset` and `arm`, both
/// deliberate. Every device also has a watchdog of its own running while armed, so that the
/// motors stop if this process does.
///
/// `read`, `write` and `stop` allocate nothing, unless a wire is lost, take no lock and wait no
/// longer than the device's reply timeout; they throw nothing but BrokenContract. The others
/// may take a second.
class Device {
 public:
  virtual ~Device() = default;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] virtual std::size_t motorCount() const = 0;

  /// Connects, checks that the device is the one expected, and switches its motors off. A
  /// device that is broken is open with a fault.
  /// Errors: TransportError, DeviceError if it does not answer as it should.
  void open();

  /// Motors on, each with the place where it stands as its target; the device's watchdog on,
  /// and proved to be: by reading it back, or by silence that it ends, once after each `open`.
  /// Errors: DeviceError with a fault latched, if the device does not do as told, or if a stop
  /// is asked for meanwhile (`stopWhen`); the motors are off then.
  void arm();

  /// Takes the measured state; motors that did not answer keep what they said before. False if
  /// a fault is latched.
  bool read(DeviceState& state);

  /// Sends targets (rad, one per motor), to the nearest unit of the device, inwards at a limit.
  /// Nothing is sent, and false returned, when not armed or with a fault latched.
  bool write(std::span<const double> targets);

  /// Motors off; true once the device has said so, where it can. Otherwise a fault is latched.
  bool disarm();

  /// The device's own stop is the next thing on the wire; nothing is waited for.
  void stop();

  /// Forgets a fault once its cause is gone: reconnects, restarts motors that need it. Leaves
  /// the motors off.
  /// Errors: as `open`; DeviceError if the cause is still there.
  void reset();

  /// Whether somebody waits for a stop: `is_asked` is called between the steps of `arm`, which
  /// gives up then, by the device's own stop. Without it arming goes through. It may be called
  /// from whatever thread arms, and must not block.
  void stopWhen(std::function<bool()> is_asked) { is_stop_asked_ = std::move(is_asked); }

  /// Lets a motor count from elsewhere: where it stands, its encoder tells `encoder_rad` from
  /// now on, until it restarts. Only while disarmed. False if the device cannot, or did not.
  bool recount(std::size_t motor, double encoder_rad);

  /// From now on this motor's current is told anew in every period, or NaN.
  virtual void attend(std::size_t /*motor*/) {}

  [[nodiscard]] const Fault& fault() const { return fault_; }

  [[nodiscard]] bool isArmed() const { return is_armed_; }

  [[nodiscard]] virtual DeviceCounters counters() const = 0;

  /// What a fault's code means, in words of the device, joined by ", "; empty: not known.
  [[nodiscard]] virtual std::string meaningOf(std::uint32_t /*code*/) const { return {}; }

  /// N, what the device feels, in its own order; empty: nothing. Valid until the next `read`.
  [[nodiscard]] virtual std::span<const double> touch() const { return {}; }

 protected:
  /// Latches the first fault; the later ones are its consequences.
  void latch(Fault fault);

  /// To be called between the steps of `doArm`, each no longer than a few answers of the
  /// device. Errors: DeviceError if a stop is asked for.
  void yieldToStop() const;

 private:
  // What the public ones do, without their guards. TransportError becomes the fault kWire;
  // after a fault in `doRead` and `doWrite`, `doStop` is called.
  virtual void doOpen() = 0;
  virtual void doArm() = 0;
  virtual void doRead(DeviceState& state) = 0;
  virtual void doWrite(std::span<const double> targets) = 0;
  virtual bool doDisarm() = 0;
  virtual void doStop() = 0;
  // Makes the device forget its errors; doOpen follows.
  virtual void doHeal() = 0;

  virtual bool doRecount(std::size_t /*motor*/, double /*encoder_rad*/) { return false; }

  // Runs `act`; latches what it throws, and cuts off the motors if they were on.
  template <class Act>
  bool guarded(Act&& act);
  void cutOff();

  std::function<bool()> is_stop_asked_;
  Fault fault_;
  bool is_open_ = false;
  bool is_armed_ = false;
};

}  // namespace handgraft::devices
