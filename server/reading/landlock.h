#pragma once

#include <cstdint>
#include <filesystem>

namespace handgraft::server {

/// Which files a process may open from now on: none but those that it is given. By Landlock's
/// three system calls, which the C library of Debian 12 has no functions for.
class Landlock {
 public:
  enum class May { kReadFile, kReadBelow, kWriteBelow, kWriteFile };

  /// 0: this kernel has none, or not for us; then nothing below does anything.
  static int version();

  /// Errors, here and below: std::system_error if a kernel that can do it refuses.
  Landlock();
  ~Landlock();
  Landlock(const Landlock&) = delete;
  Landlock& operator=(const Landlock&) = delete;

  /// A file, or a folder and all below it. One that is not there is left out: who tries to
  /// open it says so.
  void allow(const std::filesystem::path& path, May what);

  /// For good: of this thread, those that it starts, and their processes.
  void restrict();

 private:
  std::uint64_t handled_ = 0;
  int rules_ = -1;
};

}  // namespace handgraft::server
