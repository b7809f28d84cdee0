#include "core/hand/kept_files.h"

#include <atomic>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "core/base/content_hash.h"
#include "core/base/error.h"

namespace handgraft::hand {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kDigits = 64;
constexpr std::uintmax_t kLargestFile = 1U << 30U;

std::string checksumOf(std::string_view bytes) {
  ContentHash hash;
  hash.add(bytes);
  return hash.finish();
}

}  // namespace

KeptFiles::KeptFiles(std::optional<fs::path> folder, fs::path shipped)
    : folder_(std::move(folder)), shipped_(std::move(shipped)) {}

std::optional<std::string> KeptFiles::contentOf(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > kLargestFile) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  return bytes;
}

void KeptFiles::keep(const std::string& name, const std::string& bytes) const {
  if (!folder_) return;
  const fs::path path = *folder_ / name;
  static std::atomic<unsigned> count{0};
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  // Under another name first: a reader never sees half a file.
  fs::path half = path;
  half += fmt::format(".{}.{}.part", ::getpid(), count++);
  std::ofstream file(half, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(half, path, error);
  if (!file || error) fs::remove(half, error);
}

std::string sealed(std::string_view format, const std::string& key, std::string_view content) {
  HANDGRAFT_REQUIRE(key.size() == kDigits);
  std::string bytes(format);
  bytes += key;
  bytes += content;
  return bytes + checksumOf(bytes);
}

std::optional<std::string_view> unsealed(std::string_view bytes,
                                         std::string_view format,
                                         const std::string& key) {
  if (bytes.size() < format.size() + 2 * kDigits || !bytes.starts_with(format) ||
      bytes.substr(format.size(), kDigits) != key ||
      bytes.substr(bytes.size() - kDigits) !=
          checksumOf(bytes.substr(0, bytes.size() - kDigits)))
    return std::nullopt;
  bytes.remove_prefix(format.size() + kDigits);
  bytes.remove_suffix(kDigits);
  return bytes;
}

}  // namespace handgraft::hand
