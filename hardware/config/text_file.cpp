#include "hardware/config/text_file.h"

#include <cstdint>
#include <fstream>
#include <sstream>
#include <system_error>

#include "core/base/error.h"

namespace handgraft::config {

namespace fs = std::filesystem;

namespace {
constexpr std::uintmax_t kLargestFile = 1 << 20;
}  // namespace

std::string readText(const fs::path& path) {
  const std::string name = handgraft::quoted(path.string());
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) rejectInput("{}: {}", name, error.message());
  if (size > kLargestFile)
    rejectInput("{}: {} bytes, more than the {} of a config", name, size, kLargestFile);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) rejectInput("{}: cannot be read", name);
  return text.str();
}

void writeText(const fs::path& path, const std::string& text) {
  const fs::path draft = path.string() + ".new";
  std::ofstream file(draft, std::ios::binary);
  file << text;
  file.close();
  std::error_code error;
  if (file) fs::rename(draft, path, error);
  if (!file || error) rejectInput("{}: cannot be written", handgraft::quoted(path.string()));
}

}  // namespace handgraft::config
