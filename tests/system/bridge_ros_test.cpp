// The bridge as ROS 2 nodes see it: readers, writers and services of types that rosidl's IDL
// makes, on both vendors, as processes of their own.

#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

const std::vector<std::string> kJoints{"a", "b", "c"};

/// As the bridge's README tells who runs ROS nodes beside it on loopback.
constexpr const char* kLoopback =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>100</"
    "MaxAutoParticipantIndex>"
    "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

class RosPeer : public testing::TestWithParam<const char*> {
 protected:
  RosPeer() { setenv("CYCLONEDDS_URI", kLoopback, 1); }

  ~RosPeer() override { unsetenv("CYCLONEDDS_URI"); }

  void startArmed(const std::vector<std::string>& more) {
    bench_.startBridge(more);
    server_.stream({0.5, 0.0, -0.5});
    ASSERT_TRUE(bench_.arm()) << bench_.told();
  }

  [[nodiscard]] std::unique_ptr<Process> peer(const std::string& prefix,
                                              const std::string& verb) {
    return std::make_unique<Process>(
        program(GetParam()),
        std::vector<std::string>{std::to_string(domain_.number()), prefix, verb});
  }

  static void expectAll(Process& peer, const std::vector<std::string>& lines) {
    EXPECT_EQ(peer.wait(), 0) << peer.out();
    for (const std::string& line : lines)
      EXPECT_NE(peer.out().find(line), std::string::npos) << line << "\nin\n" << peer.out();
  }

  TestDomain domain_;
  Network network_{domain_.number(), "lo"};
  BridgeBench bench_{network_, directConfig("dynamixel", "three", kJoints, 2.5)};
  StandInServer server_{network_, "three", kJoints};
};

TEST_P(RosPeer, HearsJointStatesTrajectoryAndDiagnosticsAndCallsAService) {
  startArmed({});
  const auto node = peer("", "estop");
  expectAll(*node, {"joint_states 3 names, first a, 3 positions, 3 efforts, frame three",
                    "joint_trajectory 3 names, 1 points, 3 positions, in 50000000 ns",
                    "diagnostics level 0 of handgraft_bridge: hand: dynamixel /",
                    "estop success 1: emergency stop"});
  EXPECT_FALSE(bench_.rig().isPowered());
}

TEST_P(RosPeer, FindsThemUnderTheirNamespace) {
  startArmed({"--ros-namespace", "/left/hand"});
  const auto node = peer("left/hand/", "home");
  expectAll(*node, {"joint_states 3 names", "of left/hand/handgraft_bridge: hand",
                    "home success 0: HOME refused: this hand needs no homing"});
}

INSTANTIATE_TEST_SUITE_P(Vendors,
                         RosPeer,
                         testing::Values("cyclone_peer", "fast_peer"),
                         [](const auto& told) {
                           return std::string(told.param);
                         });

TEST(RosNamespace, OfWhichThereIsNoneIsRefused) {
  for (const char* name : {"/left//hand", "2nd", "left-hand", "a__b"}) {
    const Finished finished = run(program("handgraft-bridge"), {"--ros-namespace", name});
    EXPECT_EQ(finished.exit_code, 2) << name;
    EXPECT_NE(finished.err.find("ROS namespace"), std::string::npos) << finished.err;
  }
}

}  // namespace
}  // namespace handgraft::test
