#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace handgraft::formats {

/// `size` bytes from `at` on. Errors: InvalidInput if there are fewer.
std::string_view partAt(std::string_view bytes, std::uint64_t at, std::uint64_t size);

/// The number in `size` bytes from `at` on, 8 at most, the lowest first. Errors: as partAt.
std::uint64_t numberAt(std::string_view bytes, std::uint64_t at, std::size_t size);

}  // namespace handgraft::formats
