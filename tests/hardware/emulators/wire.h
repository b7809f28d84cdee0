#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// What joins a driver and an emulated device.
class Wire {
 public:
  virtual ~Wire() = default;

  /// The driver's end.
  virtual devices::ByteChannel& channel() = 0;
  virtual devices::Clock clock() = 0;

  /// Lets time pass at the device.
  virtual void pass(Duration time) = 0;

  virtual void unplug() = 0;
  virtual void plug() = 0;

  /// To be held while the test looks at the device.
  virtual std::unique_lock<std::mutex> hold() = 0;
};

/// A wire in a time of its own: whoever waits moves it on.
std::unique_ptr<Wire> makeVirtualWire(EmulatedDevice& device);

/// A line of `bits_per_second`, or a USB adapter of which that is a number alone.
enum class Line { kUart, kUsb };

/// A pseudo terminal, with the device on a thread, in real time: what the device says takes as
/// long as it does on such a line.
std::unique_ptr<Wire> makePty(EmulatedDevice& device,
                              int bits_per_second,
                              Line line = Line::kUart);

/// The path of the tty that a pty stands for.
std::string portOf(Wire& pty);

/// Every message that a driver sent over a virtual wire, since this was last asked.
std::vector<ByteVector> takeSent(Wire& virtual_wire);

}  // namespace handgraft::test
