#include "hardware/devices/serial_port.h"

#include <array>
#include <filesystem>
#include <numeric>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include "core/base/error.h"

#include "tests/hardware/protocols/hex.h"

namespace handgraft::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::ByteVector;

/// The other end of a serial port.
class SerialPortTest : public ::testing::Test {
 protected:
  SerialPortTest() {
    int slave = -1;
    std::array<char, 128> name{};
    if (openpty(&master, &slave, name.data(), nullptr, nullptr) != 0) return;
    ::close(slave);
    path = name.data();
  }

  ~SerialPortTest() override { hangUp(); }

  void hangUp() {
    if (master >= 0) ::close(master);
    master = -1;
  }

  /// Reads `count` bytes at the other end.
  ByteVector heard(std::size_t count) const {
    ByteVector bytes(count);
    std::size_t had = 0;
    while (had < count) {
      const ssize_t part = ::read(master, bytes.data() + had, count - had);
      if (part <= 0) break;
      had += static_cast<std::size_t>(part);
    }
    bytes.resize(had);
    return bytes;
  }

  static ByteVector received(SerialPort& port, std::size_t count) {
    const TimePoint deadline = std::chrono::steady_clock::now() + seconds(20);
    ByteVector bytes(count);
    std::size_t had = 0;
    while (had < count) {
      const std::size_t part = port.receive(std::span(bytes).subspan(had), deadline);
      if (part == 0) break;
      had += part;
    }
    bytes.resize(had);
    return bytes;
  }

  int master = -1;
  std::string path;
};

ByteVector allBytes() {
  ByteVector bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

TEST_F(SerialPortTest, CarriesEveryByteUnchangedAtAnyRate) {
  // Standard ones, and some that only a number can tell.
  for (const int rate : {57600, 460800, 1000000, 4000000, 31250, 250000, 470588}) {
    SerialPort port(path, rate);
    port.open();
    port.send(allBytes());
    EXPECT_EQ(heard(256), allBytes()) << rate;
    ASSERT_EQ(::write(master, allBytes().data(), 256), 256);
    EXPECT_EQ(received(port, 256), allBytes()) << rate;
  }
}

TEST_F(SerialPortTest, EchoesNothing) {
  SerialPort port(path, 115200);
  port.open();
  const ByteVector text = test::bytesOf("\x03\x04\x11\x13\r\n\x7F");
  ASSERT_EQ(::write(master, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  EXPECT_EQ(received(port, text.size()), text);
  port.send(ByteVector{0x55});
  EXPECT_EQ(heard(1), ByteVector{0x55}) << "an echo came first";
}

TEST_F(SerialPortTest, ReturnsNothingAtTheDeadline) {
  SerialPort port(path, 115200);
  port.open();
  ByteVector bytes(10);
  const TimePoint start = std::chrono::steady_clock::now();
  EXPECT_EQ(port.receive(bytes, start + milliseconds(20)), 0u);
  EXPECT_GE(std::chrono::steady_clock::now(), start + milliseconds(20));
  EXPECT_EQ(port.receive(bytes, start), 0u) << "a deadline of the past";
}

TEST_F(SerialPortTest, ReturnsWhatCameEvenAfterTheDeadline) {
  SerialPort port(path, 115200);
  port.open();
  ASSERT_EQ(::write(master, "abc", 3), 3);
  ByteVector bytes(10);
  EXPECT_EQ(port.receive(bytes, TimePoint{}), 3u);
}

TEST_F(SerialPortTest, ForgetsWhatIsDiscarded) {
  SerialPort port(path, 115200);
  port.open();
  ASSERT_EQ(::write(master, "abc", 3), 3);
  port.discard();
  ASSERT_EQ(::write(master, "d", 1), 1);
  EXPECT_EQ(received(port, 1), test::bytesOf("d"));
}

TEST_F(SerialPortTest, TheOtherEndsEndIsATransportErrorFromThenOn) {
  SerialPort port(path, 115200);
  port.open();
  hangUp();
  ByteVector bytes(10);
  const TimePoint deadline = std::chrono::steady_clock::now() + seconds(20);
  EXPECT_THROW(static_cast<void>(port.receive(bytes, deadline)), TransportError);
  EXPECT_LT(std::chrono::steady_clock::now(), deadline) << "it waited";
  EXPECT_THROW(port.send(bytes), TransportError);
  EXPECT_THROW(port.discard(), TransportError);
  EXPECT_THROW(port.open(), TransportError);
}

TEST_F(SerialPortTest, WritingToAnEndedPortIsATransportError) {
  SerialPort port(path, 115200);
  port.open();
  hangUp();
  EXPECT_THROW(port.send(ByteVector{1}), TransportError);
}

TEST_F(SerialPortTest, APortThatNobodyReadsIsATransportErrorInTheEnd) {
  SerialPort port(path, 115200);
  port.open();
  EXPECT_THROW(port.send(ByteVector(1000000)), TransportError);
}

TEST_F(SerialPortTest, OpensAnew) {
  SerialPort port(path, 115200);
  port.open();
  port.open();
  port.send(ByteVector{7});
  EXPECT_EQ(heard(1), ByteVector{7});
}

/// What is said when `port` cannot be opened; empty if it can.
std::string objectionOf(SerialPort& port) {
  try {
    port.open();
  } catch (const TransportError& error) {
    return error.what();
  }
  return "";
}

// Also to root, to whom TIOCEXCL forbids nothing: one that read along would take answers away.
TEST_F(SerialPortTest, IsOneProgramsAlone) {
  SerialPort first(path, 115200);
  first.open();
  SerialPort second(path, 115200);
  EXPECT_EQ(objectionOf(second), path + " is in use by another process");
  first.send(ByteVector{7});
  EXPECT_EQ(heard(1), ByteVector{7}) << "and the first one goes on";
  first.close();
  EXPECT_EQ(objectionOf(second), "");
}

TEST(SerialPort, SaysWhyItCannotBeOpened) {
  SerialPort missing("/no/such/port", 115200);
  EXPECT_EQ(objectionOf(missing), "/no/such/port cannot be opened: No such file or directory");
}

TEST(SerialPort, SaysWhatIsWrong) {
  SerialPort missing("/no/such/port", 115200);
  EXPECT_THROW(missing.open(), TransportError);
  SerialPort no_tty("/dev/null", 115200);
  EXPECT_THROW(no_tty.open(), TransportError);
  ByteVector bytes(1);
  EXPECT_THROW(missing.send(bytes), TransportError);
  EXPECT_THROW(static_cast<void>(missing.receive(bytes, TimePoint{})), TransportError);
  EXPECT_THROW(SerialPort("/dev/null", 0), InvalidInput);
  EXPECT_THROW(SerialPort("/dev/null", 20000000), InvalidInput);
}

}  // namespace
}  // namespace handgraft::devices
