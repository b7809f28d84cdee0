#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hardware/devices/can_channel.h"

namespace handgraft::devices {

/// A CAN bus behind the kernel's own driver: any socket that carries one struct can_frame a
/// message.
class SocketCanChannel final : public CanChannel {
 public:
  /// Gives the descriptor of a socket, which this will close. Errors: TransportError.
  using Open = std::function<int()>;

  explicit SocketCanChannel(Open open);
  ~SocketCanChannel() override;

  void open() override;
  void close() override;
  void send(const protocols::CanFrame& frame) override;
  bool receive(protocols::CanFrame& frame, TimePoint deadline) override;

  [[nodiscard]] std::uint64_t damaged() const override { return errors_; }

 private:
  bool waitFor(short events, TimePoint deadline);
  [[noreturn]] void fail(const char* what);

  Open open_;
  int socket_ = -1;
  std::uint64_t errors_ = 0;
};

/// Opens a network interface ("can0") and lets through what comes from `nodes` of CANSimple,
/// and news of the bus being lost.
/// Errors: TransportError, also where the kernel knows no CAN.
SocketCanChannel::Open canInterface(std::string name, std::vector<int> nodes);

}  // namespace handgraft::devices
