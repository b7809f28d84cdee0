// The server's bus without a service behind it.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/cyclone/requester.h"
#include "server/admission/service.h"

#include "tests/server/small_grasp.h"
#include "tests/support/test_domain.h"

namespace handgraft::server {
namespace {

using idl::cyclone::Participant;
using idl::cyclone::Reader;
using idl::cyclone::Requester;

class MeshServer final : public BusListener {
 public:
  MeshServer(Bus& bus, std::size_t bytes) : bus_(bus), mesh_() {
    mesh_.vertices_m().resize(bytes / 4);
    for (std::size_t i = 0; i < mesh_.vertices_m().size(); ++i) {
      mesh_.vertices_m()[i] = static_cast<float>(i % 1000);
    }
  }

  void onRequest(v1::Request request, const Sender& sender) override {
    v1::ObjectDescription object;
    object.mesh_O(mesh_);
    v1::ModelDescription description;
    description.object(object);
    v1::Reply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.body().model(description);
    bus_.publish(reply, sender);
  }

  void onEdit(v1::Edit, const Sender&) override {}

  void onDemonstrator(v1::DemonstratorFrame, const Sender&) override {}

  void onStatus(const v1::ServerStatus&) override {}

  void sayAlive() {
    v1::ServerStatus status;
    status.server_id(1);
    status.protocol_version(v1::PROTOCOL_VERSION);
    bus_.publish(status);
  }

  [[nodiscard]] const v1::Mesh& mesh() const { return mesh_; }

 private:
  Bus& bus_;
  v1::Mesh mesh_;
};

TEST(FastBus, CarriesAReplyOfEightMegabytes) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  MeshServer server(*bus, 8u << 20);
  bus->start(server);
  std::jthread alive([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      server.sayAlive();
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
  const Participant participant(network);
  Requester client(participant);
  const auto reply = client.ask(test::describeModel(v1::MODEL_OBJECT, "x", true));
  EXPECT_EQ(reply.model().object().mesh_O().vertices_m(), server.mesh().vertices_m());
  alive.request_stop();
  alive.join();
  bus->stop();
}

TEST(FastBus, TellsWhoIsOverItsShare) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);

  /// Answers nothing.
  class Mute final : public BusListener {
   public:
    void onRequest(v1::Request, const Sender&) override {}

    void onEdit(v1::Edit, const Sender&) override {}

    void onDemonstrator(v1::DemonstratorFrame, const Sender&) override {}

    void onStatus(const v1::ServerStatus&) override {}
  } mute;

  bus->start(mute);
  const Participant participant(network);
  Requester client(participant);
  std::promise<std::string> told;
  std::atomic<bool> is_told{false};
  client.begin(
      test::plain(v1::OP_LIST_MODELS), [](const auto&) {},
      [&](const std::string& stage, double) {
        if (!is_told.exchange(true)) told.set_value(stage);
      });
  idl::cyclone::Writer<v1::Request> flood(participant, idl::kRequestTopic);
  v1::Request question;
  question.body().nothing(v1::Nothing());
  std::future<std::string> says = told.get_future();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  v1::ServerStatus alive;
  alive.server_id(1);
  alive.protocol_version(v1::PROTOCOL_VERSION);
  while (!is_told && std::chrono::steady_clock::now() < deadline) {
    bus->publish(alive);
    for (int i = 0; i < 3000; ++i) {
      question.request_id(question.request_id() + 1);
      try {
        flood.write(question);
      } catch (const idl::cyclone::WriteTimeout&) {
        break;
      }
    }
    bus->lookAround();
  }
  ASSERT_TRUE(is_told);
  EXPECT_THAT(says.get(), testing::HasSubstr("over this program's share: 100 messages"));
  bus->stop();
}

TEST(FastBus, ForgetsClosedSessionsAndKeepsOpenOnesForLateJoiners) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  v1::SessionState state;
  for (std::uint64_t id = 1; id <= 400; ++id) {
    state.session_id(id);
    state.phase(v1::PHASE_OPEN);
    bus->publish(state);
    if (id == 5 || id == 400) continue;  // these stay open
    state.phase(v1::PHASE_CLOSED);
    bus->publish(state);
  }
  const Participant participant(network);
  Reader<v1::SessionState> late(participant, idl::kSessionTopic);
  int closed = 0;
  std::vector<std::uint64_t> open;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (open.size() < 2 && std::chrono::steady_clock::now() < deadline) {
    late.wait(std::chrono::milliseconds(100));
    late.take([&](const v1::SessionState& one) {
      closed += one.phase() == v1::PHASE_CLOSED;
      if (one.phase() == v1::PHASE_OPEN) open.push_back(one.session_id());
    });
  }
  EXPECT_THAT(open, testing::UnorderedElementsAre(5, 400));
  EXPECT_LE(closed, 128);
}

