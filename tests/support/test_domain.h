#pragma once

#include <istream>

namespace handgraft::test {

/// True where one of a domain's ports is in this table of sockets (/proc/net/udp).
bool isHeard(int domain, std::istream& table);

/// A DDS domain that no other test process of this machine uses while this one lives, so that
/// tests run side by side, and that no other program had joined before. Domains 1-100; 0 is
/// left to people.
///
/// Held by a lock on a file in the temporary folder, which the kernel drops with the process.
class TestDomain {
 public:
  /// Errors: std::runtime_error if all of them are taken.
  TestDomain();
  ~TestDomain();
  TestDomain(const TestDomain&) = delete;
  TestDomain& operator=(const TestDomain&) = delete;

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_ = 0;
  int file_ = -1;
};

}  // namespace handgraft::test
