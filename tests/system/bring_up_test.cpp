// A newcomer's hand, from `scan` to a followed grasp, by the commands that the README of
// hardware/bringup tells: six servos whose directions and zeros nobody knows.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hardware/config/hand_config_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/terminal.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

constexpr std::size_t kServos = 6;
constexpr double kLower = -0.4, kUpper = 1.5;
constexpr double kRadPerCount = protocols::dynamixel::kRadPerCount;

std::string jointName(std::size_t i) {
  return fmt::format("finger_{}_joint", i);
}

std::string urdf() {
  std::string text = "<robot name=\"newcomer\"><link name=\"palm\"/>";
  for (std::size_t i = 0; i < kServos; ++i) {
    text += fmt::format(
        "<link name=\"l{0}\"/><joint name=\"{1}\" type=\"revolute\"><parent link=\"palm\"/>"
        "<child link=\"l{0}\"/><axis xyz=\"0 0 1\"/><limit lower=\"{2}\" upper=\"{3}\" "
        "effort=\"1\" velocity=\"5\"/></joint>",
        i, jointName(i), kLower, kUpper);
  }
  return text + "</robot>\n";
}

/// What only the hand itself knows.
struct Secret {
  int direction;
  double zero_counts;
};

/// Somebody's keyboard, as a pipe with a name.
class Keyboard {
 public:
  explicit Keyboard(const std::filesystem::path& path) : path_(path) {
    std::filesystem::remove(path);
    if (mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no fifo");
    file_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  }

  ~Keyboard() { ::close(file_); }

  void type(const std::string& line) const {
    const std::string text = line + "\n";
    ASSERT_EQ(::write(file_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }

  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
  int file_;
};

class NewcomersHand : public testing::Test {
 protected:
  NewcomersHand() {
    std::mt19937 random(20260101);
    for (std::size_t i = 0; i < kServos; ++i) {
      secrets.push_back(
          {random() % 2 == 0 ? 1 : -1, 1200.0 + static_cast<double>(random() % 1600)});
      auto& servo = emulator.motor(id(i)).servo;
      servo.position = servo.goal = secrets[i].zero_counts;
      servo.speed = 4096;
    }
    wire = makePty(emulator, 57600);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "newcomer.urdf") << urdf();
    std::filesystem::remove(folder / "newcomer_calibration.yaml");
  }

  static std::uint8_t id(std::size_t i) { return static_cast<std::uint8_t>(11 + 3 * i); }

  /// Puts joint `i` by hand to an angle of its model; its motor is off.
  void put(std::size_t i, double joint_rad) {
    const auto lock = wire->hold();
    auto& servo = emulator.motor(id(i)).servo;
    servo.position = secrets[i].zero_counts + secrets[i].direction * joint_rad / kRadPerCount;
  }

  double jointAngle(std::size_t i) {
    const auto lock = wire->hold();
    const double counts = emulator.motor(id(i)).servo.position - secrets[i].zero_counts;
    return secrets[i].direction * counts * kRadPerCount;
  }

  [[nodiscard]] std::string port() const { return portOf(*wire); }

  std::vector<Secret> secrets;
  DynamixelEmulator emulator{{11, 14, 17, 20, 23, 26}};
  std::unique_ptr<Wire> wire;
  std::filesystem::path folder = scratchDirectory() / "newcomer";
};

TEST_F(NewcomersHand, ComesFromScanToAFollowedGrasp) {
  // 1. What is there?
  const Finished scanned = run(program("handgraft"), {"bridge", "scan", port()});
  ASSERT_EQ(scanned.exit_code, 0) << scanned.err << scanned.out;
  for (std::size_t i = 0; i < kServos; ++i) {
    const std::string line = fmt::format("dynamixel at 57600 baud: id {}: XC330-M288-T", id(i));
    EXPECT_NE(scanned.out.find(line), std::string::npos) << scanned.out;
  }
  ASSERT_NE(scanned.out.find("--ids 11,14,17,20,23,26"), std::string::npos) << scanned.out;

  // 2. A config to fill in; on a busy machine a patient one.
  const std::string config = (folder / "newcomer.yaml").string();
  const Finished made =
      run(program("handgraft"),
          {"bridge", "config", "make", (folder / "newcomer.urdf").string(), "--kind",
           "dynamixel", "--port", port(), "--ids", "11,14,17,20,23,26", "--out", config});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  {
    std::ifstream file(config);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    replace(text, "watchdog_ms: 400", "watchdog_ms: 2000\n  tolerated_misses: 50");
    replace(text, "longest_gap_ms: 350", "longest_gap_ms: 1000, overruns_in_a_row: 1000");
    replace(text, "stale_ms: 500", "stale_ms: 3000");
    replace(text, "silent_ms: 400", "silent_ms: 1000");
    std::ofstream(config) << text;
  }

  // 3. One motor, slowly, while it is held for.
  const Keyboard keyboard(folder / "keys");
  keyboard.type("hold");
  const Finished jogged =
      run("/bin/sh", {"-c", fmt::format("'{}' bridge jog {} 0.2 --config '{}' < '{}'",
                                        program("handgraft").string(), jointName(0), config,
                                        keyboard.path())});
  ASSERT_EQ(jogged.exit_code, 0) << jogged.err << jogged.out;
  EXPECT_NEAR(jointAngle(0), 0.2 * secrets[0].direction, 5e-3) << jogged.out;
  keyboard.type("let go");
  const Finished let_go =
      run("/bin/sh", {"-c", fmt::format("'{}' bridge jog {} 0.2 --config '{}' < '{}'",
                                        program("handgraft").string(), jointName(1), config,
                                        keyboard.path())});
  EXPECT_EQ(let_go.exit_code, 1) << let_go.out;
  EXPECT_NEAR(jointAngle(1), 0, 5e-3) << "nobody held";
  {
    // At a terminal the space bar alone holds, and not what was typed ahead of the question.
    Terminal person(program("handgraft"),
                    {"bridge", "jog", jointName(1), "0.2", "--config", config});
    person.type("   ");
    ASSERT_TRUE(person.waitFor("hold the space bar")) << person.text();
    for (int i = 0; i < 10; ++i) {
      person.type("xy\r");
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_NEAR(jointAngle(1), 0, 5e-3) << "no other key turns it";
    for (int i = 0; i < 400 && std::abs(jointAngle(1)) < 0.19; ++i) {
      person.type(" ");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    EXPECT_EQ(person.wait(), 0) << person.text();
    EXPECT_NEAR(jointAngle(1), 0.2 * secrets[1].direction, 5e-3) << person.text();
    put(1, 0.0);
  }

  // 4. The walk: each joint to its zero, a turn, its ends; then the watchdog and the stop.
  const std::string report = (folder / "report.txt").string();
  Process check(
      "/bin/sh",
      {"-c", fmt::format("exec '{}' bridge check --config '{}' --report '{}' "
                         "< '{}'",
                         program("handgraft").string(), config, report, keyboard.path())});
  for (std::size_t i = 0; i < kServos; ++i) {
    const std::string name = fmt::format("'{}'", jointName(i));
    ASSERT_TRUE(check.waitForText("Put " + name + " by hand to its zero"))
        << check.out() << check.err();
    put(i, 0);
    keyboard.type("");
    ASSERT_TRUE(check.waitForText(name + ": hold the space bar")) << check.out() << check.err();
    keyboard.type("hold");
    ASSERT_TRUE(check.waitForText(fmt::format("Did {}, and no other", name))) << check.out();
    const bool is_right = jointAngle(i) > 0;
    EXPECT_EQ(is_right, secrets[i].direction > 0);
    keyboard.type(is_right ? "y" : "n");
    if (!is_right) keyboard.type("y");
    ASSERT_TRUE(check.waitForText("Put " + name + " by hand to its lower end")) << check.out();
    put(i, kLower - 0.02);
    keyboard.type("");
    ASSERT_TRUE(check.waitForText("Put " + name + " by hand to its upper end")) << check.out();
    put(i, kUpper + 0.02);
    keyboard.type("");
    ASSERT_TRUE(check.waitForText(name + ": fine")) << check.out() << check.err();
    put(i, 0.1);
  }
  keyboard.type("");
  ASSERT_TRUE(check.waitForText("the watchdog stopped them")) << check.out() << check.err();
  keyboard.type("");
  ASSERT_TRUE(check.waitForText("Are the motors limp now?")) << check.out() << check.err();
  keyboard.type("y");
  EXPECT_EQ(check.wait(), 0) << check.out() << check.err();
  ASSERT_TRUE(std::filesystem::exists(report));

  // 5. A grasp, followed.
  const config::HandConfig found = config::readHandConfig(config);
  ASSERT_TRUE(found.is_calibrated);
  for (std::size_t i = 0; i < kServos; ++i) {
    EXPECT_EQ(found.motors[i].direction, secrets[i].direction);
    EXPECT_NEAR(found.motors[i].zero_rad, secrets[i].zero_counts * kRadPerCount, 2e-3);
  }
  const TestDomain domain;
  const Network network{domain.number(), "lo"};
  StandInServer server(network, found.hand, found.governor.names);
  Process bridge(program("handgraft-bridge"),
                 {"--config", config, "--domain", std::to_string(domain.number())});
  const std::vector<double> grasp{0.2, 1.2, -0.3, 0.9, 0.4, 1.4};
  server.stream(grasp);
  ASSERT_TRUE(bridge.waitForText("following session")) << bridge.err();
  Finished armed;
  for (int attempt = 0; attempt < 5; ++attempt) {
    armed = run(program("handgraft"),
                {"bridge", "arm", "--domain", std::to_string(domain.number())});
    if (armed.exit_code == 0) break;
  }
  ASSERT_EQ(armed.exit_code, 0) << armed.err << bridge.err();
  EXPECT_TRUE(bridge.waitForText("pose 1 reached")) << bridge.err();
  for (std::size_t i = 0; i < kServos; ++i)
    EXPECT_NEAR(jointAngle(i), grasp[i], 5e-3) << jointName(i);
}

}  // namespace
}  // namespace handgraft::test
