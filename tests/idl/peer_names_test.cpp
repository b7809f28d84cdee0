#include "idl/peer_names.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::idl {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

Network networkOf(std::vector<std::string> peers) {
  return {0, "lo", std::move(peers), "left"};
}

std::chrono::steady_clock::duration timeOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::steady_clock::now() - start;
}

TEST(PeerNames, AreAskedForAgainWhereAQuestionWasLost) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const NameService loses_the_first = [asked](const std::string&) -> NameAnswer {
    if (asked->fetch_add(1) == 0) std::this_thread::sleep_for(std::chrono::seconds(5));
    return {"10.89.0.7", "", true};
  };
  const auto took = timeOf([&] {
    const Network reached = withPeerAddresses(networkOf({"server"}), nullptr, loses_the_first);
    EXPECT_THAT(reached.peers, ElementsAre("10.89.0.7"));
    EXPECT_EQ(reached.server, "left") << "all else stays";
  });
  EXPECT_LT(took, milliseconds(1500));
}

TEST(PeerNames, SayWhenTheNameServiceIsSilent) {
  const NameService silent = [](const std::string&) -> NameAnswer {
    std::this_thread::sleep_for(std::chrono::seconds(6));
    return {};
  };
  const auto took = timeOf([&] {
    EXPECT_THAT(
        [&] {
          withPeerAddresses(networkOf({"server"}), nullptr, silent);
        },
        ThrowsMessage<TransportError>(HasSubstr(
            "peers: 'server' has no IPv4 address yet: the name service did not answer")));
  });
  EXPECT_LT(took, milliseconds(3500));
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
  const NameService knows_one = [](const std::string& name) -> NameAnswer {
    if (name == "server") return {"10.89.0.7", "", true};
    return {"", "not known", true};
  };
  const auto took = timeOf([&] {
    EXPECT_THAT(
        [&] {
          withPeerAddresses(networkOf({"server", "tpyo"}), nullptr, knows_one);
        },
        ThrowsMessage<InvalidInput>(HasSubstr("'tpyo' has no IPv4 address: not known")));
  });
  EXPECT_LT(took, milliseconds(1500));
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
