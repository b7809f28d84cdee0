#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handgraft::server {

/// Takes from this process, for good, all that reading `files` does not need: opening any other
/// file (Landlock), and every system call but those by which a single thread reads, computes
/// and writes to its standard output and error (seccomp): the rest fails as if it did not
/// exist. Opening for writing, changing a folder, making a socket, another process or thread,
/// or signalling one ends it with SIGSYS.
///
/// What the kernel lacks is left out (`sandboxOfThisKernel`); so is all of it under sanitizers,
/// which need more. To be called before anybody's bytes are looked at, without other threads.
/// Errors: std::system_error if a kernel that can do it refuses.
void forbidAllButReading(const std::vector<std::filesystem::path>& files);

/// Makes the system calls fail by which one looks into other processes, mounts, loads modules
/// or sets clocks, in this thread and those that it starts. False where the kernel cannot.
/// Errors: as above.
bool forbidMeddling();

/// What of that this machine's kernel can do, for logs: "files, system calls"; "nothing".
std::string sandboxOfThisKernel();

}  // namespace handgraft::server
