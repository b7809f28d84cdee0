// Fast DDS on the server's side, Cyclone DDS on the client's, on loopback.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "idl/cyclone/requester.h"
#include "idl/hardware.h"
#include "idl/ros2.h"
#include "idl/security/authority.h"
#include "server/admission/service.h"

#include "tests/server/small_grasp.h"
#include "tests/support/test_domain.h"

namespace handgraft::server {
namespace {

using idl::cyclone::NoServer;
using idl::cyclone::Participant;
using idl::cyclone::Reader;
using idl::cyclone::Refused;
using idl::cyclone::Requester;

/// A server and a client in this process, on a domain of their own.
class CrossingTest : public testing::Test {
 protected:
  CrossingTest() { service.start(); }

  v1::ErrorCode refusalOf(const v1::RequestBody& body) {
    try {
      client.ask(body);
    } catch (const Refused& refused) {
      return refused.code();
    }
    return v1::ERROR_NONE;
  }

  test::TestDomain domain;
  Network network{domain.number(), "lo"};
  ModelStore models;
  std::unique_ptr<Bus> bus = openFastBus(network);
  Service service{*bus, models, ServiceOptions()};
  Participant participant{network};
  Requester client{participant};
};

TEST_F(CrossingTest, FindsTheServer) {
  EXPECT_TRUE(client.waitForServer(std::chrono::seconds(20)));
  EXPECT_NO_THROW(client.requireServer());
  EXPECT_EQ(client.status().protocol_version(), v1::PROTOCOL_VERSION);
  EXPECT_FALSE(client.status().stopping());
}

/// eProsima's statistics submessage, on which Fast DDS 2.9.1 ends the process by an assertion.
TEST_F(CrossingTest, OutlivesADatagramOfStatistics) {
  ASSERT_TRUE(client.waitForServer(std::chrono::seconds(20)));
  const std::string datagram = std::string("RTPS\x02\x03\x01\x0f", 8) +
                               std::string(12, '\x11') + std::string("\x80\x01\x38\x00", 4) +
                               std::string(60, '\0');
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  for (const int offset : {10, 11, 12, 13}) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain.number() + offset));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::sendto(socket, datagram.data(), datagram.size(), 0,
                       reinterpret_cast<const sockaddr*>(&to), sizeof to),
              static_cast<ssize_t>(datagram.size()));
  }
  ::close(socket);
  EXPECT_EQ(client.ask(test::plain(v1::OP_NOTHING))._d(), v1::OP_NOTHING);
}

TEST_F(CrossingTest, CarriesEveryOperation) {
  for (const v1::RequestBody& body : test::smallGrasp())
    client.ask(body);
  EXPECT_EQ(client.ask(test::plain(v1::OP_NOTHING))._d(), v1::OP_NOTHING);
  EXPECT_EQ(client.ask(test::plain(v1::OP_LIST_MODELS)).models().models().size(), 3u);
  const auto hand = client.ask(test::describeModel(v1::MODEL_HAND, "clamp", true));
  EXPECT_EQ(hand.model().hand().joints().at(0).name(), "hinge");
  EXPECT_EQ(hand.model().hand().urdf(), test::kClampUrdf);
  EXPECT_FALSE(hand.model().hand().skin_S().triangles().empty());
  const auto object = client.ask(test::describeModel(v1::MODEL_OBJECT, "fruit", true));
  EXPECT_FALSE(object.model().object().mesh_O().vertices_m().empty());
  const auto marks = client.ask(test::describeModel(v1::MODEL_CONTACTS, "marks", false));
  EXPECT_EQ(marks.model().contacts().patches().size(), 6u);

  const auto opened = client.ask(test::openSession("clamp", "fruit", "marks"));
  const std::uint64_t session = opened.session().session_id();
  EXPECT_EQ(client.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).session().hand(),
            "clamp");
  EXPECT_EQ(client.ask(test::plain(v1::OP_LIST_SESSIONS)).sessions().sessions().size(), 1u);
  EXPECT_EQ(client.ask(test::ofSession(v1::OP_TRANSFER, session)).transfer().session_id(),
            session);
  const auto solved = client.ask(test::optimize(session));
  EXPECT_TRUE(solved.solution().is_final());
  EXPECT_FALSE(client.ask(test::exportProblem(session)).exported_file().content().empty());

  // A late joiner sees the last pose and the state at once.
  Reader<v1::PoseSolution> solutions(participant, idl::kSolutionTopic);
  ASSERT_TRUE(solutions.wait(std::chrono::seconds(20)));
  solutions.take([&](const v1::PoseSolution& late) {
    EXPECT_EQ(late.session_id(), session);
    EXPECT_EQ(late.joint_positions(), solved.solution().joint_positions());
    EXPECT_EQ(late.terms().objective(), solved.solution().terms().objective());
  });

  v1::EditBody edit;
  edit.X_WO(v1::Pose());
  EXPECT_THROW(client.edit(session, 0, edit), Refused);  // a quaternion of norm 0
  v1::Pose pose;
  pose.q_wxyz({1.0, 0.0, 0.0, 0.0});
  edit.X_WO(pose);
  EXPECT_EQ(client.edit(session, 0, edit).revision(), 1u);

  client.ask(test::ofSession(v1::OP_CLOSE_SESSION, session));
  EXPECT_EQ(refusalOf(test::ofSession(v1::OP_TRANSFER, session)), v1::ERROR_NOT_FOUND);
  client.ask(test::unloadModel(v1::MODEL_HAND, "clamp"));
  EXPECT_EQ(client.ask(test::cancel(1))._d(), v1::OP_CANCEL);
}

