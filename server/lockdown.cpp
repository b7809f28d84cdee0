#include "server/lockdown.h"

#include <cerrno>
#include <system_error>

#include "core/base/sanitized.h"
#include "core/hand/skin_cache.h"
#include "server/reading/landlock.h"
#include "server/reading/sandbox.h"
#include "server/store/model_library.h"

namespace handgraft::server {

namespace fs = std::filesystem;

PermittedPaths usualPaths() {
  PermittedPaths usual;
  usual.read = {"/usr",
                "/lib",
                "/lib64",
                "/bin",
                "/sbin",
                "/opt",
                "/etc",
                "/proc",
                "/sys",
                "/run/systemd/resolve",
                "/run/NetworkManager",
                "/run/resolvconf",
                "/dev/urandom",
                "/dev/random",
                builtInLibrary(),
                builtInSkins()};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) usual.read.push_back(program.parent_path());
  if (const auto cache = hand::SkinCache::fromEnvironment().folder()) {
    fs::create_directories(*cache, error);
    usual.written.push_back(*cache);
  }
  usual.written.push_back(fs::temp_directory_path(error));
  return usual;
}

std::string lockDown(const PermittedPaths& permitted) {
  if (kIsSanitized) return "nothing";
  std::string done;
  Landlock files;
  for (const fs::path& path : permitted.read)
    files.allow(path, Landlock::May::kReadBelow);
  for (const fs::path& path : permitted.written)
    files.allow(path, Landlock::May::kWriteBelow);
  files.allow("/dev/null", Landlock::May::kWriteFile);
  try {
    files.restrict();
    if (Landlock::version() > 0) done = "files";
  } catch (const std::system_error& error) {
    // One that started itself anew many times is locked down as often as the kernel does it.
    if (error.code().value() != E2BIG) throw;
    done = "files";
  }
  if (forbidMeddling()) done += done.empty() ? "system calls" : ", system calls";
  return done.empty() ? "nothing" : done;
}

}  // namespace handgraft::server
