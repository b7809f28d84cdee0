#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <sys/types.h>

#include "core/base/network.h"

namespace handgraft::client {

/// `handgraft-server` beside this program, else on PATH; nothing if there is none.
std::optional<std::filesystem::path> findServerProgram();

/// A name for it that no other client of the domain gives.
std::string ownServerName();

/// A server of our own, for one command. It gets its own process group, so that Ctrl-C at the
/// terminal reaches the client alone, which then asks it to stop; it dies with the client
/// however the client ends.
class PrivateServer {
 public:
  /// Errors: TransportError if the program cannot be started. That it runs does not mean that
  /// it answers yet.
  PrivateServer(const std::filesystem::path& program, const Network& network);

  /// SIGTERM, and SIGKILL after 5 s.
  ~PrivateServer();
  PrivateServer(const PrivateServer&) = delete;
  PrivateServer& operator=(const PrivateServer&) = delete;

  /// False once it has ended.
  [[nodiscard]] bool running();

  /// The last line that it wrote; empty if none.
  [[nodiscard]] std::string lastWords() const;

 private:
  pid_t pid_ = -1;
  int log_ = -1;
};

}  // namespace handgraft::client
