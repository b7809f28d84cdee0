#include "client/link/private_server.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <sstream>
#include <system_error>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/environment.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "handgraft-server";
constexpr std::chrono::milliseconds kPatience(5000);
constexpr std::size_t kTail = 4096;  // bytes of the log that are looked at

bool isProgram(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

}  // namespace

std::optional<fs::path> findServerProgram() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error && isProgram(self.parent_path() / kProgram)) return self.parent_path() / kProgram;
  std::istringstream folders(environment("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && isProgram(fs::path(folder) / kProgram)) {
      return fs::path(folder) / kProgram;
    }
  }
  return std::nullopt;
}

std::string ownServerName() {
  // Processes of other machines and containers have the same numbers.
  return fmt::format("own_{}_{:08x}", getpid(), std::random_device{}());
}

PrivateServer::PrivateServer(const fs::path& program, const Network& network) {
  // Everything that allocates happens before the fork: other threads may hold the heap's lock.
  std::vector<std::string> words = {
      program.string(), "--domain",        std::to_string(network.domain),
      "--interface",    network.interface, "--state",
      ":memory:"};
  for (const std::string& peer : network.peers)
    words.insert(words.end(), {"--peers", peer});
  if (!network.server.empty()) words.insert(words.end(), {"--name", network.server});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  log_ = memfd_create("handgraft-server.log", MFD_CLOEXEC);
  const pid_t parent = getpid();

  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);  // it died before the line above
    setpgid(0, 0);

    struct sigaction action {};

    action.sa_handler = SIG_DFL;  // the client's own handlers mean nothing here
    for (const int number : {SIGINT, SIGTERM, SIGPIPE})
      sigaction(number, &action, nullptr);
    const int null = open("/dev/null", O_RDONLY);
    if (null >= 0) dup2(null, STDIN_FILENO);
    if (log_ >= 0) {
      fcntl(log_, F_SETFL, O_APPEND);
      dup2(log_, STDOUT_FILENO);
      dup2(log_, STDERR_FILENO);
    }
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  if (pid_ < 0) {
    const int reason = errno;
    if (log_ >= 0) close(log_);
    throw TransportError(fmt::format("{}: cannot be started ({})", program.string(),
                                     std::generic_category().message(reason)));
  }
}

PrivateServer::~PrivateServer() {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  if (running()) kill(pid_, SIGTERM);
  while (running()) {
    if (std::chrono::steady_clock::now() > until) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (log_ >= 0) close(log_);
}

bool PrivateServer::running() {
  if (pid_ <= 0) return false;
  const pid_t ended = waitpid(pid_, nullptr, WNOHANG);
  if (ended == pid_ || (ended < 0 && errno == ECHILD)) pid_ = -1;
  return pid_ > 0;
}

std::string PrivateServer::lastWords() const {
  if (log_ < 0) return {};
  const off_t size = lseek(log_, 0, SEEK_END);
  if (size <= 0) return {};
  std::array<char, kTail> tail{};
  const auto begin = std::max<off_t>(0, size - static_cast<off_t>(tail.size()));
  const ssize_t count = pread(log_, tail.data(), tail.size(), begin);
  if (count <= 0) return {};
  std::istringstream lines(std::string(tail.data(), static_cast<std::size_t>(count)));
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace handgraft::client
