// Joint commands of more sessions than are announced: Fast DDS writes, Cyclone DDS reads.
#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "idl/cyclone/participant.h"
#include "idl/topics.h"
#include "server/transport/bus.h"

#include "tests/support/test_domain.h"

namespace handgraft::server {
namespace {

using Command = sensor_msgs::msg::dds_::JointState_;

TEST(JointCommands, OfAnySessionReachWhoReadsThem) {
  constexpr std::uint64_t kSessions = 60;
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  const auto bus = openFastBus(network);
  Command command;
  for (std::uint64_t session = 1; session <= kSessions; ++session)
    bus->publishJointCommand(session, command);
  const idl::cyclone::Participant participant(network);
  for (const std::uint64_t session : {std::uint64_t{1}, kSessions}) {
    const std::string topic = "rt/handgraft/" + std::to_string(session) + "/joint_command";
    idl::cyclone::Reader<Command> reader(participant, {topic.c_str(), idl::Qos::kTelemetry});
    command.position({static_cast<double>(session)});
    bool is_heard = false;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!is_heard && std::chrono::steady_clock::now() < end) {
      bus->lookAround();  // as a server does once a second
      bus->publishJointCommand(session, command);
      reader.wait(std::chrono::milliseconds(50));
      reader.take([&](const Command& one) {
        is_heard = one.position() == command.position();
      });
    }
    EXPECT_TRUE(is_heard) << topic;
  }
}

}  // namespace
}  // namespace handgraft::server
