// Topics and services as a ROS 2 node sees them: the type's name, and every byte.

#include <thread>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "hardware/bridge/ros_node.h"
#include "hardware/bridge/telemetry.h"
#include "idl/cyclone/participant.h"
#include "idl/topics.h"

#include "tests/hardware/protocols/hex.h"
#include "tests/support/test_domain.h"

// The topics' descriptors as idlc makes them.
extern "C" {
extern const dds_topic_descriptor_t sensor_msgs_msg_dds__JointState__desc;
extern const dds_topic_descriptor_t trajectory_msgs_msg_dds__JointTrajectory__desc;
extern const dds_topic_descriptor_t diagnostic_msgs_msg_dds__DiagnosticArray__desc;
extern const dds_topic_descriptor_t std_srvs_srv_dds__Trigger_Request__desc;
extern const dds_topic_descriptor_t std_srvs_srv_dds__Trigger_Response__desc;
}

namespace handgraft::bridge {
namespace {

using RosJointState = sensor_msgs::msg::dds_::JointState_;

/// Made by hand from the CDR rules: little-endian, aligned from behind the four bytes of the
/// encapsulation; strings and sequences counted, strings with their closing zero.
constexpr const char* kGolden =
    "00 01 00 00"              // CDR, little-endian
    "01 00 00 00 02 00 00 00"  // stamp: 1 s, 2 ns
    "01 00 00 00 00 00 00 00"  // frame_id "": one zero, three of padding
    "02 00 00 00"              // two names
    "02 00 00 00 61 00 00 00"  // "a", two of padding
    "03 00 00 00 62 63 00 00"  // "bc", one of padding
    "02 00 00 00"              // two positions, at 40: aligned by 8
    "00 00 00 00 00 00 F0 3F"  // 1.0
    "00 00 00 00 00 00 04 C0"  // -2.5
    "02 00 00 00 00 00 00 00"  // two velocities, four of padding
    "00 00 00 00 00 00 E0 3F"  // 0.5
    "00 00 00 00 00 00 00 00"  // 0.0
    "00 00 00 00";             // no efforts

/// A point of one joint.
constexpr const char* kGoldenTrajectory =
    "00 01 00 00"
    "00 00 00 00 00 00 00 00"  // a stamp of 0: from now on
    "01 00 00 00 00 00 00 00"  // frame_id ""
    "01 00 00 00"              // one name
    "02 00 00 00 61 00 00 00"  // "a", two of padding
    "01 00 00 00"              // one point, at 28
    "01 00 00 00 00 00 00 00"  // one position, four of padding
    "00 00 00 00 00 00 F0 3F"  // 1.0
    "01 00 00 00 00 00 00 00"  // one velocity
    "00 00 00 00 00 00 39 40"  // 25.0: 0.5 rad in 20 ms
    "00 00 00 00"              // no accelerations
    "00 00 00 00"              // no efforts
    "00 00 00 00 00 2D 31 01"  // from the start: 0 s, 20,000,000 ns
    "";

constexpr const char* kGoldenDiagnostics =
    "00 01 00 00"
    "01 00 00 00 02 00 00 00"  // stamp: 1 s, 2 ns
    "01 00 00 00 00 00 00 00"  // frame_id ""
    "01 00 00 00"              // one status
    "01 00 00 00"              // level: one byte, three of padding
    "02 00 00 00 6E 00 00 00"  // name "n", two of padding
    "02 00 00 00 6D 00 00 00"  // message "m"
    "01 00 00 00 00 00 00 00"  // hardware_id ""
    "01 00 00 00"              // one value
    "02 00 00 00 6B 00 00 00"  // key "k"
    "04 00 00 00 76 76 76 00"  // value "vvv"
    "";

/// What rmw_cyclonedds puts before a service's own: who asks, and which question.
constexpr const char* kGoldenRequest =
    "00 01 00 03"              // three bytes of padding at the end
    "67 12 00 00 00 00 00 00"  // 4711
    "2A 00 00 00 00 00 00 00"  // 42
    "00 00 00 00"              // a member, since there has to be one
    "";

constexpr const char* kGoldenResponse =
    "00 01 00 00"
    "67 12 00 00 00 00 00 00"  // 4711
    "2A 00 00 00 00 00 00 00"  // 42
    "01 00 00 00"              // success, three of padding
    "04 00 00 00 6F 66 66 00"  // "off"
    "";

class RosWire : public ::testing::Test {
 protected:
  RosWire()
      : raw(dds_create_participant(
            static_cast<dds_domainid_t>(domain.number()), nullptr, nullptr)) {}

  ~RosWire() override { dds_delete(raw); }

