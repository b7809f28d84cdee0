#include "server/reading/landlock.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace handgraft::server {

namespace {

void require(bool done, const char* what) {
  if (!done) throw std::system_error(errno, std::generic_category(), what);
}

constexpr std::uint64_t kVersion1 = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1;
// Of versions 2 and 3; not in all headers.
constexpr std::uint64_t kRefer = 1U << 13U;
constexpr std::uint64_t kTruncate = 1U << 14U;

constexpr std::uint64_t kOfFiles = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                                   LANDLOCK_ACCESS_FS_READ_FILE | kTruncate;
constexpr std::uint64_t kReading =
    LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;

std::uint64_t accessOf(Landlock::May what) {
  switch (what) {
    case Landlock::May::kReadFile:
      return LANDLOCK_ACCESS_FS_READ_FILE;
    case Landlock::May::kReadBelow:
      return kReading;
    case Landlock::May::kWriteBelow:
      return LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR |
             LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
             LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR |
             LANDLOCK_ACCESS_FS_MAKE_REG | kRefer | kTruncate;
    case Landlock::May::kWriteFile:
      return LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE;
  }
  return 0;
}

}  // namespace

int Landlock::version() {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version > 0 ? static_cast<int>(version) : 0;
}

Landlock::Landlock() {
  const int version = Landlock::version();
  if (version == 0) return;
  handled_ = kVersion1;
  if (version >= 2) handled_ |= kRefer;
  if (version >= 3) handled_ |= kTruncate;
  landlock_ruleset_attr attributes{};
  attributes.handled_access_fs = handled_;
  rules_ = static_cast<int>(
      syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes), 0));
  require(rules_ >= 0, "landlock_create_ruleset");
}

Landlock::~Landlock() {
  if (rules_ >= 0) close(rules_);
}

void Landlock::allow(const std::filesystem::path& path, May what) {
  if (rules_ < 0) return;
  const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
  if (file < 0) return;
  std::error_code error;
  landlock_path_beneath_attr rule{};
  rule.allowed_access = accessOf(what) & handled_;
  if (!std::filesystem::is_directory(path, error)) rule.allowed_access &= kOfFiles;
  rule.parent_fd = file;
  const bool is_added =
      syscall(SYS_landlock_add_rule, rules_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0;
  close(file);
  require(is_added, "landlock_add_rule");
}

void Landlock::restrict() {
  require(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0, "PR_SET_NO_NEW_PRIVS");
  if (rules_ < 0) return;
  require(syscall(SYS_landlock_restrict_self, rules_, 0) == 0, "landlock_restrict_self");
}

}  // namespace handgraft::server
