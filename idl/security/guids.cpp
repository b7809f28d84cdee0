#include "idl/security/guids.h"

#include <charconv>

#include "idl/security/certificates.h"

namespace handgraft::idl::security {

namespace {

/// A one, then the digest.
GuidBegin beginOf(const SubjectDigest& digest) {
  GuidBegin begin{};
  unsigned carried = 1;
  for (std::size_t i = 0; i < begin.size(); ++i) {
    begin[i] = static_cast<std::uint8_t>(carried << 7U | digest[i] >> 1U);
    carried = digest[i] & 1U;
  }
  return begin;
}

}  // namespace

GuidBegin guidBeginOf(const std::string& common_name) {
  return beginOf(digestOfSubject(common_name));
}

std::optional<GuidBegin> guidBeginOfSerial(const std::string& serial) {
  SubjectDigest digest{};
  // Its leading zeros are not told.
  const std::size_t digits = 2 * digest.size();
  if (serial.empty() || serial.size() > digits) return std::nullopt;
  const std::string padded = std::string(digits - serial.size(), '0') + serial;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const char* at = padded.data() + 2 * i;
    if (std::from_chars(at, at + 2, digest[i], 16).ptr != at + 2) return std::nullopt;
  }
  return beginOf(digest);
}

bool isHigh(const GuidBegin& begin) {
  return (begin[0] & 0x40U) != 0;  // the first bit of all GUIDs is a one
}

}  // namespace handgraft::idl::security