  /// What a reader of Cyclone's own, with idlc's type, gets of `message`; empty if it does not
  /// come.
  template <class Message>
  std::string bytesOf(const idl::Topic<Message>& told,
                      const dds_topic_descriptor_t& type,
                      const Message& message) {
    idl::cyclone::Writer<Message> writer(participant, told);
    const dds_entity_t topic = dds_create_topic(raw, &type, told.name, nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    const dds_entity_t reader = dds_create_reader(raw, topic, qos, nullptr);
    dds_delete_qos(qos);
    for (int i = 0; i < 600 && writer.readers() == 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (reader <= 0 || writer.readers() != 1) return "nobody reads";
    writer.write(message);
    ddsi_serdata* sample = nullptr;
    dds_sample_info_t info;
    for (int i = 0; i < 600 && sample == nullptr; ++i) {
      if (dds_takecdr(reader, &sample, 1, &info, DDS_ANY_STATE) > 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    if (sample == nullptr) return "nothing came";
    handgraft::test::ByteVector bytes(ddsi_serdata_size(sample));
    ddsi_serdata_to_ser(sample, 0, bytes.size(), bytes.data());
    ddsi_serdata_unref(sample);
    return handgraft::test::toHex(bytes);
  }

  static std::string golden(const char* text) {
    return handgraft::test::toHex(handgraft::test::fromHex(text));
  }

  handgraft::test::TestDomain domain;
  idl::cyclone::Participant participant{{domain.number(), "lo"}};
  dds_entity_t raw;  // after ours, whose settings of the domain it shares
};

TEST_F(RosWire, JointStatesAreTheBytesThatRosExpects) {
  MotionState state(2);
  state.position = {1.0, -2.5};
  state.velocity = {0.5, 0.0};
  EXPECT_EQ(
      bytesOf(idl::kRosJointStatesTopic, sensor_msgs_msg_dds__JointState__desc,
              rosJointState("", {"a", "bc"}, state, std::chrono::nanoseconds(1'000'000'002))),
      golden(kGolden));
}

TEST_F(RosWire, TrajectoriesAreTheBytesThatRosExpects) {
  EXPECT_EQ(bytesOf(idl::kRosTrajectoryTopic, trajectory_msgs_msg_dds__JointTrajectory__desc,
                    rosTrajectory({"a"}, {1.0}, {0.5}, 0.02)),
            golden(kGoldenTrajectory));
}

TEST_F(RosWire, DiagnosticsAreTheBytesThatRosExpects) {
  diagnostic_msgs::msg::dds_::KeyValue_ pair;
  pair.key("k");
  pair.value("vvv");
  diagnostic_msgs::msg::dds_::DiagnosticStatus_ status;
  status.level(1);
  status.name("n");
  status.message("m");
  status.values({pair});
  diagnostic_msgs::msg::dds_::DiagnosticArray_ message;
  message.header().stamp().sec(1);
  message.header().stamp().nanosec(2);
  message.status({status});
  EXPECT_EQ(bytesOf(idl::kRosDiagnosticsTopic, diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                    message),
            golden(kGoldenDiagnostics));
}

TEST_F(RosWire, ServicesAreTheBytesThatRosExpects) {
  std_srvs::srv::dds_::Trigger_Request_ request;
  request.client_guid(4711);
  request.sequence_number(42);
  request.structure_needs_at_least_one_member(0);
  EXPECT_EQ(
      bytesOf({"rq/handgraft_bridge/armRequest", idl::Qos::kService, idl::kRosTriggerHash},
              std_srvs_srv_dds__Trigger_Request__desc, request),
      golden(kGoldenRequest));
  std_srvs::srv::dds_::Trigger_Response_ response;
  response.client_guid(4711);
  response.sequence_number(42);
  response.success(true);
  response.message("off");
  EXPECT_EQ(bytesOf({"rr/handgraft_bridge/armReply", idl::Qos::kService, idl::kRosTriggerHash},
                    std_srvs_srv_dds__Trigger_Response__desc, response),
            golden(kGoldenResponse));
}

TEST_F(RosWire, ServicesHaveNoSuccessWhereNobodyKnowsWhetherMotorsAreOff) {
  const auto bell = std::make_shared<WakeEvent>();
  RosNode node(
      participant, "", 1, [](v1::HandCommandKind) {}, bell);
  const idl::cyclone::Participant other({domain.number(), "lo"});
  const auto nameOf = [](const char* kind, const char* ending) {
    return fmt::format("{}/handgraft_bridge/estop{}", kind, ending);
  };
  const std::string asked = nameOf("rq", "Request");
  const std::string told = nameOf("rr", "Reply");
  idl::cyclone::Writer<std_srvs::srv::dds_::Trigger_Request_> requests(
      other, {asked.c_str(), idl::Qos::kService, idl::kRosTriggerHash});
  idl::cyclone::Reader<std_srvs::srv::dds_::Trigger_Response_> replies(
      other, {told.c_str(), idl::Qos::kService, idl::kRosTriggerHash});
  const auto successOf = [&](v1::MotorPower power, std::int64_t number) {
    v1::BridgeStatus status;
    status.state(v1::BRIDGE_ESTOP);
    status.power(power);
    std_srvs::srv::dds_::Trigger_Request_ request;
    request.client_guid(4711);
    request.sequence_number(number);
    std::optional<bool> success;
    for (int i = 0; i < 600 && !success; ++i) {
      // A match is not readiness: a request may be lost.
      if (i % 30 == 0) requests.write(request);
      node.serve(status, std::chrono::steady_clock::now());
      replies.wait(std::chrono::milliseconds(100));
      replies.take([&](const std_srvs::srv::dds_::Trigger_Response_& reply) {
        if (reply.sequence_number() == number) success = reply.success();
      });
    }
    return success;
  };
  EXPECT_EQ(successOf(v1::POWER_OFF, 1), true);
  EXPECT_EQ(successOf(v1::POWER_UNKNOWN, 2), false);
}

TEST_F(RosWire, TheTypeIsNamedAsRosNamesIt) {
  const idl::cyclone::Writer<RosJointState> writer(participant, idl::kRosJointStatesTopic);
  const dds_entity_t reader =
      dds_create_reader(raw, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  ASSERT_GT(reader, 0) << dds_strretcode(reader);
  std::string type;
  for (int i = 0; i < 600 && type.empty(); ++i) {
    void* sample = nullptr;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) > 0) {
      const auto* endpoint = static_cast<const dds_builtintopic_endpoint_t*>(sample);
      if (info.valid_data && std::string(endpoint->topic_name) == "rt/joint_states")
        type = endpoint->type_name;
      dds_return_loan(reader, &sample, 1);
      sample = nullptr;
    }
    if (type.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(type, "sensor_msgs::msg::dds_::JointState_");
}

}  // namespace
}  // namespace handgraft::bridge
