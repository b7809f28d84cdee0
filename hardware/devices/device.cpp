#include "hardware/devices/device.h"

#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::devices {

std::string describe(Fault::Kind kind) {
  switch (kind) {
    case Fault::Kind::kNone:
      return "no fault";
    case Fault::Kind::kWire:
      return "the wire is gone";
    case Fault::Kind::kSilent:
      return "no answer";
    case Fault::Kind::kHardware:
      return "hardware error";
    case Fault::Kind::kHot:
      return "held back by the device, hot or blocked";
    case Fault::Kind::kWatchdog:
      return "the device's watchdog fired";
    case Fault::Kind::kPowerLost:
      return "lost its power";
    case Fault::Kind::kStarved:
      return "got no command for too long";
    case Fault::Kind::kBadTarget:
      return "was given a target that is no number";
    case Fault::Kind::kNoWatchdog:
      return "its own watchdog is not on, or too slow";
  }
  return "unknown fault";
}

std::string describe(const Fault& fault) {
  std::string text = describe(fault.kind);
  if (fault.motor >= 0) text = fmt::format("motor {}: {}", fault.motor, text);
  if (fault.code != 0) text += fmt::format(" (code 0x{:X})", fault.code);
  return text;
}

std::string wordsOf(std::uint32_t code, std::span<const ErrorBit> bits) {
  std::string words;
  const auto add = [&words](const std::string& word) {
    words += (words.empty() ? "" : ", ") + word;
  };
  for (const ErrorBit& each : bits) {
    if ((code & each.bit) != 0) add(each.word);
    code &= ~each.bit;
  }
  if (code != 0) add(fmt::format("0x{:X}", code));
  return words;
}

DeviceState::DeviceState(std::size_t motors)
    : position(motors, std::numeric_limits<double>::quiet_NaN()),
      velocity(position),
      current(position),
      temperature(position),
      limited(motors, 0) {}

void Device::open() {
  is_open_ = is_armed_ = false;
  fault_ = {};
  doOpen();
  is_open_ = true;
}

void Device::arm() {
  if (!is_open_) throw DeviceError("the device is not open");
  if (fault_) throw DeviceError("cannot arm: " + describe(fault_));
  if (is_armed_) return;
  try {
    yieldToStop();
    doArm();
    yieldToStop();
    is_armed_ = true;
  } catch (const TransportError& error) {
    latch({Fault::Kind::kWire, -1, 0});
    cutOff();
    throw DeviceError(error.what());
  } catch (const DeviceError&) {
    cutOff();
    throw;
  }
}

bool Device::read(DeviceState& state) {
  HANDGRAFT_REQUIRE(state.position.size() == motorCount());
  // With a fault, too, so that people see what the hand does; but not on a wire that is gone.
  if (!is_open_ || fault_.kind == Fault::Kind::kWire) return false;
  return guarded([&] {
    doRead(state);
  });
}

bool Device::write(std::span<const double> targets) {
  HANDGRAFT_REQUIRE(targets.size() == motorCount());
  if (!is_armed_ || fault_) return false;
  return guarded([&] {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (!std::isfinite(targets[i])) latch({Fault::Kind::kBadTarget, static_cast<int>(i), 0});
    }
    if (!fault_) doWrite(targets);
  });
}

bool Device::disarm() {
  is_armed_ = false;
  if (!is_open_ || fault_.kind == Fault::Kind::kWire) return false;
  bool is_off = false;
  static_cast<void>(guarded([&] {
    is_off = doDisarm();
    if (!is_off) latch({Fault::Kind::kSilent, -1, 0});
  }));
  return is_off;
}

bool Device::recount(std::size_t motor, double encoder_rad) {
  HANDGRAFT_REQUIRE(motor < motorCount() && std::isfinite(encoder_rad) && !is_armed_);
  if (!is_open_ || fault_) return false;
  bool is_done = false;
  static_cast<void>(guarded([&] {
    is_done = doRecount(motor, encoder_rad);
  }));
  return is_done;
}

void Device::stop() {
  if (is_open_) cutOff();
}

void Device::reset() {
  is_armed_ = false;
  // While the wire was gone, the device may have got errors of its own.
  if (!is_open_ || fault_.kind == Fault::Kind::kWire) open();
  try {
    doHeal();
  } catch (const TransportError&) {
    open();  // it was unplugged unnoticed, perhaps plugged in again
    doHeal();
  }
  open();
  if (fault_) throw DeviceError("still: " + describe(fault_));
}

void Device::latch(Fault fault) {
  if (!fault_) fault_ = fault;
}

void Device::yieldToStop() const {
  if (is_stop_asked_ && is_stop_asked_()) throw DeviceError("arming gave way to a stop");
}

template <class Act>
bool Device::guarded(Act&& act) {
  const bool was_faulty = static_cast<bool>(fault_);
  try {
    act();
  } catch (const TransportError&) {
    fault_ = {Fault::Kind::kWire, -1, 0};  // nothing else can be told any more
  } catch (const DeviceError&) {
    latch({Fault::Kind::kSilent, -1, 0});
  }
  if (fault_ && !was_faulty) cutOff();
  return !fault_;
}

void Device::cutOff() {
  is_armed_ = false;
  try {
    doStop();
  } catch (const TransportError&) {
    fault_ = {Fault::Kind::kWire, -1, 0};
  }
}

}  // namespace handgraft::devices
