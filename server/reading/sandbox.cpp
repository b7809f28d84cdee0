#include "server/reading/sandbox.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <system_error>

#include <fcntl.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "core/base/sanitized.h"
#include "server/reading/landlock.h"

namespace handgraft::server {

namespace {

namespace fs = std::filesystem;

void require(bool done, const std::string& what) {
  if (!done) throw std::system_error(errno, std::generic_category(), what);
}

// === System calls

bool kernelFiltersCalls() {
  // A filter that does not exist: a kernel that has filters complains of the address.
  return prctl(PR_SET_SECCOMP, 2 /* SECCOMP_MODE_FILTER */, nullptr) == -1 && errno == EFAULT;
}

class CallFilter {
 public:
  explicit CallFilter(std::uint32_t otherwise)
      : filter_(seccomp_init(otherwise), &seccomp_release) {
    require(filter_ != nullptr, "seccomp_init");
  }

  void allow(std::initializer_list<int> calls) {
    for (const int call : calls)
      add(SCMP_ACT_ALLOW, call, {});
  }

  void allow(int call, std::initializer_list<scmp_arg_cmp> where) {
    add(SCMP_ACT_ALLOW, call, where);
  }

  void refuse(std::initializer_list<int> calls) {
    for (const int call : calls)
      add(SCMP_ACT_ERRNO(EPERM), call, {});
  }

  void killAt(std::initializer_list<int> calls) {
    for (const int call : calls)
      add(SCMP_ACT_KILL_PROCESS, call, {});
  }

  void killAt(int call, scmp_arg_cmp where) { add(SCMP_ACT_KILL_PROCESS, call, {where}); }

  void load() {
    const int result = seccomp_load(filter_.get());
    errno = -result;
    require(result == 0, "seccomp_load");
  }

 private:
  void add(std::uint32_t action, int call, std::initializer_list<scmp_arg_cmp> where) {
    if (call < 0) return;  // of other processors
    const int result = seccomp_rule_add_array(
        filter_.get(), action, call, static_cast<unsigned>(where.size()), std::data(where));
    errno = -result;
    require(result == 0, "seccomp_rule_add");
  }

