#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace handgraft::idl {

/// The certificate, in PEM, that the payload of a handshake message shows (`c.id` of DDS
/// Security 1.1, 9.3.2.5); empty if none; nothing if it is cut short, its name has no end, or
/// there are two: others might see another one. Whoever sent it: nothing is checked here.
std::optional<std::string_view> shownCertificate(std::span<const std::uint8_t> payload,
                                                 bool is_little);

}  // namespace handgraft::idl
