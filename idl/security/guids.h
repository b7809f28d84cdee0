#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

/// How a secured participant's GUID tells whose it is (DDS Security 1.1, 9.3.3): it begins with
/// 47 bits of its subject's digest, which the vendors compare with the certificate.
namespace handgraft::idl::security {

/// The first bytes of all GUIDs of an identity.
using GuidBegin = std::array<std::uint8_t, 6>;

GuidBegin guidBeginOf(const std::string& common_name);

/// Of a certificate of that number (Certificate::serial). Nothing if it is none of ours;
/// numbers of identities that were made before numbers told it are nobody's.
std::optional<GuidBegin> guidBeginOfSerial(const std::string& serial);

/// The lower GUID of two begins their handshake.
bool isHigh(const GuidBegin& begin);

}  // namespace handgraft::idl::security
