#include "tests/support/process.h"

#include <atomic>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/shared_data.h"

namespace handgraft::test {

namespace {

constexpr std::chrono::milliseconds kPoll{10};

std::string contentsOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

[[noreturn]] void becomeProgram(const std::filesystem::path& program,
                                std::vector<char*>& argv,
                                const std::filesystem::path& out,
                                const std::filesystem::path& err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  constexpr int kMode = 0600;
  const int in_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int out_fd = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode);
  const int err_fd = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode);
  dup2(in_fd, STDIN_FILENO);
  dup2(out_fd, STDOUT_FILENO);
  dup2(err_fd, STDERR_FILENO);
  execv(program.c_str(), argv.data());
  _exit(127);
}

}  // namespace

Process::Process(const std::filesystem::path& program,
                 const std::vector<std::string>& arguments) {
  static std::atomic<int> count{0};
  const std::string stem = program.filename().string() + "_" + std::to_string(count++);
  out_ = scratchDirectory() / (stem + ".out");
  err_ = scratchDirectory() / (stem + ".err");
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words)
    argv.push_back(word.data());
  argv.push_back(nullptr);
  if (!std::filesystem::exists(program)) {
    throw std::runtime_error("no such program: " + program.string());
  }
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ == 0) becomeProgram(program, argv, out_, err_);
}

Process::~Process() {
  if (ended_) return;
  kill(pid_, SIGKILL);
  reap(true);
}

bool Process::reap(bool block) {
  if (ended_) return true;
  int status = 0;
  if (waitpid(pid_, &status, block ? 0 : WNOHANG) != pid_) return false;
  ended_ = true;
  constexpr int kSignalBase = 128;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
  return true;
}

bool Process::running() {
  return !reap(false);
}

int Process::wait(std::chrono::seconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!reap(false)) {
    if (std::chrono::steady_clock::now() > end) {
      throw std::runtime_error("process did not end in time; it wrote:\n" + out() + err());
    }
    std::this_thread::sleep_for(kPoll);
  }
  return exit_code_;
}

bool Process::waitForText(const std::string& text, std::chrono::seconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (true) {
    const bool over = !running() || std::chrono::steady_clock::now() > end;
    if ((out() + err()).find(text) != std::string::npos) return true;
    if (over) return false;
    std::this_thread::sleep_for(kPoll);
  }
}

void Process::send(int signal) const {
  if (!ended_) kill(pid_, signal);
}

std::string Process::out() const {
  return contentsOf(out_);
}

std::string Process::err() const {
  return contentsOf(err_);
}

Finished run(const std::filesystem::path& program,
             const std::vector<std::string>& arguments,
             std::chrono::seconds timeout) {
  Process process(program, arguments);
  const int code = process.wait(timeout);
  return {code, process.out(), process.err()};
}

}  // namespace handgraft::test