TEST_F(CrossingTest, UploadsAFileInChunks) {
  const std::string obj = test::builtIn("objects/lemon.obj");
  constexpr std::size_t kChunk = 100'000;
  ASSERT_GT(obj.size(), 2 * kChunk);
  for (std::size_t at = 0; at < obj.size(); at += kChunk) {
    v1::RequestBody body = test::putFile(1, "lemon.obj", obj.substr(at, kChunk));
    body.put_file().offset(at);
    body.put_file().total_bytes(obj.size());
    client.ask(body);
  }
  const auto reply = client.ask(test::loadModel(1, v1::MODEL_OBJECT, "fruit", "lemon.obj"));
  EXPECT_EQ(reply.models().models().at(0).name(), "fruit");
}

TEST_F(CrossingTest, RefusesWhatDoesNotFitTheBoundsBeforeItIsSent) {
  const std::string too_long(524'289, 'x');
  EXPECT_THROW(client.ask(test::putFile(1, "a", too_long)), TransportError);
}

TEST_F(CrossingTest, SaysThatTheServerWentAway) {
  ASSERT_TRUE(client.waitForServer(std::chrono::seconds(20)));
  service.stop();
  EXPECT_THROW(client.ask(test::plain(v1::OP_LIST_MODELS)), NoServer);
}

TEST(Requester, SaysWhereItLookedForAServer) {
  const test::TestDomain domain;
  const Participant participant({domain.number(), "lo"});
  Requester client(participant);
  try {
    client.ask(test::plain(v1::OP_LIST_MODELS));
    FAIL() << "a server answered";
  } catch (const NoServer& error) {
    EXPECT_EQ(std::string(error.what()), "no handgraft-server answers on domain " +
                                             std::to_string(domain.number()) +
                                             ", interface lo");
  }
}

// === A secured domain

/// Remembers what it hears.
class Listening final : public BusListener {
 public:
  void onRequest(v1::Request request, const Sender&) override {
    const std::lock_guard lock(mutex_);
    heard_.push_back(request.body()._d());
  }

  void onEdit(v1::Edit, const Sender&) override {}

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
    folder_ = mkdtemp(pattern.data());
    auto authority = idl::security::Authority::make(folder_ / "ca");
    for (const Role role : idl::security::kRoles)
      authority.add(nameOf(role), role, 10);
    bus_ = openFastBus(network(Role::kServer));
    bus_->start(listener_);
  }

  ~SecuredBus() override {
    bus_->stop();
    std::filesystem::remove_all(folder_);
  }

  [[nodiscard]] Network network(Role role) const {
    Network network{domain_.number(), "lo"};
    network.identity = (folder_ / "ca" / nameOf(role)).string();
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

  test::TestDomain domain_;
  std::filesystem::path folder_;
  Listening listener_;
  std::unique_ptr<Bus> bus_;
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
    EXPECT_TRUE(listener_.heard().empty());
    EXPECT_TRUE(repeat(writer, asking(test::plain(v1::OP_LIST_MODELS)), [&] {
      return !listener_.heard().empty();
    }));
  }
  const Participant op(network(Role::kOperator));
  idl::cyclone::Writer<v1::Request> operating(op, idl::kOperateTopic);
  EXPECT_TRUE(repeat(operating, asking(unload), [&] {
    const auto heard = listener_.heard();
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
  const auto isSeen = [&](const Network& by, std::chrono::seconds patience) {
    const Participant participant(by);
    Reader<v1::SessionState> states(participant, idl::kSessionTopic);
    bool is_seen = false;
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (!is_seen && std::chrono::steady_clock::now() < deadline) {
      bus_->publish(state);
      states.wait(std::chrono::milliseconds(100));
      states.take([&](const v1::SessionState& one) {
        is_seen = one.session_id() == 5;
      });
    }
    EXPECT_TRUE(is_seen || participant.identity() || participant.isKeptOut());
    return is_seen;
  };
  EXPECT_TRUE(isSeen(network(Role::kViewer), std::chrono::seconds(20)));
  EXPECT_FALSE(isSeen({domain_.number(), "lo"}, std::chrono::seconds(3)));
  auto others = idl::security::Authority::make(folder_ / "others");
  Network stranger{domain_.number(), "lo"};
  stranger.identity = others.add("editor", Role::kEditor, 10).folder.string();
  EXPECT_FALSE(isSeen(stranger, std::chrono::seconds(3)));
}

TEST_F(SecuredBus, IsServedByAServersIdentityAlone) {
  EXPECT_THROW(openFastBus(network(Role::kOperator)), InvalidInput);
  EXPECT_THROW(Participant{network(Role::kServer)}, InvalidInput);
}

// === The bus alone

/// Answers every request with a mesh of `bytes`.
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

v1::RequestBody savedSession(std::size_t bytes) {
  v1::LoadSessionRequest request;
  request.text(std::string(bytes, ' '));
  v1::RequestBody body;
  body.load_session(request);
  return body;
}

TEST_F(CrossingTest, TakesSavedSessionsOfManyMegabytes) {
  EXPECT_EQ(refusalOf(savedSession(15u << 20)), v1::ERROR_INVALID_INPUT) << "it is no session";
}

TEST_F(CrossingTest, RefusesWhatTheServerWouldDropAndNamesTheLimit) {
  try {
    client.ask(savedSession(17u << 20));
    FAIL() << "17 MiB were sent";
  } catch (const TransportError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("17.0 MiB"));
    EXPECT_THAT(error.what(), testing::HasSubstr("16 MiB"));
  }
}

// === Payloads that no IDL compiler made

/// Any bytes under the type name of Request.
struct Bytes {
  std::string payload;
};

class BytesType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

  BytesType() {
    setName("handgraft::v1::Request");
    m_typeSize = 18 * 1024 * 1024;
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, Payload* payload) override {
    const std::string& bytes = static_cast<Bytes*>(data)->payload;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }

  bool deserialize(Payload*, void*) override { return false; }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->payload.size());
    };
  }

  void* createData() override { return new Bytes(); }

  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }

  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override {
    return false;
  }
};

