#include "hardware/devices/serial_port.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/base/error.h"

namespace handgraft::devices {

namespace {

constexpr int kSlowest = 300, kFastest = 12000000;
constexpr double kRateTolerance = 0.03;
constexpr std::chrono::milliseconds kSendPatience(100);  // a driver's buffer empties in less

std::string textOf(int error) {
  return std::generic_category().message(error);
}

// FTDI's adapters otherwise keep what they got for up to 16 ms. Others, and ptys, refuse.
void askForLowLatency(int file) {
  serial_struct settings{};
  if (ioctl(file, TIOCGSERIAL, &settings) != 0) return;
  settings.flags |= ASYNC_LOW_LATENCY;
  static_cast<void>(ioctl(file, TIOCSSERIAL, &settings));
}

}  // namespace

SerialPort::SerialPort(std::string path, int bits_per_second)
    : path_(std::move(path)), bits_per_second_(bits_per_second) {
  if (bits_per_second < kSlowest || bits_per_second > kFastest) {
    rejectInput("serial port {}: {} bit/s is outside {} to {}", quoted(path_), bits_per_second,
                kSlowest, kFastest);
  }
}

SerialPort::~SerialPort() {
  close();
}

void SerialPort::open() {
  close();
  file_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) {
    throw TransportError(errno == EBUSY
                             ? fmt::format("{} is in use by another process", path_)
                             : fmt::format("{} cannot be opened: {}", path_, textOf(errno)));
  }
  try {
    claim();
    configure();
    askForLowLatency(file_);
    discard();
  } catch (...) {
    close();
    throw;
  }
}

// Two programs on one wire read each other's answers. TIOCEXCL keeps every other one out but
// root's; the lock keeps out another of ours, whoever runs it.
void SerialPort::claim() {
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail("cannot be locked");
    throw TransportError(fmt::format("{} is in use by another process", path_));
  }
  if (ioctl(file_, TIOCEXCL) != 0) fail("is no tty");
}

void SerialPort::configure() const {
  // termios2 takes any rate as a number; <termios.h> knows a few.
  termios2 settings{};
  const auto refuse = [&](const char* what) {
    throw TransportError(fmt::format("{}: {}: {}", path_, what, textOf(errno)));
  };
  if (ioctl(file_, TCGETS2, &settings) != 0) refuse("is no tty");
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(bits_per_second_);
  settings.c_cc[VMIN] = 1;  // so that reading 0 bytes means the end and nothing else
  settings.c_cc[VTIME] = 0;
  if (ioctl(file_, TCSETS2, &settings) != 0) refuse("cannot be configured");
  if (ioctl(file_, TCGETS2, &settings) != 0) refuse("cannot be configured");
  const double given = settings.c_ospeed;
  if (std::abs(given - bits_per_second_) > kRateTolerance * bits_per_second_) {
    throw TransportError(
        fmt::format("{}: gives {} bit/s instead of {}", path_, given, bits_per_second_));
  }
}

void SerialPort::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

void SerialPort::send(protocols::Bytes bytes) {
  const TimePoint deadline = std::chrono::steady_clock::now() + kSendPatience;
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_, bytes.data(), bytes.size());
    if (count > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {
      if (!waitFor(POLLOUT, deadline)) fail("takes no more bytes");
    } else if (count == 0 || errno != EINTR) {
      fail("cannot be written");
    }
  }
}

std::size_t SerialPort::receive(std::span<std::uint8_t> into, TimePoint deadline) {
  while (true) {
    const ssize_t count = ::read(file_, into.data(), into.size());
    if (count > 0) return static_cast<std::size_t>(count);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0 || errno != EAGAIN) fail("is gone");
    if (!waitFor(POLLIN, deadline)) return 0;
  }
}

void SerialPort::discard() {
  if (ioctl(file_, TCFLSH, TCIFLUSH) != 0) fail("cannot be flushed");
}

bool SerialPort::waitFor(short events, TimePoint deadline) {
  using std::chrono::duration_cast;
  while (true) {
    const Duration left =
        std::max(deadline - std::chrono::steady_clock::now(), Duration::zero());
    const auto seconds = duration_cast<std::chrono::seconds>(left);
    const timespec timeout = {seconds.count(),
                              duration_cast<std::chrono::nanoseconds>(left - seconds).count()};
    pollfd poll = {file_, events, 0};
    const int ready = ppoll(&poll, 1, &timeout, nullptr);
    if (ready == 0) return false;
    if (ready < 0 && errno != EINTR) fail("cannot be waited for");
    if (ready < 0) continue;
    if ((poll.revents & events) != 0) return true;  // also before the end, as long as it reads
    errno = EIO;
    fail("is gone");
  }
}

void SerialPort::fail(const char* what) {
  const int error = errno;
  const bool was_open = file_ >= 0;
  close();
  throw TransportError(
      fmt::format("{} {}: {}", path_, what, was_open ? textOf(error) : "not open"));
}

}  // namespace handgraft::devices
