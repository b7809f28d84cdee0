#include "idl/datagrams/shown_certificate.h"

namespace handgraft::idl {

std::optional<std::string_view> shownCertificate(std::span<const std::uint8_t> payload,
                                                 bool is_little) {
  using namespace std::string_view_literals;
  constexpr std::string_view kName = "c.id\0"sv;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes, to be searched
  const std::string_view bytes(reinterpret_cast<const char*>(payload.data()), payload.size());
  // A reader may take a name without its end for the same one: four bytes long, it says.
  if (bytes.find("\4\0\0\0c.id"sv) != std::string_view::npos ||
      bytes.find("\0\0\0\4c.id"sv) != std::string_view::npos)
    return std::nullopt;
  const std::size_t at = bytes.find(kName);
  if (at == std::string_view::npos) return "";
  if (bytes.find(kName, at + 1) != std::string_view::npos) return std::nullopt;
  // A name, then a length at a multiple of four, then the value.
  const std::size_t length_at = (at + kName.size() + 3) & ~std::size_t{3};
  if (length_at + 4 > payload.size()) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < 4; ++i)
    length |= std::size_t{payload[length_at + i]} << (8 * (is_little ? i : 3 - i));
  if (length > payload.size() - length_at - 4) return std::nullopt;
  return bytes.substr(length_at + 4, length);
}

}  // namespace handgraft::idl