  std::unique_ptr<void, decltype(&seccomp_release)> filter_;
};

scmp_arg_cmp equals(unsigned argument, std::uint64_t value) {
  return {argument, SCMP_CMP_EQ, value, 0};
}

/// Memory, time and its end.
void allowToRun(CallFilter& filter) {
  filter.allow({SCMP_SYS(brk),
                SCMP_SYS(mmap),
                SCMP_SYS(mremap),
                SCMP_SYS(munmap),
                SCMP_SYS(mprotect),
                SCMP_SYS(madvise),
                SCMP_SYS(futex),
                SCMP_SYS(sched_yield),
                SCMP_SYS(clock_gettime),
                SCMP_SYS(clock_nanosleep),
                SCMP_SYS(nanosleep),
                SCMP_SYS(gettimeofday),
                SCMP_SYS(getrusage),
                SCMP_SYS(times),
                SCMP_SYS(getrandom),
                SCMP_SYS(sysinfo),
                SCMP_SYS(uname),
                SCMP_SYS(getpid),
                SCMP_SYS(gettid),
                SCMP_SYS(rt_sigaction),
                SCMP_SYS(rt_sigprocmask),
                SCMP_SYS(rt_sigreturn),
                SCMP_SYS(restart_syscall),
                SCMP_SYS(exit),
                SCMP_SYS(exit_group)});
}

/// Which files may be opened is not seen here.
void allowToRead(CallFilter& filter) {
  filter.allow(
      {SCMP_SYS(read),       SCMP_SYS(readv),      SCMP_SYS(pread64),    SCMP_SYS(preadv),
       SCMP_SYS(lseek),      SCMP_SYS(_llseek),    SCMP_SYS(close),      SCMP_SYS(fstat),
       SCMP_SYS(fstat64),    SCMP_SYS(newfstatat), SCMP_SYS(fstatat64),  SCMP_SYS(stat),
       SCMP_SYS(lstat),      SCMP_SYS(statx),      SCMP_SYS(access),     SCMP_SYS(faccessat),
       SCMP_SYS(faccessat2), SCMP_SYS(readlink),   SCMP_SYS(readlinkat), SCMP_SYS(getcwd)});
  constexpr std::array<std::uint64_t, 5> kWriting = {O_WRONLY, O_RDWR, O_CREAT, O_TRUNC,
                                                     O_APPEND};
  constexpr std::uint64_t kAny = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
  filter.allow(SCMP_SYS(openat), {{2, SCMP_CMP_MASKED_EQ, kAny, 0}});
  filter.allow(SCMP_SYS(open), {{1, SCMP_CMP_MASKED_EQ, kAny, 0}});
  for (const std::uint64_t flag : kWriting) {
    filter.killAt(SCMP_SYS(openat), {2, SCMP_CMP_MASKED_EQ, flag, flag});
    filter.killAt(SCMP_SYS(open), {1, SCMP_CMP_MASKED_EQ, flag, flag});
  }
  filter.allow(SCMP_SYS(fcntl), {equals(1, F_GETFD)});
  filter.allow(SCMP_SYS(fcntl), {equals(1, F_GETFL)});
  filter.allow(SCMP_SYS(ioctl), {equals(1, TCGETS)});  // whether a stream is a terminal
}

/// The answer, and a complaint.
void allowToAnswer(CallFilter& filter) {
  for (const auto stream : {STDOUT_FILENO, STDERR_FILENO}) {
    filter.allow(SCMP_SYS(write), {equals(0, static_cast<std::uint64_t>(stream))});
    filter.allow(SCMP_SYS(writev), {equals(0, static_cast<std::uint64_t>(stream))});
  }
  // abort() signals itself.
  filter.allow(SCMP_SYS(tgkill), {equals(0, static_cast<std::uint64_t>(getpid()))});
}

/// What only a reader that was taken over tries.
void killWhereTakenOver(CallFilter& filter) {
  filter.killAt({SCMP_SYS(socket),
                 SCMP_SYS(socketpair),
                 SCMP_SYS(connect),
                 SCMP_SYS(bind),
                 SCMP_SYS(listen),
                 SCMP_SYS(accept),
                 SCMP_SYS(accept4),
                 SCMP_SYS(sendto),
                 SCMP_SYS(sendmsg),
                 SCMP_SYS(sendmmsg),
                 SCMP_SYS(execve),
                 SCMP_SYS(execveat),
                 SCMP_SYS(fork),
                 SCMP_SYS(vfork),
                 SCMP_SYS(clone),
                 SCMP_SYS(clone3),
                 SCMP_SYS(kill),
                 SCMP_SYS(tkill),
                 SCMP_SYS(ptrace),
                 SCMP_SYS(process_vm_readv),
                 SCMP_SYS(process_vm_writev),
                 SCMP_SYS(creat),
                 SCMP_SYS(unlink),
                 SCMP_SYS(unlinkat),
                 SCMP_SYS(rename),
                 SCMP_SYS(renameat),
                 SCMP_SYS(renameat2),
                 SCMP_SYS(mkdir),
                 SCMP_SYS(mkdirat),
                 SCMP_SYS(rmdir),
                 SCMP_SYS(link),
                 SCMP_SYS(linkat),
                 SCMP_SYS(symlink),
                 SCMP_SYS(symlinkat),
                 SCMP_SYS(mknod),
                 SCMP_SYS(mknodat),
                 SCMP_SYS(chmod),
                 SCMP_SYS(fchmodat),
                 SCMP_SYS(chown),
                 SCMP_SYS(fchownat),
                 SCMP_SYS(truncate),
                 SCMP_SYS(mount),
                 SCMP_SYS(unshare),
                 SCMP_SYS(setns),
                 SCMP_SYS(bpf),
                 SCMP_SYS(io_uring_setup),
                 SCMP_SYS(open_by_handle_at)});
}

void forbidOtherCalls() {
  if (!kernelFiltersCalls()) return;
  CallFilter filter(SCMP_ACT_ERRNO(ENOSYS));  // all else does not exist for it
  allowToRun(filter);
  allowToRead(filter);
  allowToAnswer(filter);
  killWhereTakenOver(filter);
  filter.load();
}

}  // namespace

void forbidAllButReading(const std::vector<fs::path>& files) {
  if (kIsSanitized) return;
  Landlock files_alone;
  for (const fs::path& file : files)
    files_alone.allow(file, Landlock::May::kReadFile);
  files_alone.restrict();
  forbidOtherCalls();
}

bool forbidMeddling() {
  if (kIsSanitized || !kernelFiltersCalls()) return false;
  require(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0, "PR_SET_NO_NEW_PRIVS");
  CallFilter filter(SCMP_ACT_ALLOW);
  filter.refuse({SCMP_SYS(ptrace),
                 SCMP_SYS(process_vm_readv),
                 SCMP_SYS(process_vm_writev),
                 SCMP_SYS(pidfd_getfd),
                 SCMP_SYS(mount),
                 SCMP_SYS(umount2),
                 SCMP_SYS(pivot_root),
                 SCMP_SYS(chroot),
                 SCMP_SYS(move_mount),
                 SCMP_SYS(open_tree),
                 SCMP_SYS(fsopen),
                 SCMP_SYS(unshare),
                 SCMP_SYS(setns),
                 SCMP_SYS(swapon),
                 SCMP_SYS(swapoff),
                 SCMP_SYS(reboot),
                 SCMP_SYS(kexec_load),
                 SCMP_SYS(kexec_file_load),
                 SCMP_SYS(init_module),
                 SCMP_SYS(finit_module),
                 SCMP_SYS(delete_module),
                 SCMP_SYS(bpf),
                 SCMP_SYS(perf_event_open),
                 SCMP_SYS(userfaultfd),
                 SCMP_SYS(io_uring_setup),
                 SCMP_SYS(keyctl),
                 SCMP_SYS(add_key),
                 SCMP_SYS(request_key),
                 SCMP_SYS(open_by_handle_at),
                 SCMP_SYS(acct),
                 SCMP_SYS(quotactl),
                 SCMP_SYS(settimeofday),
                 SCMP_SYS(clock_settime),
                 SCMP_SYS(adjtimex),
                 SCMP_SYS(clock_adjtime),
                 SCMP_SYS(sethostname),
                 SCMP_SYS(setdomainname),
                 SCMP_SYS(iopl),
                 SCMP_SYS(ioperm),
                 SCMP_SYS(mknod),
                 SCMP_SYS(mknodat)});
  filter.load();
  return true;
}

std::string sandboxOfThisKernel() {
  if (kIsSanitized) return "nothing";
  std::string able;
  if (Landlock::version() > 0) able = "files";
  if (kernelFiltersCalls()) able += able.empty() ? "system calls" : ", system calls";
  return able.empty() ? "nothing" : able;
}

}  // namespace handgraft::server
