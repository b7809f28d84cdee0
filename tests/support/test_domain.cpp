#include "tests/support/test_domain.h"

#include <filesystem>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace handgraft::test {

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
    if (flock(file, LOCK_EX | LOCK_NB) == 0) {
      number_ = candidate;
      file_ = file;
      return;
    }
    close(file);
  }
  throw std::runtime_error("all DDS domains from 1 to 100 are taken by other tests");
}

TestDomain::~TestDomain() {
  close(file_);
}

}  // namespace handgraft::test
