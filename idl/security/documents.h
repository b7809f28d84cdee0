#pragma once

#include <cstdint>
#include <string>

#include "idl/security/rights.h"

namespace handgraft::idl::security {

/// The XML of DDS Security 1.1, before it is signed: section 9.4.1.2 (governance) and 9.4.1.3
/// (permissions).
///
/// Everything is encrypted but what finds each other, and nobody takes part without an
/// identity. Of the kinds of protection these alone were measured to carry all samples between
/// both vendors (DECISIONS).
std::string governanceText();

/// Of the identity of that subject ("CN=..."), for its role. Times are seconds since 1970;
/// Fast DDS 2.9.1 reads such dates in local time, Cyclone DDS in UTC, so a day is added at both
/// ends: the certificate's own times count.
std::string permissionsText(const std::string& name,
                            const std::string& subject,
                            Role role,
                            std::int64_t not_before_s,
                            std::int64_t not_after_s);

/// 2026-12-31T23:59:59, UTC.
std::string dateText(std::int64_t time_s);

}  // namespace handgraft::idl::security
