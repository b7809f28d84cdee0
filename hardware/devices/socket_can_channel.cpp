#include "hardware/devices/socket_can_channel.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hardware/protocols/socket_can_frame.h"

namespace handgraft::devices {

namespace {

constexpr std::chrono::milliseconds kSendPatience(20);
constexpr canid_t kNodeMask = 0x7E0;  // the six high bits of CANSimple's ids
constexpr int kNodeShift = 5;

[[noreturn]] void refuse(const std::string& what) {
  const int error = errno;
  throw TransportError(fmt::format("{}: {}", what, std::generic_category().message(error)));
}

void configure(int socket, const std::string& name, const std::vector<int>& nodes) {
  std::vector<can_filter> filters;
  filters.reserve(nodes.size());
  for (const int node : nodes) {
    filters.push_back({static_cast<canid_t>(node) << kNodeShift,
                       kNodeMask | CAN_EFF_FLAG});  // standard ids alone
  }
  const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_TX_TIMEOUT | CAN_ERR_RESTARTED;
  if (setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                 static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0 ||
      setsockopt(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof(errors)) != 0) {
    refuse(name + ": no CAN filters");
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(name.c_str()));
  if (address.can_ifindex == 0) refuse(name + ": no such network interface");
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    refuse(name + ": cannot be bound");
}

}  // namespace

SocketCanChannel::SocketCanChannel(Open open) : open_(std::move(open)) {}

SocketCanChannel::~SocketCanChannel() {
  SocketCanChannel::close();
}

void SocketCanChannel::open() {
  close();
  socket_ = open_();
}

void SocketCanChannel::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void SocketCanChannel::send(const protocols::CanFrame& frame) {
  const struct can_frame raw = protocols::toSocketCan(frame);
  const TimePoint deadline = std::chrono::steady_clock::now() + kSendPatience;
  while (::send(socket_, &raw, sizeof(raw), MSG_DONTWAIT | MSG_NOSIGNAL) != sizeof(raw)) {
    // A full queue does not count as unwritable, so it is asked again after a moment.
    const bool is_full = errno == ENOBUFS || errno == EAGAIN;
    if (!is_full && errno != EINTR) fail("the CAN bus cannot be written");
    if (std::chrono::steady_clock::now() >= deadline) fail("the CAN bus takes no more frames");
    if (is_full) static_cast<void>(poll(nullptr, 0, 1));
  }
}

bool SocketCanChannel::receive(protocols::CanFrame& frame, TimePoint deadline) {
  while (true) {
    struct can_frame raw {};

    const ssize_t count = recv(socket_, &raw, sizeof(raw), MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {
      if (!waitFor(POLLIN, deadline)) return false;
      continue;
    }
    if (count != sizeof(raw)) fail("the CAN bus is gone");
    const protocols::SocketCanMessage message = protocols::fromSocketCan(raw);
    if (!message.is_error) {
      frame = message.frame;
      return true;
    }
    ++errors_;
    if ((message.error & CAN_ERR_BUSOFF) != 0) {
      errno = ENETDOWN;
      fail("the CAN controller has left the bus");
    }
  }
}

bool SocketCanChannel::waitFor(short events, TimePoint deadline) {
  using std::chrono::duration_cast;
  const Duration left = std::max(deadline - std::chrono::steady_clock::now(), Duration::zero());
  const auto seconds = duration_cast<std::chrono::seconds>(left);
  const timespec timeout = {seconds.count(),
                            duration_cast<std::chrono::nanoseconds>(left - seconds).count()};
  pollfd poll = {socket_, events, 0};
  const int ready = ppoll(&poll, 1, &timeout, nullptr);
  if (ready < 0 && errno != EINTR) fail("the CAN bus cannot be waited for");
  return ready != 0;
}

void SocketCanChannel::fail(const char* what) {
  const int error = errno;
  const bool was_open = socket_ >= 0;
  close();
  throw TransportError(fmt::format(
      "{}: {}", what, was_open ? std::generic_category().message(error) : "not open"));
}

SocketCanChannel::Open canInterface(std::string name, std::vector<int> nodes) {
  return [name = std::move(name), nodes = std::move(nodes)] {
    const int file = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (file < 0) refuse("no CAN sockets");
    try {
      configure(file, name, nodes);
    } catch (...) {
      ::close(file);
      throw;
    }
    return file;
  };
}

}  // namespace handgraft::devices
