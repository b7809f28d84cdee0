#include "core/base/network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

TEST(Network, TakesAnInterfaceByNameOrAddress) {
  EXPECT_EQ(validate({0, "lo"}).address, "127.0.0.1");
  EXPECT_EQ(validate({0, "127.0.0.1"}).name, "lo");
  EXPECT_TRUE(validate({0, "lo"}).loopback);
  EXPECT_THAT(
      [] {
        validate({0, "127.0.0.9"});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("127.0.0.9")));
  EXPECT_THAT(
      [] {
        validate({101, "lo"});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("0-100")));
}

TEST(Network, NeverTakesTheLoopbackForAuto) {
  try {
    EXPECT_FALSE(validate({0, "auto"}).loopback);
  } catch (const InvalidInput& error) {  // a machine without a network
    EXPECT_THAT(error.what(), HasSubstr("auto"));
  }
}

TEST(Network, AsksPeersOneByOne) {
  const NetworkInterface there{"eth0", "10.77.0.1", false};
  EXPECT_THAT(unicastAddresses({0, "eth0"}, there), IsEmpty()) << "by multicast alone";
  EXPECT_THAT(unicastAddresses({0, "lo"}, {"lo", "127.0.0.1", true}), ElementsAre("127.0.0.1"));
  EXPECT_THAT(unicastAddresses({0, "eth0", {"10.77.0.2", "10.77.0.1", "10.77.0.2"}}, there),
              ElementsAre("10.77.0.1", "10.77.0.2"))
      << "programs of this host, too";
  EXPECT_THAT(unicastAddresses({0, "eth0", {"localhost"}}, there),
              ElementsAre("10.77.0.1", "127.0.0.1"));
}

TEST(Network, NamesAPeerThatIsNone) {
  const NetworkInterface there{"eth0", "10.77.0.1", false};
  for (const char* peer : {"", "no.such.host.invalid", "10.77.0.", "a b"}) {
    EXPECT_THAT(
        [&] {
          unicastAddresses({0, "eth0", {peer}}, there);
        },
        ThrowsMessage<InvalidInput>(HasSubstr(quoted(peer))));
  }
  const std::vector<std::string> many(kMostPeers + 1, "10.77.0.2");
  EXPECT_THAT(
      [&] {
        validate({0, "lo", many});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("at most 32")));
}

TEST(Network, TakesPeersThatHaveNoAddressYetIfAsked) {
  std::vector<std::string> without;
  EXPECT_THAT(unicastAddresses({0, "eth0", {"no.such.host.invalid", "10.77.0.2"}},
                               {"eth0", "10.77.0.1", false}, &without),
              ElementsAre("10.77.0.1", "10.77.0.2"));
  EXPECT_THAT(without, ElementsAre("no.such.host.invalid"));
}

TEST(Network, KnowsServersByNamesThatRosTakes) {
  for (const char* name : {"", "left", "Lab_2", "a"})
    EXPECT_NO_THROW(validate({0, "lo", {}, name})) << name;
  const std::string long_name(kLongestServerName + 1, 'a');
  for (const std::string& name : {std::string("le-ft"), std::string("2"), std::string("_a"),
                                  std::string("a b"), std::string("*"), long_name}) {
    EXPECT_THAT(
        [&] {
          validate({0, "lo", {}, name});
        },
        ThrowsMessage<InvalidInput>(HasSubstr(quoted(name))));
  }
}

TEST(Network, IsToldWithItsPeers) {
  EXPECT_EQ(describe({7, "eth0"}), "domain 7, interface eth0");
  EXPECT_EQ(describe({7, "eth0", {"a", "b"}}), "domain 7, interface eth0, peers a b");
  EXPECT_EQ(describe({7, "eth0", {"a"}, "left"}),
            "domain 7, interface eth0, server left, peers a");
}

}  // namespace
}  // namespace handgraft
