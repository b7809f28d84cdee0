// Whom the server's answers reach: Fast DDS on the server's side, Cyclone DDS on the clients'.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "idl/security/authority.h"
#include "server/transport/bus.h"

#include "tests/server/hearing_client.h"
#include "tests/support/process.h"
#include "tests/support/test_domain.h"

namespace handgraft::server {
namespace {

/// Answers every request after a word of its progress, and every edit.
class Answering final : public BusListener {
 public:
  explicit Answering(Bus& bus) : bus_(bus) {}

  void onRequest(v1::Request request, const Sender& sender) override {
    v1::Progress progress;
    progress.client(request.client());
    progress.request_id(request.request_id());
    bus_.publish(progress, sender);
    v1::Reply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    bus_.publish(reply, sender);
  }

  void onEdit(v1::Edit edit, const Sender& sender) override {
    v1::EditReply reply;
    reply.client(edit.client());
    reply.edit_id(edit.edit_id());
    bus_.publish(reply, sender);
  }

  void onDemonstrator(v1::DemonstratorFrame, const Sender&) override {}

  void onStatus(const v1::ServerStatus&) override {}

 private:
  Bus& bus_;
};

void answersWhoAskedAlone(const Network& servers, const Network& clients) {
  const auto bus = openFastBus(servers);
  Answering server(*bus);
  bus->start(server);
  std::vector<std::string> arguments{std::to_string(clients.domain)};
  if (!clients.identity.empty()) arguments.push_back(clients.identity);
  test::Process other(HANDGRAFT_HEARING_CLIENT, arguments);  // which claims the same name
  ASSERT_TRUE(other.waitForText("asked")) << other.err();
  test::HearingClient one(clients);
  ASSERT_TRUE(one.ask(1));
  EXPECT_GT(one.heard(), 0);  // progress, if nothing else
  constexpr std::uint64_t kMoreThanAWriterKeeps = 300;
  for (std::uint64_t id = 2; id < kMoreThanAWriterKeeps; ++id)
    ASSERT_TRUE(one.ask(id)) << id;
  // Who was told nothing for so long hears its own answers as before.
  other.send(SIGUSR1);
  EXPECT_EQ(other.wait(), 0) << other.err();
  EXPECT_NE(other.out().find("heard 0\n"), std::string::npos) << other.out();
  EXPECT_TRUE(one.ask(kMoreThanAWriterKeeps));
  bus->stop();
}

TEST(Answers, ReachWhoAskedAlone) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  answersWhoAskedAlone(network, network);
}

TEST(Answers, ReachWhoAskedAloneInASecuredDomain) {
  using idl::security::Role;
  const test::TestDomain domain;
  std::string folder =
      (std::filesystem::temp_directory_path() / "handgraft_keys_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  auto authority = idl::security::Authority::make(std::filesystem::path(folder) / "ca");
  const auto network = [&](Role role) {
    authority.add(nameOf(role), role, 10);
    Network made{domain.number(), "lo"};
    made.identity = folder + "/ca/" + nameOf(role);
    return made;
  };
  answersWhoAskedAlone(network(Role::kServer), network(Role::kEditor));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace handgraft::server
