#include "client/link/session_text.h"

#include "client/link/model_files.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr double kMebibyte = 1 << 20;
// What a server takes in one request (server/README), less what stands around the text.
constexpr std::size_t kMostBytes = (16U << 20U) - 4096U;

}  // namespace

std::string readSessionText(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMostBytes) {
    rejectInput("{}: {:.1f} MiB; a session's file may have at most {:.0f} MiB",
                quoted(path.string()), static_cast<double>(size) / kMebibyte,
                static_cast<double>(kMostBytes) / kMebibyte);
  }
  return readFile(path);
}

}  // namespace handgraft::client
