#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace handgraft::test {

/// A page as the wire sees it, which may say anything: HTTP and WebSocket by hand (RFC 6455).
class BarePage {
 public:
  explicit BarePage(std::uint16_t port)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)), port_(port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("no connection");
    }
  }

  ~BarePage() { close(socket_); }

  BarePage(const BarePage&) = delete;
  BarePage& operator=(const BarePage&) = delete;

  /// False if the other side has gone.
  bool send(const std::string& bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t count = ::send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (count <= 0) return false;
      at += static_cast<std::size_t>(count);
    }
    return true;
  }

  /// The whole answer's header, or what there is of it when the other side goes.
  std::string header() {
    while (read_.find("\r\n\r\n") == std::string::npos && receive()) {
    }
    const std::size_t end = read_.find("\r\n\r\n");
    const std::string text = read_.substr(0, end);
    read_.erase(0, end == std::string::npos ? end : end + 4);
    return text;
  }

  std::string get(const std::string& target, const std::string& host = "") {
    send("GET " + target + " HTTP/1.1\r\nHost: " + (host.empty() ? own() : host) + "\r\n\r\n");
    return header();
  }

  /// Asks to become a live page; the status line.
  std::string upgrade(const std::string& target = "/live", const std::string& more = "") {
    send("GET " + target + " HTTP/1.1\r\nHost: " + own() +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         more + "\r\n");
    const std::string text = header();
    return text.substr(0, text.find("\r\n"));
  }

  /// A frame's first bytes; a mask of zeros leaves what follows as it is.
  static std::string frameHead(std::uint64_t length, std::uint8_t opcode = 1) {
    std::string frame(1, static_cast<char>(0x80U | opcode));
    if (length < 126) {
      frame += static_cast<char>(0x80U | length);
    } else {
      frame += static_cast<char>(0x80U | 127U);
      for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>((length >> static_cast<unsigned>(shift)) & 0xFFU);
    }
    return frame + std::string(4, '\0');
  }

  bool say(const std::string& text) { return send(frameHead(text.size()) + text); }

  struct Frame {
    int opcode = 0;
    std::string payload;

    /// Of a frame that closes.
    [[nodiscard]] int code() const {
      if (opcode != 8 || payload.size() < 2) return 0;
      return (static_cast<unsigned char>(payload[0]) << 8) |
             static_cast<unsigned char>(payload[1]);
    }
  };

  /// Nothing when the other side has gone, or says nothing for so long.
  std::optional<Frame> frame(int patience_ms = 10000) {
    const auto have = [&](std::size_t count) {
      while (read_.size() < count) {
        if (!receive(patience_ms)) return false;
      }
      return true;
    };
    if (!have(2)) return std::nullopt;
    std::size_t length = static_cast<unsigned char>(read_[1]) & 0x7FU;
    std::size_t head = 2;
    if (length >= 126) {
      const std::size_t bytes = length == 126 ? 2 : 8;
      if (!have(2 + bytes)) return std::nullopt;
      length = 0;
      for (std::size_t i = 0; i < bytes; ++i)
        length = (length << 8U) | static_cast<unsigned char>(read_[2 + i]);
      head += bytes;
    }
    if (!have(head + length)) return std::nullopt;
    Frame frame{static_cast<unsigned char>(read_[0]) & 0x0F, read_.substr(head, length)};
    read_.erase(0, head + length);
    return frame;
  }

  /// What the connection was closed with; 0: without a word.
  int closingCode() {
    while (const auto next = frame()) {
      if (next->opcode == 8) return next->code();
    }
    return 0;
  }

 private:
  [[nodiscard]] std::string own() const { return "127.0.0.1:" + std::to_string(port_); }

  bool receive(int patience_ms = 10000) {
    pollfd input{socket_, POLLIN, 0};
    if (poll(&input, 1, patience_ms) <= 0) return false;
    std::array<char, 65536> bytes{};
    const ssize_t count = recv(socket_, bytes.data(), bytes.size(), 0);
    if (count <= 0) return false;
    read_.append(bytes.data(), static_cast<std::size_t>(count));
    return true;
  }

  int socket_;
  std::uint16_t port_;
  std::string read_;
};

}  // namespace handgraft::test
