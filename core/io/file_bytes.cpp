#include "core/io/file_bytes.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>

#include "core/base/error.h"

namespace handgraft::io {

std::uintmax_t requireFile(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  const std::string name = quoted(path.string());
  if (!std::filesystem::exists(status)) rejectInput("file {} does not exist", name);
  if (std::filesystem::is_directory(status)) rejectInput("{} is a folder, not a file", name);
  if (!std::filesystem::is_regular_file(status)) rejectInput("{} is not a regular file", name);
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) rejectInput("file {} cannot be read: {}", name, error.message());
  if (size == 0) rejectInput("file {} is empty", name);
  if (size > kMostBytes) {
    rejectInput("file {} has {} bytes, at most {} are permitted", name, size, kMostBytes);
  }
  return size;
}

std::string endingOf(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return ending;
}

std::string readFileBytes(const std::filesystem::path& path) {
  const std::uintmax_t size = requireFile(path);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!stream) rejectInput("file {} cannot be read", handgraft::quoted(path.string()));
  return bytes;
}

}  // namespace handgraft::io
