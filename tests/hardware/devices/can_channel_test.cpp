#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/error.h"
#include "hardware/devices/odrive_hand.h"
#include "hardware/devices/slcan_channel.h"
#include "hardware/devices/socket_can_channel.h"
#include "hardware/protocols/socket_can_frame.h"

#include "tests/hardware/emulators/odrive_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::devices {
namespace {

using protocols::CanFrame;
using protocols::makeCanFrame;
using std::chrono::milliseconds;
using std::chrono::seconds;
using test::ByteVector;

TimePoint soon() {
  return std::chrono::steady_clock::now() + seconds(10);
}

// === Lines of text

/// Answers every command as it is told to.
class ScriptedAdapter final : public test::EmulatedDevice {
 public:
  explicit ScriptedAdapter(std::string answer) : answer_(std::move(answer)) {}

  void hear(protocols::Bytes bytes, TimePoint now) override {
    for (const std::uint8_t byte : bytes) {
      heard += static_cast<char>(byte);
      if (byte == '\r' && !answer_.empty()) say(test::bytesOf(answer_), now);
    }
  }

  void advance(TimePoint) override {}

  std::string heard;

 private:
  std::string answer_;
};

TEST(SlcanChannel, OpensTheAdapterAtTheRate) {
  for (const char* answer : {"\r", ""}) {  // some adapters do not answer
    ScriptedAdapter adapter(answer);
    const auto wire = test::makeVirtualWire(adapter);
    SlcanChannel channel(wire->channel(), 500000, wire->clock());
    channel.open();
    EXPECT_EQ(adapter.heard, "\rC\rS6\rO\r");
    channel.close();
    EXPECT_EQ(adapter.heard, "\rC\rS6\rO\rC\r");
  }
}

TEST(SlcanChannel, OpensAnAdapterThatIsOpenOrClosed) {
  for (const bool is_open : {false, true}) {
    test::ODriveEmulator bus({0}, protocols::odrive::Firmware::k06);
    test::SlcanEmulator adapter(bus);
    adapter.is_open = is_open;
    const auto wire = test::makeVirtualWire(adapter);
    SlcanChannel channel(wire->channel(), 1000000, wire->clock());
    channel.open();
    EXPECT_TRUE(adapter.is_open);
    EXPECT_EQ(adapter.rate, '8');
    channel.close();
    EXPECT_FALSE(adapter.is_open);
  }
}

TEST(SlcanChannel, AnAdapterThatRefusesIsATransportError) {
  ScriptedAdapter adapter("\a");
  const auto wire = test::makeVirtualWire(adapter);
  SlcanChannel channel(wire->channel(), 500000, wire->clock());
  EXPECT_THROW(channel.open(), TransportError);
}

TEST(SlcanChannel, RefusesRatesWithoutACommand) {
  ScriptedAdapter adapter("\r");
  const auto wire = test::makeVirtualWire(adapter);
  EXPECT_THROW(SlcanChannel(wire->channel(), 300000, wire->clock()), InvalidInput);
}

TEST(SlcanChannel, GivesEveryFrameOfABurst) {
  ScriptedAdapter adapter("\r");
  const auto wire = test::makeVirtualWire(adapter);
  SlcanChannel channel(wire->channel(), 500000, wire->clock());
  channel.open();
  for (std::uint32_t id = 0; id < 0x200; ++id) {
    protocols::ByteBuffer line;
    protocols::slcan::encode(makeCanFrame(id, {}), line);
    adapter.inject(test::vectorOf(line.bytes()), wire->clock()());
  }
  CanFrame frame;
  for (std::uint32_t id = 0; id < 0x200; ++id) {
    ASSERT_TRUE(channel.receive(frame, wire->clock()()));
    ASSERT_EQ(frame, makeCanFrame(id, {}));
  }
  EXPECT_FALSE(channel.receive(frame, wire->clock()() + milliseconds(5)));
}

// === The kernel's sockets; a pair of them carries the same messages as a bus

class SocketCan : public ::testing::Test {
 protected:
  SocketCan()
      : channel([this] {
          std::array<int, 2> ends{};
          if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()) != 0)
            throw TransportError("no socket pair");
          other = ends[1];
          return ends[0];
        }) {
    channel.open();
  }

  ~SocketCan() override { hangUp(); }

  void hangUp() {
    if (other >= 0) ::close(other);
    other = -1;
  }

  void say(const struct can_frame& raw) const {
    ASSERT_EQ(::send(other, &raw, sizeof(raw), 0), static_cast<ssize_t>(sizeof(raw)));
  }

  int other = -1;
  SocketCanChannel channel;
};

