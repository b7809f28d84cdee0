#include "idl/security/authority.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"
#include "idl/security/documents.h"

namespace handgraft::idl::security {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kDayOfSeconds = 24L * 3600;
constexpr const char* kAuthorityKeyFile = "ca.key";
constexpr mode_t kForOwner = 0600;
constexpr mode_t kForAll = 0644;  // the folder keeps others out

[[noreturn]] void rejectFile(const fs::path& path, const char* what) {
  rejectInput("{}: {} ({})", path.string(), what, std::generic_category().message(errno));
}

void writeAll(int file, const fs::path& path, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) {
      const int reason = errno;
      close(file);
      unlink(path.c_str());
      errno = reason;
      rejectFile(path, "cannot be written");
    }
    if (count > 0) done += static_cast<std::size_t>(count);
  }
  const bool is_kept = fsync(file) == 0;
  const int reason = errno;
  if (close(file) == 0 && is_kept) return;
  unlink(path.c_str());
  errno = reason;
  rejectFile(path, "cannot be written");
}

/// A file that was not there.
void writeNew(const fs::path& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0) rejectFile(path, "cannot be made");
  writeAll(file, path, text);
}

/// The new content or the old one, whatever comes in between.
void replace(const fs::path& path, const std::string& text) {
  fs::path next = path;
  next += ".new";
  unlink(next.c_str());
  writeNew(next, text, kForAll);
  if (rename(next.c_str(), path.c_str()) != 0) rejectFile(path, "cannot be replaced");
}

void makePrivateFolder(const fs::path& path) {
  if (mkdir(path.c_str(), 0700) != 0) rejectFile(path, "cannot be made");
}

/// One change of an authority at a time.
class AuthorityLock {
 public:
  explicit AuthorityLock(const fs::path& folder)
      : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (file_ < 0) rejectFile(folder, "cannot be opened");
    if (flock(file_, LOCK_EX) != 0) {
      close(file_);
      rejectFile(folder, "cannot be locked");
    }
  }

  ~AuthorityLock() { close(file_); }

  AuthorityLock(const AuthorityLock&) = delete;
  AuthorityLock& operator=(const AuthorityLock&) = delete;

 private:
  int file_;
};

}  // namespace

Authority::Authority(fs::path folder, Certificate certificate, PrivateKey key)
    : folder_(std::move(folder)), certificate_(std::move(certificate)), key_(std::move(key)) {}

Authority Authority::make(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder, error))) {
    makePrivateFolder(folder);
  } else if (!fs::is_directory(folder, error)) {
    rejectInput("{}: is there, and no folder", folder.string());
  }
  const fs::path at = fs::canonical(folder);
  const AuthorityLock lock(at);
  if (fs::exists(at / kAuthorityFile, error))
    rejectInput("{}: is an authority already; nothing was changed", at.string());
  if (!fs::is_empty(at, error))
    rejectInput("{}: holds something already; an authority needs a folder of its own",
                at.string());
  if (chmod(at.c_str(), 0700) != 0) rejectFile(at, "cannot be closed to others");

  const std::int64_t now = nowInSeconds();
  const Lifetime lifetime{now - kDayOfSeconds, now + kOwnDays * kDayOfSeconds};
  const PrivateKey key = PrivateKey::make();
  const Certificate certificate = Certificate::makeAuthority(
      fmt::format("handgraft authority {}",
                  makeCommonName("ca", Role::kServer).substr(std::strlen("ca server "))),
      key, lifetime);
  writeNew(at / kAuthorityKeyFile, key.pem(), kForOwner);
  writeNew(at / kGovernanceFile, signDocument(governanceText(), certificate, key), kForAll);
  writeNew(at / kRevokedFile, RevocationList::make({}, certificate, key, lifetime).pem(),
           kForAll);
  writeNew(at / kAuthorityFile, certificate.pem(), kForAll);
  return {at, certificate, key};
}

Authority Authority::open(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / kAuthorityFile, error) ||
      !fs::exists(folder / kAuthorityKeyFile, error)) {
    rejectInput("{}: is no authority; `handgraft keys init` makes one", folder.string());
  }
  const fs::path at = fs::canonical(folder);
  const fs::path key_file = at / kAuthorityKeyFile;

  struct stat about {};

  if (stat(key_file.c_str(), &about) == 0 && (about.st_mode & 077U) != 0) {
    rejectInput("{}: others than its owner may read or write this key (mode {:04o}): chmod 600",
                key_file.string(), about.st_mode & 07777U);
  }
  Certificate certificate =
      Certificate::read(readTextFile(at / kAuthorityFile), (at / kAuthorityFile).string());
  PrivateKey key = PrivateKey::read(readTextFile(key_file), key_file.string());
  if (!certificate.belongsTo(key)) {
    rejectInput("{}: is of another key than {}", (at / kAuthorityFile).string(),
                key_file.string());
  }
  return {at, std::move(certificate), std::move(key)};
}

RevocationList Authority::revocations() const {
  const fs::path path = folder_ / kRevokedFile;
  RevocationList list = RevocationList::read(readTextFile(path), path.string());
  if (!list.isSignedBy(certificate_))
    rejectInput("{}: was not signed by the authority in {}", path.string(),
                (folder_ / kAuthorityFile).string());
  return list;
}

