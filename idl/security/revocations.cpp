#include "idl/security/revocations.h"

#include <sys/stat.h>

#include "core/base/error.h"

namespace handgraft::idl::security {

std::optional<Revocations::News> Revocations::look() {
  const std::string path = own_.file(kRevokedFile);

  struct stat about {};

  // It is replaced whole: another file, or at another time.
  Version now{-1, 0};
  constexpr std::int64_t kNs = 1'000'000'000;
  if (stat(path.c_str(), &about) == 0)
    now = {about.st_mtim.tv_sec * kNs + about.st_mtim.tv_nsec,
           static_cast<std::int64_t>(about.st_ino)};
  if (seen_ == now) return std::nullopt;
  seen_ = now;
  News news;
  try {
    const std::string authority_file = own_.file(kAuthorityFile);
    const Certificate authority =
        Certificate::read(readTextFile(authority_file), authority_file);
    const RevocationList list = RevocationList::read(readTextFile(path), path);
    if (!list.isSignedBy(authority))
      rejectInput("{}: was not signed by the authority in {}", path, authority_file);
    const std::string file = own_.file(kCertificateFile);
    const std::string own = Certificate::read(readTextFile(file), file).serial();
    for (const RevocationList::Entry& entry : list.entries()) {
      news.is_own = news.is_own || entry.serial == own;
      if (const auto begin = guidBeginOfSerial(entry.serial)) news.revoked.insert(*begin);
    }
  } catch (const InvalidInput& error) {
    return News{{}, false, error.what()};
  }
  return news;
}

}  // namespace handgraft::idl::security
