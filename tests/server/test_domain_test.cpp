// Tests keep off the domains of programs that are there.
#include "tests/support/test_domain.h"

#include <sstream>

#include <gtest/gtest.h>

namespace handgraft::test {
namespace {

TEST(TestDomain, KnowsWhoHearsOnADomain) {
  // A server on domain 74: ports 25910 and 25911 of the loopback.
  constexpr const char* kTable =
      "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n"
      " 1234: 0100007F:6536 00000000:0000 07 00000000:00000000 00:00000000 00000000     0\n"
      " 1235: 0100007F:6537 00000000:0000 07 00000000:00000000 00:00000000 00000000     0\n";
  for (const int domain : {73, 74, 75}) {
    std::istringstream table(kTable);
    EXPECT_EQ(isHeard(domain, table), domain == 74) << domain;
  }
  std::istringstream nobody("   sl  local_address\n");
  EXPECT_FALSE(isHeard(74, nobody));
}

}  // namespace
}  // namespace handgraft::test