TEST_F(CrossingTest, OutlivesHostilePayloads) {
  namespace dds = eprosima::fastdds::dds;
  client.requireServer();
  auto* factory = dds::DomainParticipantFactory::get_instance();
  auto* attacker = factory->create_participant(static_cast<dds::DomainId_t>(network.domain),
                                               dds::PARTICIPANT_QOS_DEFAULT);
  ASSERT_NE(attacker, nullptr);
  const dds::TypeSupport type(new BytesType());
  type.register_type(attacker);
  auto* topic = attacker->create_topic("handgraft/v1/request", type.get_type_name(),
                                       dds::TOPIC_QOS_DEFAULT);
  auto* publisher = attacker->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.history().depth = 100;  // every payload is delivered, not just the last
  qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  qos.endpoint().history_memory_policy =
      eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.resource_limits().allocated_samples = 1;
  auto* writer = publisher->create_datawriter(topic, qos);
  ASSERT_NE(writer, nullptr);
  dds::PublicationMatchedStatus matched;
  for (int i = 0; i < 200 && matched.current_count == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    writer->get_publication_matched_status(matched);
  }
  ASSERT_GT(matched.current_count, 0);

  const std::string header("\0\1\0\0", 4);
  const std::string ids =
      std::string(16, 'c') + std::string(8, '\1') + std::string("\1\0\0\0", 4);
  std::vector<std::string> payloads = {
      "",
      "x",
      header,
      header + std::string(3, 'y'),
      std::string(64, '\xff'),
      header + ids + std::string("\xff\xff\xff\x7f", 4),  // an operation of no name
      header + ids + std::string("\1\0\0\0\0\0\0\0", 8) + std::string(8, '\0') +
          std::string("\xff\xff\xff\xff", 4),  // a string of 4 GiB
      header + std::string(1'500'000, '\0'),
      header + std::string(17u << 20, '\0'),  // beyond what is taken
      std::string("\0\3\0\0", 4) + ids};      // a parameter list
  for (std::size_t cut = 0; cut < 40; ++cut) {
    payloads.push_back(header + (ids + std::string(12, '\2')).substr(0, cut));
  }
  for (const std::string& payload : payloads) {
    Bytes bytes{payload};
    writer->write(&bytes);
  }
  ASSERT_LE(payloads.size(), 100u);
  writer->wait_for_acknowledgments({5, 0});
  EXPECT_EQ(client.ask(test::plain(v1::OP_LIST_MODELS))._d(), v1::OP_LIST_MODELS);

  attacker->delete_contained_entities();
  factory->delete_participant(attacker);
}

}  // namespace
}  // namespace handgraft::server
