#include "tests/hardware/emulators/wire.h"

#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/error.h"
#include "hardware/devices/serial_port.h"

#include "tests/support/shared_data.h"

namespace handgraft::test {

namespace {

constexpr std::chrono::microseconds kStep(500);
// The thread that serves a pty looks at its device once in so long, and when bytes are due.
constexpr std::chrono::milliseconds kLook(1);
constexpr std::chrono::microseconds kSoon(20);

class VirtualWire final : public Wire, private devices::ByteChannel {
 public:
  explicit VirtualWire(EmulatedDevice& device) : device_(device) {}

  devices::ByteChannel& channel() override { return *this; }

  devices::Clock clock() override {
    return [this] {
      return now_;
    };
  }

  void pass(Duration time) override {
    const TimePoint end = now_ + time;
    while (now_ < end)
      step(end);
  }

  void unplug() override { is_plugged_ = is_open_ = false; }

  void plug() override { is_plugged_ = true; }

  std::unique_lock<std::mutex> hold() override { return std::unique_lock(mutex_); }

  std::vector<ByteVector> takeSent() { return std::exchange(sent_, {}); }

 private:
  void open() override {
    if (!is_plugged_) throw TransportError("unplugged");
    is_open_ = true;
    arrived_.clear();
  }

  void close() override { is_open_ = false; }

  void send(protocols::Bytes bytes) override {
    require();
    sent_.push_back(vectorOf(bytes));
    device_.hear(bytes, now_);
  }

  std::size_t receive(std::span<std::uint8_t> into, TimePoint deadline) override {
    require();
    while (true) {
      collect();
      if (!arrived_.empty()) break;
      if (now_ >= deadline) return 0;
      step(deadline);
    }
    const std::size_t count = std::min(into.size(), arrived_.size());
    const auto end = arrived_.begin() + static_cast<std::ptrdiff_t>(count);
    std::copy(arrived_.begin(), end, into.begin());
    arrived_.erase(arrived_.begin(), end);
    return count;
  }

  void discard() override {
    require();
    collect();
    arrived_.clear();
  }

  void require() const {
    if (!is_open_) throw TransportError("unplugged");
  }

  void step(TimePoint end) {
    now_ = std::min<TimePoint>(now_ + kStep, end);
    device_.advance(now_);
  }

  void collect() {
    const ByteVector bytes = device_.takeOutput(now_);
    arrived_.insert(arrived_.end(), bytes.begin(), bytes.end());
  }

