#include "idl/peer_names.h"

#include <atomic>
#include <future>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::idl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

Network networkOf(std::vector<std::string> peers) {
  return {0, "lo", std::move(peers), "left"};
}

TEST(PeerNames, AreAskedForAgainWhereAQuestionWasLost) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  // Ready when this test ends: who waited for the first answer would wait for ever.
  std::promise<void> end;
  const std::shared_future<void> ends(end.get_future());
  const NameService loses_the_first = [asked, ends](const std::string&) -> NameAnswer {
    if (asked->fetch_add(1) == 0) ends.wait();
    return {"10.89.0.7", "", true};
  };
  const Network reached = withPeerAddresses(networkOf({"server"}), nullptr, loses_the_first);
  EXPECT_THAT(reached.peers, ElementsAre("10.89.0.7"));
  EXPECT_EQ(reached.server, "left") << "all else stays";
  EXPECT_GE(*asked, 2);
}

TEST(PeerNames, SayWhenTheNameServiceIsSilent) {
  std::promise<void> end;
  const std::shared_future<void> ends(end.get_future());
  const NameService silent = [ends](const std::string&) -> NameAnswer {
    ends.wait();
    return {};
  };
  EXPECT_THAT(
      [&] {
        withPeerAddresses(networkOf({"server"}), nullptr, silent);
      },
      ThrowsMessage<TransportError>(HasSubstr(
          "peers: 'server' has no IPv4 address yet: the name service did not answer")));
}

TEST(PeerNames, AreAskedForUntilTheNameServiceKnowsThem) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const NameService busy = [asked](const std::string&) -> NameAnswer {
    if (asked->fetch_add(1) < 2) return {"", "try again", false};
    return {"10.89.0.7", "", true};
  };
  EXPECT_THAT(withPeerAddresses(networkOf({"server"}), nullptr, busy).peers,
              ElementsAre("10.89.0.7"));
  EXPECT_EQ(*asked, 3);
}

TEST(PeerNames, ThatNobodyKnowsAreToldAtOnceOrPassedOver) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const NameService knows_one = [asked](const std::string& name) -> NameAnswer {
    ++*asked;
    if (name == "server") return {"10.89.0.7", "", true};
    return {"", "not known", true};
  };
  EXPECT_THAT(
      [&] {
        withPeerAddresses(networkOf({"server", "tpyo"}), nullptr, knows_one);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'tpyo' has no IPv4 address: not known")));
  EXPECT_EQ(*asked, 2) << "who knows that there is none is not asked again";
  std::vector<std::string> without;
  EXPECT_THAT(withPeerAddresses(networkOf({"tpyo", "server"}), &without, knows_one).peers,
              ElementsAre("10.89.0.7"));
  EXPECT_THAT(without, ElementsAre("tpyo"));
}

TEST(PeerNames, AddressesAreNotAskedFor) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const NameService counts = [asked](const std::string&) -> NameAnswer {
    ++*asked;
    return {};
  };
  EXPECT_THAT(withPeerAddresses(networkOf({"10.0.0.1"}), nullptr, counts).peers,
              ElementsAre("10.0.0.1"));
  EXPECT_THAT(withPeerAddresses(networkOf({}), nullptr, counts).peers, IsEmpty());
  EXPECT_EQ(*asked, 0);
  EXPECT_EQ(askNameService("localhost").address, "127.0.0.1");
  EXPECT_TRUE(askNameService("no.such.host.invalid").address.empty());
}

}  // namespace
}  // namespace handgraft::idl
