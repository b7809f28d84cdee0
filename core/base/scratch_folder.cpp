#include "core/base/scratch_folder.h"

#include <cerrno>
#include <chrono>
#include <system_error>

#include <fcntl.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp is POSIX
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace handgraft {

namespace fs = std::filesystem;

namespace {

/// The folder, locked; -1 where another process holds it, or it is not ours.
int lockOf(const fs::path& folder) {
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return -1;

  struct stat about {};

  if (fstat(file, &about) == 0 && about.st_uid == geteuid() &&
      flock(file, LOCK_EX | LOCK_NB) == 0)
    return file;
  close(file);
  return -1;
}

/// One is made before it is locked: who is that young may be neither yet.
bool isYoung(const fs::path& folder) {
  constexpr std::chrono::minutes kYoung(1);
  std::error_code error;
  const auto written = fs::last_write_time(folder, error);
  return error || fs::file_time_type::clock::now() - written < kYoung;
}

void removeLeft(const fs::path& in, const std::string& kind) {
  std::error_code error;
  for (auto at = fs::directory_iterator(in, error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    const fs::path folder = at->path();
    if (folder.filename().string().rfind(kind + "-", 0) != 0 || isYoung(folder)) continue;
    const int lock = lockOf(folder);
    if (lock < 0) continue;
    std::error_code ignored;  // the next one tries again
    fs::remove_all(folder, ignored);
    close(lock);
  }
}

}  // namespace

ScratchFolder::ScratchFolder(const std::string& kind) {
  const fs::path in = fs::canonical(fs::temp_directory_path());
  removeLeft(in, kind);
  std::string pattern = (in / (kind + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw fs::filesystem_error("no private folder", pattern,
                               std::error_code(errno, std::generic_category()));
  }
  path_ = pattern;
  lock_ = lockOf(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a temporary folder that stays is no reason to fail
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) close(lock_);
}

}  // namespace handgraft
