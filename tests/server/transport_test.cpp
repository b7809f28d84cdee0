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
  EXPECT_EQ(hand.model().hand().urdf(), test::clamp_urdf);
  EXPECT_FALSE(hand.model().hand().skin_S().triangles().empty());
  const auto object = client.ask(test::describeModel(v1::MODEL_OBJECT, "fruit", true));
  EXPECT_FALSE(object.model().object().mesh_O().vertices_m().empty());
  const auto marks = client.ask(test::describeModel(v1::MODEL_CONTACTS, "marks", false));
  EXPECT_EQ(marks.model().contacts().patches().size(), 6u);
  EXPECT_EQ(marks.model().contacts().demonstrator(), v1::CHIRALITY_RIGHT);

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
