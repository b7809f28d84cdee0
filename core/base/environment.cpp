#include "core/base/environment.h"

#include <cstdlib>

namespace handgraft {

namespace fs = std::filesystem;

std::string environment(const char* name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment.
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::optional<fs::path> userFolder(const char* variable, const char* usual) {
  if (const fs::path set = environment(variable); set.is_absolute()) return set;
  if (const fs::path home = environment("HOME"); home.is_absolute()) return home / usual;
  return std::nullopt;
}

}  // namespace handgraft
