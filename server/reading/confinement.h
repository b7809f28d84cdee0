#pragma once

#include <cstdint>

#include <sys/types.h>

namespace handgraft::server {

/// What a process that reads uploads may use.
struct Confinement {
  std::uint64_t memory_bytes = 4ull << 30;  ///< of its address space
  unsigned seconds = 120;                   ///< of processor time
};

/// Takes from this process what reading does not need, for good: memory and processor time
/// beyond the limits, writing files, core dumps, many open files, new privileges; and ends it
/// with the process `parent` (with the thread that started it, that is). Call it first.
///
/// Sanitizers reserve terabytes of addresses: built with them, memory is not limited.
/// Errors: std::system_error if the system refuses.
void confine(const Confinement& limits, pid_t parent);

}  // namespace handgraft::server
