// `handgraft bridge` against a bridge as a process, with an emulated hand at its end.

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "idl/cyclone/participant.h"
#include "idl/hardware.h"
#include "idl/topics.h"

#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

const std::vector<std::string> three_joints{"a", "b", "c"};

class BridgeCommand : public testing::Test {
 protected:
  [[nodiscard]] Finished ask(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "bridge");
    arguments.insert(arguments.end(), {"--domain", std::to_string(domain.number())});
    return run(program("handgraft"), arguments);
  }

  [[nodiscard]] nlohmann::json status(int bridge = 1) const {
    const Finished finished = ask({"status", "--json", "--bridge", std::to_string(bridge)});
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return nlohmann::json::parse(finished.out).at("bridges").at(0);
  }

  void start() {
    bench.startBridge();
    server->stream({0.0, 0.0, 0.0});
    ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
      return told.state() == v1::BRIDGE_IDLE && told.poses_accepted() > 0;
    })) << bench.told();
  }

  TestDomain domain;
  Network network{domain.number(), "lo"};
  BridgeBench bench{network, directConfig("dynamixel", "three", three_joints, 2.5)};
  std::unique_ptr<StandInServer> server =
      std::make_unique<StandInServer>(network, "three", three_joints);
};

TEST_F(BridgeCommand, ArmsDisarmsStopsAndResets) {
  start();
  EXPECT_EQ(status().at("state"), "idle");
  const Finished armed = ask({"arm"});
  ASSERT_EQ(armed.exit_code, 0) << armed.err << bench.told();
  EXPECT_TRUE(bench.rig().isPowered());
  EXPECT_EQ(ask({"disarm"}).exit_code, 0);
  EXPECT_FALSE(bench.rig().isPowered());
  ASSERT_EQ(ask({"arm", "--bridge", "1"}).exit_code, 0) << bench.told();
  EXPECT_EQ(ask({"estop"}).exit_code, 0);
  EXPECT_FALSE(bench.rig().isPowered());
  EXPECT_EQ(status().at("state"), "estop");
  const Finished refused = ask({"arm"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("refused"), std::string::npos) << refused.err;
  EXPECT_EQ(ask({"reset"}).exit_code, 0);
  EXPECT_EQ(status().at("state"), "idle");
  const Finished home = ask({"home"});
  EXPECT_EQ(home.exit_code, 1);
  EXPECT_NE(home.err.find("bridge 1: HOME refused: this hand needs no homing"),
            std::string::npos)
      << home.err;
  EXPECT_NE(status().at("last_refusal"), "");
  EXPECT_EQ(ask({"arm"}).exit_code, 0) << bench.told();
  EXPECT_EQ(status().at("last_refusal"), "") << "what was refused before is no news";
}

TEST_F(BridgeCommand, SaysThatNobodyKnowsWhetherALostDeviceIsOff) {
  start();
  ASSERT_EQ(ask({"arm"}).exit_code, 0) << bench.told();
  bench.rig().wire().unplug();
  ASSERT_TRUE(bench.status(v1::BRIDGE_FAULT)) << bench.told();
  for (const char* action : {"disarm", "estop"}) {
    const Finished asked = ask({action});
    EXPECT_EQ(asked.exit_code, 1) << action;
    EXPECT_NE(asked.err.find("whether the motors are off is not known"), std::string::npos)
        << action << ": " << asked.err;
  }
  EXPECT_EQ(status().at("state"), "estop");
}

TEST_F(BridgeCommand, RecordsARunThatCanBeDrawn) {
  start();
  ASSERT_EQ(ask({"arm"}).exit_code, 0) << bench.told();
  server->stream({0.5, -0.5, 0.25});
  const auto folder = scratchDirectory();
  const std::string csv = (folder / "run.csv").string();
  const std::string png = (folder / "run.png").string();
  const Finished recorded = ask({"record", "--out", csv, "--seconds", "2"});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  std::ifstream file(csv);
  std::string heading, row;
  std::getline(file, heading);
  EXPECT_EQ(heading.rfind("time_s,state,a measured_rad,a command_rad,a target_rad", 0), 0)
      << heading;
  int rows = 0;
  while (std::getline(file, row))
    ++rows;
  EXPECT_GT(rows, 5) << "of 2 s at 20 Hz";
  ASSERT_EQ(ask({"plot", csv, "--out", png}).exit_code, 0);
  std::ifstream picture(png, std::ios::binary);
  std::string signature(4, '\0');
  picture.read(signature.data(), 4);
  EXPECT_EQ(signature, "\x89PNG");

  std::filesystem::resize_file(csv, std::filesystem::file_size(csv) - 3);
  const Finished cut = ask({"plot", csv, "--out", png});
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_NE(cut.err.find(fmt::format("line {} is cut off", rows + 1)), std::string::npos)
      << cut.err;
}

TEST_F(BridgeCommand, SaysWhichJointKeepsAHandFromBeingArmed) {
  server.reset();
  server = std::make_unique<StandInServer>(network, "three",
                                           std::vector<std::string>{"a", "b", "tumb"});
  bench.startBridge();
  server->stream({0.0, 0.0, 0.0});
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
    return told.state() == v1::BRIDGE_IDLE && told.poses_refused() > 0;
  })) << bench.told();
  const std::string why = "wrong joint names: 'c' is missing, 'tumb' is none of its joints";
  EXPECT_EQ(status().at("last_refusal"), "pose refused: " + why);
  const Finished refused = ask({"arm"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("ARM refused: no fresh pose: " + why), std::string::npos)
      << refused.err;
  for (int i = 0; i < 3; ++i) {
    const Finished again = ask({"arm"});
    EXPECT_EQ(again.exit_code, 1);
    EXPECT_NE(again.err.find("ARM refused: no fresh pose: " + why), std::string::npos)
        << "refused for the same reason as before is an answer, too: " << again.err;
  }
}

