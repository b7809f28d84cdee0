#include "server/store/child_process.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/environment.h"

namespace handgraft::server {

namespace {

[[noreturn]] void fail(int error, const char* what) {
  throw std::system_error(error, std::generic_category(), what);
}

/// Above those that the child's own three will take: none of them must be overwritten before it
/// is used.
OwnedFd raised(int fd) {
  const OwnedFd low(fd);
  const int high = fcntl(fd, F_DUPFD_CLOEXEC, 10);
  if (high < 0) fail(errno, "no more descriptors");
  return OwnedFd(high);
}

/// What is read here, and what the child writes to.
std::pair<OwnedFd, OwnedFd> makePipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) fail(errno, "no pipe");
  OwnedFd first(ends[0]);
  OwnedFd second = raised(ends[1]);
  fcntl(first.get(), F_SETFL, O_NONBLOCK);
  return {std::move(first), std::move(second)};
}

std::vector<std::string> childEnvironment() {
  std::vector<std::string> kept;
  for (const char* name :
       {"LD_LIBRARY_PATH", "ASAN_OPTIONS", "TSAN_OPTIONS", "UBSAN_OPTIONS"}) {
    if (const std::string value = environment(name); !value.empty())
      kept.push_back(fmt::format("{}={}", name, value));
  }
  return kept;
}

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts)
    pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// What becomes of descriptors and signals between fork and exec.
class SpawnPlan {
 public:
  SpawnPlan(int in, int out, int err) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, out, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, err, STDERR_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }

  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }

  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  [[nodiscard]] const posix_spawn_file_actions_t* actions() const { return &actions_; }

  [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

OwnedFd& OwnedFd::operator=(OwnedFd&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

void OwnedFd::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

OwnedFd memoryFile(std::string_view bytes) {
  const int fd = memfd_create("handgraft-request", MFD_CLOEXEC);
  if (fd < 0) fail(errno, "no file in memory");
  OwnedFd file = raised(fd);
  while (!bytes.empty()) {
    const ssize_t count = write(file.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(errno, "a file in memory cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return file;
}

ChildProcess::ChildProcess(const std::filesystem::path& program,
                           const std::vector<std::string>& arguments,
                           const OwnedFd& input) {
  auto [out, out_of_child] = makePipe();
  auto [err, err_of_child] = makePipe();
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = childEnvironment();
  const SpawnPlan plan(input.get(), out_of_child.get(), err_of_child.get());
  const int error = posix_spawn(&pid_, program.c_str(), plan.actions(), plan.attributes(),
                                pointersTo(words).data(), pointersTo(environment).data());
  if (error != 0) {
    pid_ = -1;
    fail(error, program.c_str());
  }
  out_ = std::move(out);
  err_ = std::move(err);
}

ChildProcess::~ChildProcess() {
  kill();
}

bool ChildProcess::hasEnded() {
  if (pid_ < 0) return true;
  const pid_t ended = waitpid(pid_, &status_, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
  if (ended < 0) status_ = -1;
  pid_ = -1;
  return true;
}

void ChildProcess::kill() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  while (waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

}  // namespace handgraft::server
