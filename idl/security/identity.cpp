#include "idl/security/identity.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>
#include <system_error>

#include <sys/stat.h>

#include "core/base/error.h"
#include "core/base/random_id.h"
#include "idl/security/documents.h"
#include "idl/security/guids.h"

namespace handgraft::idl::security {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestFile = 1U << 20U;  // bytes; they are a few thousand

// Who reads a key is whom it names.
void requirePrivate(const fs::path& key) {
  struct stat about {};

  if (stat(key.c_str(), &about) != 0)
    rejectInput("{}: cannot be read ({})", key.string(),
                std::generic_category().message(errno));
  const unsigned mode = about.st_mode & 07777U;
  if ((mode & 077U) == 0) return;
  rejectInput("{}: others than its owner may read or write this key (mode {:04o}): chmod 600",
              key.string(), mode);
}

void requireInTime(const Lifetime& lifetime,
                   const std::string& what,
                   const std::string& remedy,
                   std::int64_t now_s) {
  if (now_s < lifetime.not_before_s) {
    rejectInput("{} is not valid before {} UTC; it is {} UTC", what,
                dateText(lifetime.not_before_s), dateText(now_s));
  }
  if (now_s > lifetime.not_after_s)
    rejectInput("{} expired on {} UTC: {}", what, dateText(lifetime.not_after_s), remedy);
}

std::string document(const fs::path& path, const Certificate& authority) {
  auto text = openDocument(readTextFile(path), authority);
  if (!text) {
    rejectInput("{}: was not signed by the authority in {}", path.string(),
                (path.parent_path() / kAuthorityFile).string());
  }
  return *std::move(text);
}

void requireRole(const Identity& identity, std::initializer_list<Role> roles) {
  if (std::find(roles.begin(), roles.end(), identity.role) != roles.end()) return;
  std::string names;
  for (const Role role : roles)
    names += std::string(names.empty() ? "" : " or ") + nameOf(role);
  rejectInput("{}: {} is of role {}; this program needs an identity of role {}",
              identity.folder.string(), identity.name, nameOf(identity.role), names);
}

}  // namespace

void requireIdentityName(const std::string& name) {
  constexpr std::size_t kLongestIdentity = 32;
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  const bool is_name = !name.empty() && name.size() <= kLongestIdentity &&
                       is_letter(name.front()) &&
                       std::all_of(name.begin(), name.end(), [&](char c) {
                         return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
                       });
  if (is_name) return;
  rejectInput(
      "name {} is none of an identity: a letter, then letters, digits, _ and -, at most {}",
      quoted(name), kLongestIdentity);
}

std::int64_t nowInSeconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string readTextFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    rejectInput("{}: a file is needed, this is a folder", path.string());
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    rejectInput("{}: cannot be read ({})", path.string(),
                std::generic_category().message(errno));
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFile)
    rejectInput("{}: has more than {} bytes", path.string(), kLargestFile);
  if (text.empty()) rejectInput("{}: is empty", path.string());
  return text;
}

std::string makeCommonName(const std::string& name, Role role) {
  while (true) {
    std::string common_name = fmt::format("{} {} {:016x}", name, nameOf(role), randomId());
    if (isHigh(guidBeginOf(common_name)) == (role == Role::kServer)) return common_name;
  }
}

Named readCommonName(const std::string& common_name, const std::string& where) {
  std::istringstream words(common_name);
  std::string name;
  std::string role;
  std::string nonce;
  std::string more;
  if (!(words >> name >> role >> nonce) || words >> more) {
    rejectInput("{}: subject {} is none that `handgraft keys add` makes (NAME ROLE NONCE)",
                where, quoted("CN=" + common_name));
  }
  Named named{name, roleNamed(role)};
  if (isHigh(guidBeginOf(common_name)) != (named.role == Role::kServer)) {
    rejectInput(
        "{}: subject {} would make a handshake that Cyclone DDS does not understand; "
        "make it by `handgraft keys add`",
        where, quoted("CN=" + common_name));
  }
  return named;
}

Identity readIdentity(const fs::path& folder, std::initializer_list<Role> roles) {
  return readIdentity(folder, roles, nowInSeconds());
}

Identity readIdentity(const fs::path& folder,
                      std::initializer_list<Role> roles,
                      std::int64_t now_s) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    rejectInput("identity: {} is no folder; `handgraft keys add` makes one",
                quoted(folder.string()));
  }
  Identity identity;
  identity.folder = fs::canonical(folder);
  const auto at = [&](const char* file) {
    return identity.folder / file;
  };
  const std::string certificate_file = at(kCertificateFile).string();
  const std::string authority_file = at(kAuthorityFile).string();
  requirePrivate(at(kKeyFile));
  const Certificate authority = Certificate::read(readTextFile(authority_file), authority_file);
  const Certificate certificate =
      Certificate::read(readTextFile(certificate_file), certificate_file);
  const PrivateKey key = PrivateKey::read(readTextFile(at(kKeyFile)), at(kKeyFile).string());
  if (!certificate.isSignedBy(authority)) {
    rejectInput("{}: was not signed by the authority in {}", certificate_file, authority_file);
  }
  if (!certificate.belongsTo(key))
    rejectInput("{}: is of another key than {}", certificate_file, at(kKeyFile).string());
  identity.lifetime = certificate.lifetime();
  requireInTime(authority.lifetime(), authority_file + ": the authority",
                "make another one by `handgraft keys init`", now_s);
  const Named named = readCommonName(certificate.commonName(), certificate_file);
  identity.name = named.name;
  identity.role = named.role;
  requireInTime(identity.lifetime, fmt::format("{}: identity {}", certificate_file, named.name),
                "add one of another name by `handgraft keys add`", now_s);
  document(at(kGovernanceFile), authority);
  const std::string subject = "<subject_name>CN=" + certificate.commonName() + "<";
  if (document(at(kPermissionsFile), authority).find(subject) == std::string::npos) {
    rejectInput("{}: is of another identity than {}", at(kPermissionsFile).string(),
                certificate_file);
  }
  const std::string revoked_file = at(kRevokedFile).string();
  const RevocationList revoked = RevocationList::read(readTextFile(revoked_file), revoked_file);
  if (!revoked.isSignedBy(authority))
    rejectInput("{}: was not signed by the authority in {}", revoked_file, authority_file);
  for (const RevocationList::Entry& entry : revoked.entries()) {
    if (entry.serial != certificate.serial()) continue;
    rejectInput("{}: identity {} was revoked on {} UTC ({})", certificate_file, named.name,
                dateText(entry.when_s), revoked_file);
  }
  requireRole(identity, roles);
  return identity;
}

}  // namespace handgraft::idl::security