TEST(FastBus, KeepsOfSessionsAtRestWhatLateJoinersOfTheLatestHear) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  v1::SessionState state;
  state.phase(v1::PHASE_READY);
  for (std::uint64_t id = 1; id <= 600; ++id) {
    state.session_id(id);
    bus->publish(state);
    if (id != 7) bus->rest(id);
  }
  state.session_id(3);  // wakes, and rests again
  bus->publish(state);
  bus->rest(3);
  const Participant participant(network);
  Reader<v1::SessionState> late(participant, idl::kSessionTopic);
  std::set<std::uint64_t> heard;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (heard.count(600) + heard.count(7) + heard.count(3) < 3 &&
         std::chrono::steady_clock::now() < deadline) {
    late.wait(std::chrono::milliseconds(100));
    late.take([&](const v1::SessionState& one) {
      heard.insert(one.session_id());
    });
  }
  EXPECT_THAT(heard, testing::IsSupersetOf({3, 7, 590, 600}));
  EXPECT_LE(heard.size(), 128 + 96 + 1);
}

/// Hears the states of session 1 on Cyclone's thread.
class StateListener {
 public:
  explicit StateListener(const Network& network)
      : participant_(network), states_(participant_, idl::kSessionTopic, [this] {
          states_.take([this](const v1::SessionState& one) {
            const std::lock_guard lock(mutex_);
            revisions_.push_back(one.revision());
          });
          news_.notify_all();
        }) {}

  /// The revisions so far, waited for until the last is at least `last`; a minute at most.
  std::vector<std::uint64_t> until(std::uint64_t last) {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, std::chrono::seconds(60), [&] {
      return !revisions_.empty() && revisions_.back() >= last;
    });
    return revisions_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable news_;
  std::vector<std::uint64_t> revisions_;
  Participant participant_;
  Reader<v1::SessionState> states_;
};

// Readers that joined while states were replaced heard the first one, and then nothing.
TEST(FastBus, LetsLateReadersHearWhatFollows) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  std::atomic<std::uint64_t> revision{0};
  std::jthread editing([&](const std::stop_token& stop) {
    v1::SessionState state;
    state.session_id(1);
    while (!stop.stop_requested()) {
      state.revision(++revision);
      bus->publish(state);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  for (int i = 0; i < 5; ++i) {
    StateListener late(network);
    ASSERT_FALSE(late.until(1).empty()) << "reader " << i << " heard nothing";
    const std::uint64_t later = revision + 100;
    EXPECT_GE(late.until(later).back(), later) << "reader " << i << " went deaf";
  }
}

TEST(FastBus, TellsEveryReaderEveryStateInOrder) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  v1::SessionState state;
  state.session_id(1);
  bus->publish(state);
  StateListener first(network);
  StateListener second(network);
  first.until(0);
  second.until(0);
  constexpr std::uint64_t kBurst = 50;  // readers keep 64 that they have not taken
  std::vector<std::uint64_t> sent{0};
  for (std::uint64_t revision = 1; revision <= 10 * kBurst; ++revision) {
    state.revision(revision);
    bus->publish(state);
    sent.push_back(revision);
    if (revision % kBurst != 0) continue;
    first.until(revision);
    second.until(revision);
  }
  EXPECT_EQ(first.until(sent.back()), sent);
  EXPECT_EQ(second.until(sent.back()), sent);
  // Who comes later is told what is so now, and nothing that was.
  StateListener late(network);
  EXPECT_THAT(late.until(sent.back()), testing::ElementsAre(sent.back()));
}

TEST(FastBus, CarriesThePoseOfTheLargestHand) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  constexpr std::size_t kJoints = 512;
  v1::PoseSolution solution;
  solution.session_id(1);
  solution.joint_positions().assign(kJoints, 0.25);
  for (std::size_t i = 0; i <= kJoints; ++i) {
    v1::Pose X_WL;
    X_WL.p_m({0.001 * static_cast<double>(i), 0.0, 0.0});
    solution.X_WL().push_back(X_WL);
  }
  v1::MinimumInfo minimum;
  minimum.joint_positions().assign(kJoints, 0.5);
  solution.minima().assign(8, minimum);
  ASSERT_GT(v1::PoseSolution::getCdrSerializedSize(solution), 65'500u) << "fits a datagram";
  const Participant participant(network);
  Reader<v1::PoseSolution> reader(participant, idl::kSolutionTopic);
  std::optional<v1::PoseSolution> seen;
  // Also one after another, each in the middle of the other's datagrams.
  constexpr std::uint64_t kLast = 200;
  for (std::uint64_t i = 1; i <= kLast; ++i) {
    solution.sequence_number(i);
    bus->publish(solution);
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while ((!seen || seen->sequence_number() < kLast) &&
         std::chrono::steady_clock::now() < deadline) {
    reader.wait(std::chrono::milliseconds(100));
    reader.take([&](const v1::PoseSolution& one) {
      seen = one;
    });
  }
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(*seen, solution);
}
}  // namespace
}  // namespace handgraft::server
