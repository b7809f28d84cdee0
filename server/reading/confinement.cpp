#include "server/reading/confinement.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/base/sanitized.h"

namespace handgraft::server {

namespace {

/// The libraries are there already; a mesh and its picture are two.
constexpr rlim_t kMostFiles = 32;

void require(bool done, const char* what) {
  if (!done) throw std::system_error(errno, std::generic_category(), what);
}

/// Limits that are tighter already stay.
void limit(int resource, rlim_t soft, rlim_t hard, const char* what) {
  rlimit now{};
  require(getrlimit(static_cast<__rlimit_resource>(resource), &now) == 0, what);
  now.rlim_cur = std::min(soft, now.rlim_max);
  now.rlim_max = std::min(hard, now.rlim_max);
  require(setrlimit(static_cast<__rlimit_resource>(resource), &now) == 0, what);
}

}  // namespace

void confine(const Confinement& limits, pid_t parent) {
  require(prctl(PR_SET_PDEATHSIG, SIGKILL) == 0, "PR_SET_PDEATHSIG");
  if (getppid() != parent) _exit(1);  // it is gone already
  require(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0, "PR_SET_NO_NEW_PRIVS");
  if (!kIsSanitized) {
    // Nobody but root may look into it: it holds one client's files.
    require(prctl(PR_SET_DUMPABLE, 0) == 0, "PR_SET_DUMPABLE");
    limit(RLIMIT_AS, limits.memory_bytes, limits.memory_bytes, "RLIMIT_AS");
  }
  limit(RLIMIT_CORE, 0, 0, "RLIMIT_CORE");
  limit(RLIMIT_FSIZE, 0, 0, "RLIMIT_FSIZE");
  limit(RLIMIT_NOFILE, kMostFiles, kMostFiles, "RLIMIT_NOFILE");
  limit(RLIMIT_CPU, limits.seconds, limits.seconds + 1, "RLIMIT_CPU");
}

}  // namespace handgraft::server
