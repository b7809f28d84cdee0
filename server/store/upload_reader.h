#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>

#include "core/base/progress.h"
#include "server/reading/read_model.h"

namespace handgraft::server {

struct ReaderLimits {
  std::uint64_t memory_mb = 4096;  ///< of a reading process' address space; 64-1048576
  std::chrono::seconds time{120};  ///< of processor time, and on the clock; 1-86400
};

/// Reads models from files that nobody vouches for, each in a process of its own (README,
/// "Reading uploads"): whatever a file does to its parser, it costs that request alone.
///
/// Threads: `read` from any thread, which it occupies.
class UploadReader {
 public:
  /// Errors: InvalidInput if `program` cannot be executed (named), or a limit is out of range.
  explicit UploadReader(std::filesystem::path program, ReaderLimits limits = {});

  /// As `readModel`; what comes back has been checked again. Errors: as `readModel`, and
  /// InvalidInput naming the file where reading took too much time or memory or came to a bad
  /// end (logged); Rejection (ERROR_OVERLOADED) if the system has no process to give. Cancelled
  /// within a moment: the process is killed.
  [[nodiscard]] ReadModel read(const ReadRequest& request, const Progress& progress) const;

 private:
  std::filesystem::path program_;
  ReaderLimits limits_;
};

/// `handgraft-reader` beside this program.
std::filesystem::path readerProgram();

}  // namespace handgraft::server
