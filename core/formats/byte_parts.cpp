#include "core/formats/byte_parts.h"

#include "core/base/error.h"

namespace handgraft::formats {

std::string_view partAt(std::string_view bytes, std::uint64_t at, std::uint64_t size) {
  if (at > bytes.size() || size > bytes.size() - at)
    rejectInput("it breaks off at byte {}", bytes.size());
  return bytes.substr(static_cast<std::size_t>(at), static_cast<std::size_t>(size));
}

std::uint64_t numberAt(std::string_view bytes, std::uint64_t at, std::size_t size) {
  const std::string_view part = partAt(bytes, at, size);
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = (value << 8) | static_cast<unsigned char>(part[i]);
  return value;
}

}  // namespace handgraft::formats
