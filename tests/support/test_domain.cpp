#include "tests/support/test_domain.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace handgraft::test {

bool isHeard(int domain, std::istream& table) {
  constexpr unsigned kBegin = 7400;  // RTPS 2.x, 9.6.1.1
  constexpr unsigned kOfADomain = 250;
  const unsigned begin = kBegin + kOfADomain * static_cast<unsigned>(domain);
  std::string line;
  std::getline(table, line);  // the headings
  while (std::getline(table, line)) {
    // Number, local address and port in hexadecimal, and more.
    std::istringstream words(line);
    std::string number;
    std::string local;
    words >> number >> local;
    const std::size_t colon = local.find(':');
    if (colon == std::string::npos) continue;
    const auto port = static_cast<unsigned>(std::stoul(local.substr(colon + 1), nullptr, 16));
    if (port >= begin && port < begin + kOfADomain) return true;
  }
  return false;
}

namespace {

/// By a program of this machine, whoever it is: another server answers what tests ask.
bool isTaken(int domain) {
  std::ifstream table("/proc/net/udp");
  return isHeard(domain, table);
}

}  // namespace

TestDomain::TestDomain() {
  constexpr int kDomains = 100;
  const std::string folder = std::filesystem::temp_directory_path().string();
  // Each process begins its search elsewhere: a domain just left may still be known to its
  // peers.
  for (int i = 0; i < kDomains; ++i) {
    const int candidate = 1 + (static_cast<int>(getpid()) + i) % kDomains;
    const std::string path = folder + "/handgraft_test_domain_" + std::to_string(candidate);
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0 && !isTaken(candidate)) {
      number_ = candidate;
      file_ = file;
      return;
    }
    close(file);
  }
  throw std::runtime_error("all DDS domains from 1 to 100 are taken by other programs");
}

TestDomain::~TestDomain() {
  close(file_);
}

}  // namespace handgraft::test
