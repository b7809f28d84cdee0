#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handgraft::server {

/// What a server works with.
struct PermittedPaths {
  std::vector<std::filesystem::path> read;     ///< files, folders and all below
  std::vector<std::filesystem::path> written;  ///< folders
};

/// Those that every server has: its own program's and libraries' folders, what the system tells
/// of itself, devices without a memory; its cache and the system's temporary folder.
PermittedPaths usualPaths();

/// Takes from this process, for good, all other files (Landlock) and the system calls by which
/// one looks into other processes, mounts, loads modules, sets clocks (seccomp): what a server
/// that was taken over would want, and none ever needs. Folders that are written must be there.
/// What the kernel lacks is left out, and all of it under sanitizers. Before other threads are
/// started. Returns what was done, for logs: "files, system calls"; "nothing". Errors:
/// std::system_error if a kernel that can do it refuses.
std::string lockDown(const PermittedPaths& permitted);

}  // namespace handgraft::server
