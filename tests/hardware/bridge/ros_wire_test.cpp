// rt/joint_states as a ROS 2 node sees it: the type's name, and every byte.

#include <thread>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <gtest/gtest.h>

#include "hardware/bridge/telemetry.h"
#include "idl/cyclone/participant.h"
#include "idl/topics.h"

#include "tests/hardware/protocols/hex.h"
#include "tests/support/test_domain.h"

// The topic's descriptor as idlc makes it.
extern "C" const dds_topic_descriptor_t sensor_msgs_msg_dds__JointState__desc;

namespace handgraft::bridge {
namespace {

using RosJointState = sensor_msgs::msg::dds_::JointState_;

/// Made by hand from the CDR rules: little-endian, aligned from behind the four bytes of the
/// encapsulation; strings and sequences counted, strings with their closing zero.
const char* const kGolden =
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

class RosWire : public ::testing::Test {
 protected:
  RosWire()
      : raw_(dds_create_participant(
            static_cast<dds_domainid_t>(domain_.number()), nullptr, nullptr)) {}

  ~RosWire() override { dds_delete(raw_); }

  handgraft::test::TestDomain domain_;
  idl::cyclone::Participant participant_{{domain_.number(), "lo"}};
  idl::cyclone::Writer<RosJointState> writer_{participant_, idl::kRosJointStatesTopic};
  dds_entity_t raw_;  // after ours, whose settings of the domain it shares
};

TEST_F(RosWire, JointStatesAreTheBytesThatRosExpects) {
  const dds_entity_t topic = dds_create_topic(raw_, &sensor_msgs_msg_dds__JointState__desc,
                                              "rt/joint_states", nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const dds_entity_t reader = dds_create_reader(raw_, topic, qos, nullptr);
  dds_delete_qos(qos);
  ASSERT_GT(reader, 0) << dds_strretcode(reader);
  for (int i = 0; i < 600 && writer_.readers() == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_EQ(writer_.readers(), 1);

  MotionState state(2);
  state.position = {1.0, -2.5};
  state.velocity = {0.5, 0.0};
  writer_.write(rosJointState("", {"a", "bc"}, state, std::chrono::nanoseconds(1'000'000'002)));

  ddsi_serdata* sample = nullptr;
  dds_sample_info_t info;
  for (int i = 0; i < 600 && sample == nullptr; ++i) {
    if (dds_takecdr(reader, &sample, 1, &info, DDS_ANY_STATE) > 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_NE(sample, nullptr);
  handgraft::test::ByteVector bytes(ddsi_serdata_size(sample));
  ddsi_serdata_to_ser(sample, 0, bytes.size(), bytes.data());
  ddsi_serdata_unref(sample);
  EXPECT_EQ(handgraft::test::toHex(bytes),
            handgraft::test::toHex(handgraft::test::fromHex(kGolden)));
}

TEST_F(RosWire, TheTypeIsNamedAsRosNamesIt) {
  const dds_entity_t reader =
      dds_create_reader(raw_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
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
