#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace handgraft::server {

/// A file descriptor that is closed with this.
class OwnedFd {
 public:
  OwnedFd() = default;

  explicit OwnedFd(int fd) : fd_(fd) {}

  ~OwnedFd() { close(); }

  OwnedFd(const OwnedFd&) = delete;
  OwnedFd& operator=(const OwnedFd&) = delete;

  OwnedFd(OwnedFd&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }

  OwnedFd& operator=(OwnedFd&& other) noexcept;

  [[nodiscard]] int get() const { return fd_; }

  void close();

 private:
  int fd_ = -1;
};

/// A file in memory that holds `bytes`, to be read from its start. Errors: std::system_error.
OwnedFd memoryFile(std::string_view bytes);

/// A child that reads a file as its standard input and is heard on two pipes; killed and waited
/// for when this goes out of scope.
///
/// It inherits no other descriptor, no blocked or ignored signal, and of the environment what
/// loaders and sanitizers need.
class ChildProcess {
 public:
  /// Errors: std::system_error if it cannot be started.
  ChildProcess(const std::filesystem::path& program,
               const std::vector<std::string>& arguments,
               const OwnedFd& input);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] const OwnedFd& out() const { return out_; }

  [[nodiscard]] const OwnedFd& err() const { return err_; }

  /// Whether it has ended by itself; then `status` says how.
  bool hasEnded();

  void kill();

  /// As waitpid gives it; meaningful once it has ended. -1 if the system does not tell.
  [[nodiscard]] int status() const { return status_; }

 private:
  pid_t pid_ = -1;  ///< -1 once it was waited for
  int status_ = -1;
  OwnedFd out_;
  OwnedFd err_;
};

}  // namespace handgraft::server