  EmulatedDevice& device_;
  TimePoint now_{std::chrono::seconds(1000)};
  bool is_plugged_ = true;
  bool is_open_ = false;
  ByteVector arrived_;
  std::vector<ByteVector> sent_;
  std::mutex mutex_;
};

/// Serves a device on a pty under a name that stays the same when it is plugged in again.
class Pty final : public Wire {
 public:
  Pty(EmulatedDevice& device, int bits_per_second, Line line)
      : device_(device), link_(uniqueName()), port_(link_.string(), bits_per_second) {
    constexpr std::chrono::nanoseconds kTenBits(10'000'000'000);
    if (line == Line::kUart) per_byte_ = kTenBits / bits_per_second;
    plug();
  }

  ~Pty() override {
    unplug();
    std::filesystem::remove(link_);
  }

  devices::ByteChannel& channel() override { return port_; }

  devices::Clock clock() override { return std::chrono::steady_clock::now; }

  void pass(Duration time) override { std::this_thread::sleep_for(time); }

  void unplug() override {
    if (!server_.joinable()) return;
    is_stopping_ = true;
    server_.join();
    ::close(master_);
    master_ = -1;
  }

  void plug() override {
    int slave = -1;
    std::array<char, 128> name{};
    termios raw{};  // or it would echo what the device says before the port is open
    cfmakeraw(&raw);
    if (openpty(&master_, &slave, name.data(), &raw, nullptr) != 0)
      throw std::runtime_error("openpty failed");
    ::close(slave);
    std::filesystem::remove(link_);
    std::filesystem::create_symlink(name.data(), link_);
    // Not for programs that are started meanwhile: they would keep the wire open.
    if (fcntl(master_, F_SETFL, O_NONBLOCK) != 0 || fcntl(master_, F_SETFD, FD_CLOEXEC) != 0)
      throw std::runtime_error("fcntl failed");
    is_stopping_ = false;
    server_ = std::thread([this] {
      serve();
    });
  }

  std::unique_lock<std::mutex> hold() override { return std::unique_lock(mutex_); }

  [[nodiscard]] std::string path() const { return link_.string(); }

 private:
  static std::filesystem::path uniqueName() {
    static std::atomic<int> count = 0;
    return scratchDirectory() / ("tty" + std::to_string(count++));
  }

  void serve() {
    std::array<std::uint8_t, 512> chunk;
    while (!is_stopping_) {
      pollfd poll_master = {master_, POLLIN, 0};
      const timespec wait = untilNextLook();
      const bool is_open =
          ppoll(&poll_master, 1, &wait, nullptr) <= 0 || (poll_master.revents & POLLHUP) == 0;
      // While nobody has opened the other end, polling returns at once.
      if (!is_open) std::this_thread::sleep_for(kLook);
      const ssize_t count = ::read(master_, chunk.data(), chunk.size());
      const std::lock_guard lock(mutex_);
      const TimePoint now = std::chrono::steady_clock::now();
      if (on_wire_.empty()) arrived_at_ = std::max(arrived_at_, now);
      if (count > 0) {
        device_.hear({chunk.data(), static_cast<std::size_t>(count)}, now);
        arrived_at_ += count * per_byte_;  // what it says next comes after them
      }
      device_.advance(now);
      const ByteVector said = device_.takeOutput(now);
      on_wire_.insert(on_wire_.end(), said.begin(), said.end());
      deliver(now);
    }
  }

  [[nodiscard]] timespec untilNextLook() const {
    const Duration due = arrived_at_ +
                         static_cast<std::ptrdiff_t>(on_wire_.size()) * per_byte_ -
                         std::chrono::steady_clock::now();
    const auto wait =
        on_wire_.empty() ? Duration(kLook) : std::clamp<Duration>(due, kSoon, kLook);
    return {0, static_cast<long>(wait / std::chrono::nanoseconds(1))};
  }

  // A pty itself knows nothing of rates.
  void deliver(TimePoint now) {
    auto count = static_cast<std::ptrdiff_t>(on_wire_.size());
    if (per_byte_ > Duration::zero())
      count = std::clamp<std::ptrdiff_t>((now - arrived_at_) / per_byte_, 0, count);
    arrived_at_ += count * per_byte_;
    std::ptrdiff_t written = 0;
    while (written < count) {
      const ssize_t part = ::write(master_, on_wire_.data() + written,
                                   static_cast<std::size_t>(count - written));
      if (part <= 0) break;  // nobody reads: lost, as on a real wire
      written += part;
    }
    on_wire_.erase(on_wire_.begin(), on_wire_.begin() + count);
  }

  EmulatedDevice& device_;
  std::filesystem::path link_;
  devices::SerialPort port_;
  std::chrono::nanoseconds per_byte_{0};
  ByteVector on_wire_;      // said, and not arrived yet
  TimePoint arrived_at_{};  // the last byte before them, of either side: one talks at a time
  int master_ = -1;
  std::atomic<bool> is_stopping_ = false;
  std::mutex mutex_;
  std::thread server_;
};

}  // namespace

std::unique_ptr<Wire> makeVirtualWire(EmulatedDevice& device) {
  return std::make_unique<VirtualWire>(device);
}

std::unique_ptr<Wire> makePty(EmulatedDevice& device, int bits_per_second, Line line) {
  return std::make_unique<Pty>(device, bits_per_second, line);
}

std::string portOf(Wire& pty) {
  return dynamic_cast<Pty&>(pty).path();
}

std::vector<ByteVector> takeSent(Wire& virtual_wire) {
  return dynamic_cast<VirtualWire&>(virtual_wire).takeSent();
}

}  // namespace handgraft::test
