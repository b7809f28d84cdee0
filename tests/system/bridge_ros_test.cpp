// The bridge as ROS 2 nodes see it: readers, writers and services of types that rosidl's IDL
// makes, on both vendors, as processes of their own.

#include <optional>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include "tests/support/environment_variable.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

const std::vector<std::string> three_joints{"a", "b", "c"};

/// As the bridge's README tells who runs ROS nodes beside it on loopback.
constexpr const char* kLoopback =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>119</"
    "MaxAutoParticipantIndex>"
    "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

/// Two hosts on one cable, as network namespaces: that needs the right to make them.
class TwoHosts {
 public:
  TwoHosts() {
    const std::string id = std::to_string(getpid());
    bridge_host_ = "handgraft-a-" + id;
    node_host_ = "handgraft-b-" + id;
    const std::string cable = "hga" + id, end = "hgb" + id;
    are_there_ = ip({"netns", "add", bridge_host_}) && ip({"netns", "add", node_host_}) &&
                 ip({"link", "add", cable, "type", "veth", "peer", "name", end}) &&
                 plug(bridge_host_, cable, "10.78.0.1/24") &&
                 plug(node_host_, end, "10.78.0.2/24");
  }

  ~TwoHosts() {
    if (before_ >= 0) {
      static_cast<void>(setns(before_, CLONE_NEWNET));
      ::close(before_);
    }
    ip({"netns", "del", bridge_host_});
    ip({"netns", "del", node_host_});
  }

  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;

  [[nodiscard]] bool areThere() const { return are_there_; }

  [[nodiscard]] const std::string& nodeHost() const { return node_host_; }

  /// What this thread opens and starts from now on is on the bridge's host.
  void sitAtTheBridges() {
    before_ = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    const int host = ::open(("/var/run/netns/" + bridge_host_).c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_in = host >= 0 && setns(host, CLONE_NEWNET) == 0;
    ::close(host);
    if (before_ < 0 || !is_in) throw std::runtime_error("cannot enter " + bridge_host_);
  }

 private:
  static bool ip(const std::vector<std::string>& arguments) {
    try {
      return run("/sbin/ip", arguments).exit_code == 0;
    } catch (const std::runtime_error&) {
      return false;
    }
  }

  static bool plug(const std::string& host, const std::string& end, const char* address) {
    return ip({"link", "set", end, "netns", host}) &&
           ip({"-n", host, "link", "set", end, "name", "eth0"}) &&
           ip({"-n", host, "addr", "add", address, "dev", "eth0"}) &&
           ip({"-n", host, "link", "set", "eth0", "up", "multicast", "on"}) &&
           ip({"-n", host, "link", "set", "lo", "up"}) &&
           ip({"-n", host, "route", "add", "224.0.0.0/4", "dev", "eth0"});
  }

  std::string bridge_host_, node_host_;
  bool are_there_ = false;
  int before_ = -1;
};

/// Armed, with a stream to follow.
struct RosBench {
  RosBench(const Network& network, const std::vector<std::string>& more)
      : bench(network, directConfig("dynamixel", "three", three_joints, 2.5)),
        server(network, "three", three_joints) {
    bench.startBridge(more);
    server.stream({0.5, 0.0, -0.5});
    is_armed = bench.arm();
  }

  BridgeBench bench;
  StandInServer server;
  bool is_armed = false;
};

class RosPeer : public testing::TestWithParam<const char*> {
 protected:
  /// Peers of both vendors stay on loopback until it is told otherwise.
  void asItComes() { on_loopback_.reset(); }

  [[nodiscard]] std::vector<std::string> arguments(
      const std::string& prefix, const std::vector<std::string>& verbs) const {
    std::vector<std::string> all{std::to_string(domain.number()), prefix};
    all.insert(all.end(), verbs.begin(), verbs.end());
    return all;
  }

  static void expectAll(const Finished& node, const std::vector<std::string>& lines) {
    EXPECT_EQ(node.exit_code, 0) << node.out;
    for (const std::string& line : lines)
      EXPECT_NE(node.out.find(line), std::string::npos) << line << "\nin\n" << node.out;
  }

  TestDomain domain;

 private:
  struct OnLoopback {
    EnvironmentVariable cyclone{"CYCLONEDDS_URI", kLoopback};
    EnvironmentVariable fast{"FAST_PEER_ON_LOOPBACK", "1"};
  };

  std::optional<OnLoopback> on_loopback_{std::in_place};
};

TEST_P(RosPeer, HearsEveryTopicAndCallsEveryService) {
  RosBench on({domain.number(), "lo"}, {});
  ASSERT_TRUE(on.is_armed) << on.bench.told();
  const Finished node =
      run(program(GetParam()), arguments("", {"disarm", "arm", "estop", "reset", "home"}));
  expectAll(node, {"joint_states 3 names, first a, 3 positions, 3 efforts, frame three",
                   "joint_states announces its type hash",
                   "joint_trajectory 3 names, 1 points, 3 positions, in 50000000 ns",
                   "diagnostics level 0 of handgraft_bridge: hand: dynamixel /",
                   "disarm success 1: motors off", "arm success 1: armed",
                   "estop success 1: emergency stop", "reset success 1: motors off",
                   "home success 0: HOME refused: this hand needs no homing"});
  EXPECT_FALSE(on.bench.rig().isPowered());
}

TEST_P(RosPeer, FindsThemUnderTheirNamespace) {
  RosBench on({domain.number(), "lo"}, {"--ros-namespace", "/left/hand"});
  ASSERT_TRUE(on.is_armed) << on.bench.told();
  const Finished node = run(program(GetParam()), arguments("left/hand/", {"home"}));
  expectAll(node, {"joint_states 3 names", "of left/hand/handgraft_bridge: hand",
                   "home success 0: HOME refused: this hand needs no homing"});
}

// By multicast, with no setting on the node's side.
TEST_P(RosPeer, OnAnotherHostFindsThemAsItComes) {
  TwoHosts hosts;
  if (!hosts.areThere()) GTEST_SKIP() << "network namespaces cannot be made here";
  asItComes();
  hosts.sitAtTheBridges();
  RosBench on({domain.number(), "eth0"}, {"--interface", "eth0", "--open"});
  ASSERT_TRUE(on.is_armed) << on.bench.told();
  std::vector<std::string> command{"netns", "exec", hosts.nodeHost(), program(GetParam())};
  for (const std::string& argument : arguments("", {"disarm"}))
    command.push_back(argument);
  expectAll(run("/sbin/ip", command),
            {"joint_states 3 names", "joint_states announces its type hash",
             "joint_trajectory 3 names", "diagnostics level 0", "disarm success 1"});
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