/// Says that it is there for a while, and obeys no command, or does not even hear it.
class MuteBridge {
 public:
  MuteBridge(const Network& network, std::chrono::seconds speaks, bool listens)
      : participant_(network), statuses_(participant_, idl::kBridgeStatusTopic) {
    if (listens) commands_.emplace(participant_, idl::kHandCommandTopic);
    speaker_ = std::thread([this, end = std::chrono::steady_clock::now() + speaks] {
      v1::BridgeStatus status;
      status.bridge_id(5);
      status.state(v1::BRIDGE_IDLE);
      for (std::int64_t i = 0; !is_over_ && std::chrono::steady_clock::now() < end; ++i) {
        status.stamp_ns(i);
        statuses_.write(status);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    });
  }

  ~MuteBridge() {
    is_over_ = true;
    speaker_.join();
  }

  MuteBridge(const MuteBridge&) = delete;
  MuteBridge& operator=(const MuteBridge&) = delete;

 private:
  idl::cyclone::Participant participant_;
  idl::cyclone::Writer<v1::BridgeStatus> statuses_;
  std::optional<idl::cyclone::Reader<v1::HandCommand>> commands_;
  std::atomic<bool> is_over_ = false;
  std::thread speaker_;
};

TEST_F(BridgeCommand, NamesABridgeThatDoesNotAnswerAndSaysWhy) {
  struct Case {
    std::chrono::seconds speaks;
    bool listens;
    const char* why;
  };

  for (const Case& one :
       {Case{std::chrono::seconds(60), false, "does not listen to commands"},
        Case{std::chrono::seconds(1), true, "has fallen silent"},
        Case{std::chrono::seconds(60), true, "has not answered within 10 s"}}) {
    const MuteBridge bridge(network, one.speaks, one.listens);
    const Finished arm = ask({"arm"});
    EXPECT_NE(arm.exit_code, 0);
    EXPECT_NE(arm.err.find("bridge 5"), std::string::npos) << arm.err;
    EXPECT_NE(arm.err.find(one.why), std::string::npos) << arm.err;
  }
}

TEST_F(BridgeCommand, AnEmergencyStopIsForEveryBridgeThereIs) {
  start();
  std::string text = directConfig("ability_hand", "three", three_joints, 2.5);  // names no ids
  const std::size_t device = text.find("device: ");
  text.replace(device, text.find('\n', device) - device,
               "device: {kind: simulated, watchdog_ms: 2500}");
  const std::string path = (scratchDirectory() / "simulated.yaml").string();
  std::ofstream(path) << text;
  const auto simulated = [&](const char* id) {
    return std::vector<std::string>{"--config", path,       "--bridge-id",
                                    id,         "--domain", std::to_string(domain.number())};
  };
  Process one(program("handgraft-bridge"), simulated("0"));
  Process other(program("handgraft-bridge"), simulated("7"));
  ASSERT_TRUE(one.waitForText("following session")) << one.err();
  ASSERT_TRUE(other.waitForText("following session")) << other.err();
  for (const char* id : {"0", "1", "7"})
    ASSERT_EQ(ask({"arm", "--bridge", id}).exit_code, 0) << id << bench.told() << other.err();
  const Finished stopped = ask({"estop"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.err;
  EXPECT_FALSE(bench.rig().isPowered());
  for (const int id : {0, 1, 7})
    EXPECT_EQ(status(id).at("state"), "estop") << id;
}

TEST(DeviceEmulator, SaysHowItIsUsed) {
  const Finished help = run(program("handgraft-device-emulator"), {"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("usage: handgraft-device-emulator CONFIG"), std::string::npos);
  const Finished unknown = run(program("handgraft-device-emulator"), {"--port"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("usage"), std::string::npos) << unknown.err;
}

TEST_F(BridgeCommand, SaysWhatIsWrong) {
  const Finished none = ask({"status"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("no handgraft-bridge answers"), std::string::npos) << none.err;
  start();
  const Finished other = ask({"arm", "--bridge", "9"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("--bridge 9"), std::string::npos) << other.err;
  const auto path = scratchDirectory() / "no_run.csv";
  std::ofstream(path) << "time_s,state,a measured_rad\n0,idle\n";
  const Finished wrong = ask({"plot", path.string(), "--out", path.string() + ".png"});
  EXPECT_EQ(wrong.exit_code, 2) << wrong.err;
  EXPECT_FALSE(bench.rig().isPowered());
}

}  // namespace
}  // namespace handgraft::test
