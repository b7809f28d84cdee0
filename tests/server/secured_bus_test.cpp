// A server of a secured domain, and clients of each role.
#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/cyclone/requester.h"
#include "idl/hardware.h"
#include "idl/ros2.h"
#include "idl/security/authority.h"
#include "server/admission/service.h"

#include "tests/server/small_grasp.h"
#include "tests/support/test_domain.h"

namespace handgraft::server {
namespace {

using idl::cyclone::Participant;
using idl::cyclone::Reader;
using idl::cyclone::Refused;
using idl::cyclone::Requester;

class Listening final : public BusListener {
 public:
  void onRequest(v1::Request request, const Sender&) override {
    const std::lock_guard lock(mutex_);
    heard_.push_back(request.body()._d());
  }

  void onEdit(v1::Edit, const Sender&) override {}

  void onDemonstrator(v1::DemonstratorFrame, const Sender&) override {}

  void onStatus(const v1::ServerStatus&) override {}

  [[nodiscard]] std::vector<v1::Operation> heard() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<v1::Operation> heard_;
};

class SecuredBus : public testing::Test {
 protected:
  using Role = idl::security::Role;

  SecuredBus() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "handgraft_keys_XXXXXX").string();
    folder = mkdtemp(pattern.data());
    auto authority = idl::security::Authority::make(folder / "ca");
    for (const Role role : idl::security::kRoles)
      authority.add(nameOf(role), role, 10);
    bus = openFastBus(network(Role::kServer));
    bus->start(listener);
  }

  ~SecuredBus() override {
    bus->stop();
    std::filesystem::remove_all(folder);
  }

  [[nodiscard]] Network network(Role role) const {
    Network network{domain.number(), "lo"};
    network.identity = (folder / "ca" / nameOf(role)).string();
    return network;
  }

  static v1::Request asking(const v1::RequestBody& body) {
    v1::Request request;
    request.client({7});
    request.request_id(1);
    request.protocol_version(v1::PROTOCOL_VERSION);
    request.body(body);
    return request;
  }

  /// Says it again until `is_done`.
  static bool repeat(idl::cyclone::Writer<v1::Request>& writer,
                     const v1::Request& request,
                     const std::function<bool()>& is_done) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!is_done()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      writer.write(request);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
  }

  test::TestDomain domain;
  std::filesystem::path folder;
  Listening listener;
  std::unique_ptr<Bus> bus;
};

TEST_F(SecuredBus, RefusesOnATopicWhatTakesMoreThanItsWritersHold) {
  v1::RequestBody unload;
  unload.unload_model(v1::ModelKey());
  {
    const Participant editor(network(Role::kEditor));
    idl::cyclone::Writer<v1::Request> writer(editor, idl::kRequestTopic);
    Reader<v1::Reply> replies(editor, idl::kReplyTopic);
    std::optional<v1::Reply> reply;
    ASSERT_TRUE(repeat(writer, asking(unload), [&] {
      replies.take([&](const v1::Reply& one) {
        reply = one;
      });
      return reply.has_value();
    }));
    EXPECT_EQ(reply->error(), v1::ERROR_NOT_PERMITTED);
    EXPECT_EQ(reply->message(), "unload_model is for operators");
    EXPECT_TRUE(listener.heard().empty());
    EXPECT_TRUE(repeat(writer, asking(test::plain(v1::OP_LIST_MODELS)), [&] {
      return !listener.heard().empty();
    }));
  }
  const Participant op(network(Role::kOperator));
  idl::cyclone::Writer<v1::Request> operating(op, idl::kOperateTopic);
  EXPECT_TRUE(repeat(operating, asking(unload), [&] {
    const auto heard = listener.heard();
    return !heard.empty() && heard.back() == v1::OP_UNLOAD_MODEL;
  }));
}

TEST_F(SecuredBus, LetsEachRoleWriteAndReadWhatItMay) {
  using idl::cyclone::NotPermitted;
  using idl::cyclone::Writer;
  // One identity of a process at a time.
  {
    const Participant viewer(network(Role::kViewer));
    EXPECT_THROW(Participant{network(Role::kEditor)}, InvalidInput);
    EXPECT_NO_THROW(Writer<v1::Request>(viewer, idl::kLookTopic));
    EXPECT_THROW(Writer<v1::Request>(viewer, idl::kRequestTopic), NotPermitted);
    EXPECT_THROW(Writer<v1::Edit>(viewer, idl::kEditTopic), NotPermitted);
    EXPECT_THROW(Writer<v1::HandCommand>(viewer, idl::kHandCommandTopic), NotPermitted);
    EXPECT_NO_THROW(Reader<v1::Reply>(viewer, idl::kReplyTopic));
    EXPECT_NO_THROW(Reader<v1::BridgeStatus>(viewer, idl::kBridgeStatusTopic));
  }
  {
    const Participant editor(network(Role::kEditor));
    EXPECT_THROW(Writer<v1::Request>(editor, idl::kOperateTopic), NotPermitted);
    EXPECT_THROW(Writer<v1::HandCommand>(editor, idl::kHandCommandTopic), NotPermitted);
    EXPECT_THROW(Writer<v1::PoseSolution>(editor, idl::kSolutionTopic), NotPermitted);
    EXPECT_NO_THROW(Writer<v1::Edit>(editor, idl::kEditTopic));
  }
  const Participant hand(network(Role::kHand));
  EXPECT_THROW(Writer<v1::Request>(hand, idl::kRequestTopic), NotPermitted);
  EXPECT_THROW(Writer<v1::HandCommand>(hand, idl::kHandCommandTopic), NotPermitted);
  using Trajectory = trajectory_msgs::msg::dds_::JointTrajectory_;
  EXPECT_NO_THROW(Writer<Trajectory>(hand, idl::kRosTrajectoryTopic));
  EXPECT_NO_THROW(Reader<Trajectory>(hand, idl::kRosSamplesTopic));
  EXPECT_THROW(Writer<Trajectory>(hand, idl::kRosSamplesTopic), NotPermitted);
}

TEST_F(SecuredBus, ShowsSessionsToViewersAndNothingToStrangers) {
  v1::SessionState state;
  state.session_id(5);
  const auto is_seen = [&](const Network& by, std::chrono::seconds patience) {
    const Participant participant(by);
    Reader<v1::SessionState> states(participant, idl::kSessionTopic);
    bool found = false;
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (!found && std::chrono::steady_clock::now() < deadline) {
      bus->publish(state);
      states.wait(std::chrono::milliseconds(100));
      states.take([&](const v1::SessionState& one) {
        found = one.session_id() == 5;
      });
    }
    EXPECT_TRUE(found || participant.identity() || participant.isKeptOut());
    return found;
  };
  EXPECT_TRUE(is_seen(network(Role::kViewer), std::chrono::seconds(20)));
  EXPECT_FALSE(is_seen({domain.number(), "lo"}, std::chrono::seconds(3)));
  auto others = idl::security::Authority::make(folder / "others");
  Network stranger{domain.number(), "lo"};
  stranger.identity = others.add("editor", Role::kEditor, 10).folder.string();
  EXPECT_FALSE(is_seen(stranger, std::chrono::seconds(3)));
}

TEST_F(SecuredBus, IsServedByAServersIdentityAlone) {
  EXPECT_THROW(openFastBus(network(Role::kOperator)), InvalidInput);
  EXPECT_THROW(Participant{network(Role::kServer)}, InvalidInput);
}

}  // namespace
}  // namespace handgraft::server