TEST_F(SocketCan, CarriesFramesBothWays) {
  const CanFrame there = makeCanFrame(0x2C, ByteVector{1, 2, 3});
  channel.send(there);

  struct can_frame raw {};

  ASSERT_EQ(recv(other, &raw, sizeof(raw), 0), static_cast<ssize_t>(sizeof(raw)));
  EXPECT_EQ(protocols::fromSocketCan(raw).frame, there);

  const CanFrame back = makeCanFrame(0x29, ByteVector{9, 8, 7, 6});
  say(protocols::toSocketCan(back));
  CanFrame frame;
  ASSERT_TRUE(channel.receive(frame, soon()));
  EXPECT_EQ(frame, back);
}

TEST_F(SocketCan, ReceivesNothingAtTheDeadlineButWhatCameBefore) {
  CanFrame frame;
  EXPECT_FALSE(channel.receive(frame, std::chrono::steady_clock::now() + milliseconds(5)));
  say(protocols::toSocketCan(makeCanFrame(1, {})));
  EXPECT_TRUE(channel.receive(frame, TimePoint{}));
}

TEST_F(SocketCan, ABusThatIsGoneIsATransportError) {
  hangUp();
  CanFrame frame;
  EXPECT_THROW(channel.receive(frame, soon()), TransportError);
  EXPECT_THROW(channel.send(frame), TransportError);
  EXPECT_THROW(channel.receive(frame, soon()), TransportError) << "and stays so";
}

TEST_F(SocketCan, LeavingTheBusIsATransportErrorOtherErrorsAreCounted) {
  struct can_frame raw {};

  raw.can_id = CAN_ERR_FLAG | CAN_ERR_TX_TIMEOUT;
  say(raw);
  say(protocols::toSocketCan(makeCanFrame(1, {})));
  CanFrame frame;
  EXPECT_TRUE(channel.receive(frame, soon()));
  EXPECT_EQ(channel.damaged(), 1u);
  raw.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
  say(raw);
  EXPECT_THROW(channel.receive(frame, soon()), TransportError);
}

TEST(SocketCanInterface, OpensAnInterfaceOfTheKernel) {
  const int probe = socket(PF_CAN, SOCK_RAW, 3);
  if (probe < 0) {
    EXPECT_THROW(canInterface("vcan0", {1})(), TransportError);
    GTEST_SKIP() << "this kernel has no AF_CAN";
  }
  ::close(probe);
  EXPECT_THROW(canInterface("no_such_can", {1})(), TransportError);
}

TEST(SocketCanODrive, MovesItsAxes) {
  test::ODriveEmulator bus({0, 5}, protocols::odrive::Firmware::k06);
  for (const int node : {0, 5})
    bus.axis(node).watchdog = seconds(1);
  std::atomic<bool> is_over = false;

  ODriveConfig config;
  const MotorScale scale{2.0 * std::numbers::pi, 0.0, 1, -3.0, 6.0};
  config.axes = {{0, scale}, {5, scale}};
  config.reply_timeout = seconds(1);
  config.watchdog = seconds(1);
  config.heartbeat_timeout = seconds(10);
  config.state_timeout = seconds(10);
  std::array<int, 2> ends{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()), 0);
  std::thread server([&] {
    while (!is_over) {
      pollfd poll_end = {ends[1], POLLIN, 0};
      static_cast<void>(poll(&poll_end, 1, 1));
      const TimePoint now = std::chrono::steady_clock::now();
      struct can_frame raw {};
      while (recv(ends[1], &raw, sizeof(raw), MSG_DONTWAIT) == sizeof(raw))
        bus.hear(protocols::fromSocketCan(raw).frame, now);
      bus.advance(now);
      for (const CanFrame& frame : bus.takeFrames()) {
        raw = protocols::toSocketCan(frame);
        static_cast<void>(::send(ends[1], &raw, sizeof(raw), MSG_DONTWAIT));
      }
    }
  });

  SocketCanChannel can([&] {
    return dup(ends[0]);
  });
  ODriveHand hand(config, can, std::chrono::steady_clock::now);
  DeviceState state(2);
  hand.open();
  hand.arm();
  const std::vector<double> targets = {0.7, -0.4};
  bool has_arrived = false;
  for (int i = 0; i < 5000 && !has_arrived; ++i) {
    ASSERT_TRUE(hand.read(state)) << describe(hand.fault());
    ASSERT_TRUE(hand.write(targets)) << describe(hand.fault());
    has_arrived = std::abs(state.position[0] - targets[0]) < 1e-5 &&
                  std::abs(state.position[1] - targets[1]) < 1e-5;
  }
  EXPECT_TRUE(has_arrived);
  EXPECT_TRUE(hand.disarm());
  is_over = true;
  server.join();
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace handgraft::devices
