#include "tests/support/terminal.h"

#include <csignal>
#include <cstdlib>
#include <regex>
#include <stdexcept>
#include <thread>

#include <poll.h>
#include <pty.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace handgraft::test {

namespace {

constexpr std::chrono::milliseconds kPoll{10};

}  // namespace

Terminal::Terminal(const std::filesystem::path& program,
                   const std::vector<std::string>& arguments,
                   const std::map<std::string, std::string>& environment) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words)
    argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> settings{"TERM=xterm"};
  for (const auto& [name, value] : environment)
    settings.push_back(name + "=" + value);
  for (char** inherited = environ; *inherited != nullptr; ++inherited) {
    const std::string setting = *inherited;
    const std::string name = setting.substr(0, setting.find('='));
    if (name != "TERM" && environment.count(name) == 0) settings.push_back(setting);
  }
  std::vector<char*> envp;
  for (std::string& setting : settings)
    envp.push_back(setting.data());
  envp.push_back(nullptr);

  winsize size{};
  size.ws_row = 40;
  size.ws_col = 100;
  pid_ = forkpty(&master_, nullptr, nullptr, &size);
  if (pid_ < 0) throw std::runtime_error("no terminal");
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execve(program.c_str(), argv.data(), envp.data());
    _exit(127);
  }
}

Terminal::~Terminal() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(master_);
}

void Terminal::type(const std::string& keys) const {
  if (write(master_, keys.data(), keys.size()) != static_cast<ssize_t>(keys.size())) {
    throw std::runtime_error("the terminal takes no keys; it shows:\n" + text());
  }
}

// Takes what there is.
void Terminal::receive() {
  while (true) {
    pollfd output{master_, POLLIN, 0};
    if (poll(&output, 1, 0) <= 0 || (output.revents & POLLIN) == 0) return;
    char bytes[4096];
    const ssize_t count = read(master_, bytes, sizeof bytes);
    if (count <= 0) return;
    written_.append(bytes, static_cast<std::size_t>(count));
  }
}

bool Terminal::ended() {
  if (ended_) return true;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
  ended_ = true;
  constexpr int kSignalBase = 128;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
  return true;
}

bool Terminal::waitFor(const std::string& wanted, std::chrono::seconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (true) {
    const bool over = ended() || std::chrono::steady_clock::now() > end;
    receive();
    const std::string all = text();
    const std::size_t found = all.find(wanted, std::min(searched_, all.size()));
    if (found != std::string::npos) {
      searched_ = found + wanted.size();
      return true;
    }
    if (over) return false;
    std::this_thread::sleep_for(kPoll);
  }
}

std::string Terminal::text() const {
  static const std::regex escapes("\x1b\\[[0-9;?]*[A-Za-z]|\x1b[()=>][0-9A-B]?|\r");
  return std::regex_replace(written_, escapes, "");
}

int Terminal::wait(std::chrono::seconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!ended()) {
    receive();  // a full terminal would hold the program up
    if (std::chrono::steady_clock::now() > end) return -1;
    std::this_thread::sleep_for(kPoll);
  }
  receive();
  return exit_code_;
}

}  // namespace handgraft::test
