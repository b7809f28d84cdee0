#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "idl/security/certificates.h"
#include "idl/security/rights.h"

/// Who a program is on a secured domain: a folder that `handgraft keys add` made.
namespace handgraft::idl::security {

// Of an identity's folder.
inline constexpr const char* kAuthorityFile = "ca.pem";
inline constexpr const char* kCertificateFile = "cert.pem";
inline constexpr const char* kKeyFile = "key.pem";
inline constexpr const char* kGovernanceFile = "governance.p7s";
inline constexpr const char* kPermissionsFile = "permissions.p7s";
inline constexpr const char* kRevokedFile = "crl.pem";

struct Identity {
  std::filesystem::path folder;  ///< absolute
  std::string name;
  Role role = Role::kViewer;
  Lifetime lifetime;

  [[nodiscard]] std::string file(const char* name_of_file) const {
    return (folder / name_of_file).string();
  }
};

/// An identity's subject, made so that the vendors' handshake goes the way that works: Fast DDS
/// begins with a key that Cyclone DDS does not understand, so Cyclone has to begin, and who has
/// the lower GUID does. The nonce finds a subject whose GUIDs are high for servers, on Fast
/// DDS, and low for all else.
std::string makeCommonName(const std::string& name, Role role);

/// What `makeCommonName` put together. Errors: InvalidInput, beginning with `where`.
struct Named {
  std::string name;
  Role role = Role::kViewer;
};

Named readCommonName(const std::string& common_name, const std::string& where);

/// Errors: InvalidInput if no identity may be called so.
void requireIdentityName(const std::string& name);

/// The identity in a folder, fit to be used now.
///
/// Errors: InvalidInput, which names the file: one that is missing or cannot be read, a key
/// that others may read, what does not belong together or is not of the authority beside it,
/// what has expired, is not valid yet or was revoked, and a role that is none of `roles`.
Identity readIdentity(const std::filesystem::path& folder, std::initializer_list<Role> roles);

/// As above, at a time (seconds since 1970).
Identity readIdentity(const std::filesystem::path& folder,
                      std::initializer_list<Role> roles,
                      std::int64_t now_s);

/// A whole file. Errors: InvalidInput with its path.
std::string readTextFile(const std::filesystem::path& path);

std::int64_t nowInSeconds();

}  // namespace handgraft::idl::security
