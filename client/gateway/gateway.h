#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "client/gateway/web_server.h"
#include "client/link/client.h"

namespace handgraft::client::gateway {

/// A server's sessions for pages in browsers: what they ask and edit goes to the server, what
/// sessions publish goes to the pages that follow them.
///
/// Pages speak JSON, one object a message (README). Several pages may follow one session, and
/// one gateway serves any number of sessions.
/// Threads: one, but for what it starts itself.
class Gateway {
 public:
  /// Errors: those of WebServer. The client outlives it.
  Gateway(Client& client, const WebOptions& options, WebFiles files);
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  [[nodiscard]] std::uint16_t port() const;

  /// To be called a few times a second: notices that the server went, finds it or another one,
  /// and has sessions go on there, anew if need be. Waits up to 2 s while none is heard.
  void tend();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// What a page's address begins with: "http://127.0.0.1:8080/".
std::string addressOf(const WebOptions& options, std::uint16_t port);

/// 128 random bits as text.
std::string randomToken();

}  // namespace handgraft::client::gateway