Identity Authority::add(const std::string& name, Role role, int days) {
  requireIdentityName(name);
  if (days < 1 || days > kMostDays) rejectInput("days {} is outside 1-{}", days, kMostDays);
  const AuthorityLock lock(folder_);
  const fs::path home = folder_ / name;
  std::error_code error;
  if (fs::exists(fs::symlink_status(home, error))) {
    rejectInput("name {} is taken: {} is there, and nothing is written over", quoted(name),
                home.string());
  }
  const std::int64_t now = nowInSeconds();
  const Lifetime lifetime{now - kDayOfSeconds, now + days * kDayOfSeconds};
  const Lifetime own = certificate_.lifetime();
  if (now > own.not_after_s) {
    rejectInput(
        "{}: the authority expired on {} UTC: make another one by `handgraft keys init`",
        (folder_ / kAuthorityFile).string(), dateText(own.not_after_s));
  }
  if (lifetime.not_after_s > own.not_after_s) {
    rejectInput("days {} reach beyond the end of the authority in {}, {} UTC: at most {}", days,
                folder_.string(), dateText(own.not_after_s),
                (own.not_after_s - now) / kDayOfSeconds);
  }
  const std::string common_name = makeCommonName(name, role);
  const PrivateKey key = PrivateKey::make();
  const Certificate certificate =
      Certificate::issue(common_name, key, lifetime, certificate_, key_);

  // Whole or not at all.
  const fs::path draft = folder_ / ("." + name + ".new");
  fs::remove_all(draft);
  makePrivateFolder(draft);
  try {
    writeNew(draft / kKeyFile, key.pem(), kForOwner);
    writeNew(draft / kCertificateFile, certificate.pem(), kForAll);
    writeNew(draft / kPermissionsFile,
             signDocument(permissionsText(name, "CN=" + common_name, role,
                                          lifetime.not_before_s, lifetime.not_after_s),
                          certificate_, key_),
             kForAll);
    for (const char* shared : {kAuthorityFile, kGovernanceFile, kRevokedFile})
      writeNew(draft / shared, readTextFile(folder_ / shared), kForAll);
    if (rename(draft.c_str(), home.c_str()) != 0) rejectFile(home, "cannot be made");
  } catch (...) {
    fs::remove_all(draft, error);
    throw;
  }
  return readIdentity(home, {role}, now);
}

std::vector<Authority::Entry> Authority::identities() const {
  const std::vector<RevocationList::Entry> revoked = revocations().entries();
  std::vector<Entry> found;
  for (const auto& one : fs::directory_iterator(folder_)) {
    const fs::path file = one.path() / kCertificateFile;
    std::error_code error;
    if (one.path().filename().string().front() == '.' || !fs::exists(file, error)) continue;
    Entry entry;
    entry.name = one.path().filename().string();
    entry.folder = one.path();
    try {
      const Certificate certificate = Certificate::read(readTextFile(file), file.string());
      entry.lifetime = certificate.lifetime();
      entry.role = readCommonName(certificate.commonName(), file.string()).role;
      for (const RevocationList::Entry& gone : revoked) {
        if (gone.serial == certificate.serial()) entry.revoked_s = gone.when_s;
      }
      if (!entry.revoked_s) readIdentity(one.path(), {entry.role});
    } catch (const InvalidInput& error_of_it) {
      entry.trouble = error_of_it.what();
    }
    found.push_back(std::move(entry));
  }
  std::sort(found.begin(), found.end(), [](const Entry& a, const Entry& b) {
    return a.name < b.name;
  });
  return found;
}

void Authority::revoke(const std::string& name) {
  requireIdentityName(name);
  const AuthorityLock lock(folder_);
  const fs::path file = folder_ / name / kCertificateFile;
  std::error_code error;
  if (!fs::exists(file, error)) {
    std::string names;
    for (const Entry& entry : identities())
      names += (names.empty() ? "" : ", ") + entry.name;
    rejectInput("name {} is none of {}; there are {}", quoted(name), folder_.string(),
                names.empty() ? "none" : names);
  }
  const Certificate certificate = Certificate::read(readTextFile(file), file.string());
  if (!certificate.isSignedBy(certificate_))
    rejectInput("{}: was not signed by this authority", file.string());
  std::vector<RevocationList::Entry> entries = revocations().entries();
  for (const RevocationList::Entry& entry : entries) {
    if (entry.serial == certificate.serial())
      rejectInput("identity {} was revoked on {} UTC", name, dateText(entry.when_s));
  }
  const std::int64_t now = nowInSeconds();
  entries.push_back({certificate.serial(), now});
  const std::string list =
      RevocationList::make(entries, certificate_, key_,
                           {now - kDayOfSeconds, certificate_.lifetime().not_after_s})
          .pem();
  replace(folder_ / kRevokedFile, list);
  for (const Entry& entry : identities())
    replace(entry.folder / kRevokedFile, list);
}

}  // namespace handgraft::idl::security
