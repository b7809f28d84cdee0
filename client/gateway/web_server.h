#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "client/gateway/web_files.h"

namespace handgraft::client::gateway {

/// A page that is open in a browser somewhere.
using PageId = std::uint64_t;

enum class Rights { kLook, kEdit };

/// Who is told what pages say: on the web server's one thread, where nobody waits.
class Audience {
 public:
  virtual ~Audience() = default;
  virtual void joined(PageId page, Rights rights) = 0;
  virtual void said(PageId page, const std::string& text) = 0;
  /// A message of bytes: a part of a file.
  virtual void gave(PageId page, const std::string& frame) = 0;
  virtual void left(PageId page) = 0;
};

/// What strangers may cost.
struct WebLimits {
  std::size_t connections = 64;
  std::size_t message_bytes = 2U << 20U;
  double messages_per_s = 120.0;
  double burst = 240.0;                    ///< messages at once
  std::size_t unread_bytes = 256U << 20U;  ///< of a page that does not read what it asked for
};

struct WebOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: any that is free
  /// What a page must show to edit, to look; empty, both: it may edit. Addresses other than
  /// the loopback's need them.
  std::string edit_token = {};
  std::string look_token = {};
  bool read_only = false;  ///< nobody edits
  WebLimits limits = {};
};

/// HTTP for the page's files, WebSocket (`/live`) for what it shows and does.
///
/// Refused: what comes from pages of other origins (403), without a token where one is needed
/// (401), too many connections (503), messages too large (1009) or too fast (1008).
/// Threads: one of its own; `send`, `sendLatest` and `sendBytes` from any.
class WebServer {
 public:
  /// Errors: InvalidInput if it cannot listen there, saying why.
  WebServer(WebOptions options, WebFiles files, Audience& audience);
  /// Tells nobody any more; pages see the connection go.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;

  using Shared = std::shared_ptr<const std::string>;

  void send(PageId page, Shared text);
  /// Takes the place of what waits under the same key: a slow page is told the newest alone.
  void sendLatest(PageId page, const std::string& key, Shared text);
  void sendBytes(PageId page, Shared bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::client::gateway
