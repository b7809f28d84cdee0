// Scan, config, jog and check of a hand of each kind that the bridge speaks, emulated: what the
// config says that was made of its URDF is enough to bring it up.

#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/bringup/check.h"
#include "hardware/bringup/jog.h"
#include "hardware/bringup/make_config.h"
#include "hardware/bringup/scan.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/bringup/accepted_config.h"
#include "tests/hardware/emulators/hand_rig.h"
#include "tests/support/shared_data.h"

namespace handgraft::bringup {
namespace {

using config::DeviceKind;
using config::DeviceTraits;
using test::HandRig;

constexpr double kLower = -0.4, kUpper = 1.2;

std::string namedOf(const testing::TestParamInfo<DeviceTraits>& told) {
  std::string name;
  for (const char c : std::string(told.param.name))
    if (c != '_') name += c;
  return name;
}

class BringUpOf : public testing::TestWithParam<DeviceTraits> {
 protected:
  BringUpOf() {
    std::string text = "<robot name=\"told\"><link name=\"palm\"/>";
    for (int i = 0; i < count(); ++i) {
      // An Ability Hand's thumb rotator flexes the other way.
      const bool is_rotator = GetParam().kind == DeviceKind::kAbilityHand && i == 5;
      const bool is_own = GetParam().has_zeros;
      text += fmt::format(
          "<link name=\"l{0}\"/><joint name=\"j{0}\" type=\"revolute\"><parent link=\"palm\"/>"
          "<child link=\"l{0}\"/><limit lower=\"{1}\" upper=\"{2}\" effort=\"1\" "
          "velocity=\"5\"/></joint>",
          i,
          is_rotator ? -1.7
          : is_own   ? 0
                     : kLower,
          is_rotator ? 0
          : is_own   ? 1.6
                     : kUpper);
    }
    urdf = test::scratchDirectory() / fmt::format("every_{}.urdf", GetParam().name);
    std::ofstream(urdf) << text + "</robot>\n";
  }

  static int count() { return GetParam().own_motors > 0 ? GetParam().own_motors : 4; }

  config::HandConfig made() const {
    ConfigPlan plan;
    plan.kind = GetParam().name;
    return config::parseHandConfig(test::acceptedConfig(makeConfig(urdf, plan)));
  }

  std::filesystem::path urdf;
};

/// A hand whose config was made, in a time of its own.
class Bench {
 public:
  explicit Bench(config::HandConfig of)
      : config(std::move(of)), rig_(test::makeHandRig(config)), clock_(rig_->wire().clock()) {
    rig_->wire().pass(std::chrono::milliseconds(300));  // it has been on for a while
  }

  HandRig& rig() { return *rig_; }

  [[nodiscard]] bridge::MakeDevice maker() {
    return [this](const config::HandConfig& asked) {
      return bridge::makeDeviceOn(rig_->wire().channel(), asked, clock_);
    };
  }

  [[nodiscard]] const devices::Clock& clock() const { return clock_; }

  [[nodiscard]] std::function<void(devices::TimePoint)> sleeper() {
    return [this](devices::TimePoint time) {
      if (time > clock_()) rig_->wire().pass(time - clock_());
    };
  }

  Jogger jogger(const std::string& motor) {
    return {config, motor, maker(), clock_, sleeper()};
  }

  std::vector<double> angles() {
    std::vector<double> all;
    for (std::size_t i = 0; i < config.motors.size(); ++i)
      all.push_back(rig_->angle(i));
    return all;
  }

  config::HandConfig config;

 private:
  std::unique_ptr<HandRig> rig_;
  devices::Clock clock_;
};

/// Stands for the port that a device has to itself: it goes with its stack.
class CountedPort : public devices::ByteChannel {
 public:
  explicit CountedPort(int& count) : count_(count) { ++count_; }

  ~CountedPort() override { --count_; }

  void open() override {}

  void close() override {}

  void send(protocols::Bytes /*bytes*/) override {}

  std::size_t receive(std::span<std::uint8_t> /*into*/,
                      devices::TimePoint /*deadline*/) override {
    return 0;
  }

  void discard() override {}

 private:
  int& count_;
};

TEST_P(BringUpOf, TheConfigThatIsMadeReadsAndSaysWhatTheDeviceIs) {
  const config::HandConfig config = made();
  EXPECT_EQ(config.device.kind, GetParam().kind);
  EXPECT_EQ(config.motors.size(), static_cast<std::size_t>(count()));
  EXPECT_EQ(config.device.port, "/dev/ttyUSB0");
  EXPECT_FALSE(config.calibration.empty()) << "nothing is armed before it was checked";
  if (GetParam().kind == DeviceKind::kAllegro) {
    EXPECT_GT(1 / config.governor.period_s, 300);
  }
}

TEST_P(BringUpOf, OneMotorIsJoggedAndNoOtherMoves) {
  Bench bench(made());
  const std::vector<double> before = bench.angles();
  const Jogger::Turn turn = bench.jogger("j1").turn(0.1, [] {
    return true;
  });
  EXPECT_FALSE(turn.was_let_go);
  const std::vector<double> after = bench.angles();
  // A weak position loop of ours is still on its way.
  const double close = (GetParam().has_own_loop ? 0.01 : 0.03) + bench.rig().unit(1);
  EXPECT_NEAR(after[1], before[1] + 0.1, close);
  EXPECT_NEAR(turn.to.motor_rad - turn.from.motor_rad, 0.1, close);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (i != 1) {
      EXPECT_NEAR(after[i], before[i], bench.rig().unit(i)) << i;
    }
  }
  EXPECT_FALSE(bench.rig().isPowered());
}

TEST_P(BringUpOf, NobodyWhoHoldsNothingTurns) {
  Bench bench(made());
  const std::vector<double> before = bench.angles();
  EXPECT_TRUE(bench.jogger("j0")
                  .turn(0.1,
                        [] {
                          return false;
                        })
                  .was_let_go);
  EXPECT_EQ(bench.angles(), before);
}

TEST_P(BringUpOf, JogsNoMotorThatKnowsItsZeroBeyondItsRange) {
  if (!GetParam().has_zeros) GTEST_SKIP() << "its zero is not known yet: a jog is how to look";
  Bench bench(made());
  bench.rig().put(0, bench.config.motors[0].range_rad.lower);
  const std::vector<double> before = bench.angles();
  const auto held = [] {
    return true;
  };
  EXPECT_THROW(bench.jogger("j0").turn(-0.1, held), InvalidInput);
  EXPECT_EQ(bench.angles(), before);
  EXPECT_FALSE(bench.jogger("j0").turn(0.1, held).was_let_go) << "away from its end";
  EXPECT_NEAR(bench.angles()[0], before[0] + 0.1, 0.01);
}

/// Somebody who does as he is asked, and tells what he sees.
class GoodOperator {
 public:
  /// Joint i is at 0 where motor i is at `zero_rad`; joint 1 counts the other way.
  GoodOperator(Bench& bench, double zero_rad) : bench_(bench), zero_rad_(zero_rad) {}

  Operator person() {
    Operator told;
    told.say = [this](const std::string& line) {
      said += line + "\n";
      if (line.find(": hold the space bar") != std::string::npos) before_ = bench_.angles();
    };
    told.ask = [this](const std::string& question) -> std::optional<std::string> {
      asked += question + "\n";
      return answer(question);
    };
    told.is_held = [] {
      return true;
    };
    return told;
  }

  std::string said, asked;

 private:
  [[nodiscard]] int directionOf(std::size_t i) const { return i == 1 && hasSecrets() ? -1 : 1; }

  [[nodiscard]] bool hasSecrets() const {
    return !config::traitsOf(bench_.config.device.kind).has_zeros;
  }

  std::string answer(const std::string& question) {
    const auto has = [&question](const char* part) {
      return question.find(part) != std::string::npos;
    };
    if (has("Once more?")) return "n";
    for (std::size_t i = 0; i < bench_.config.motors.size(); ++i) {
      if (!has(fmt::format("'j{}'", i).c_str())) continue;
      const auto put = [&](double joint_rad) {
        bench_.rig().put(i, zero_rad_ + directionOf(i) * joint_rad);
        return "";
      };
      if (has("to its zero")) return put(0);
      if (has("to its lower end")) return put(kLower - 0.02);
      if (has("to its upper end")) return put(kUpper + 0.02);
      const double turned = directionOf(i) * (bench_.angles()[i] - before_[i]);
      const bool is_asked_up = has("positive");
      return is_asked_up == (turned > 0) ? "y" : "n";
    }
    return has("[y/n]") ? "y" : "";
  }

  Bench& bench_;
  double zero_rad_;
  std::vector<double> before_;
};

TEST_P(BringUpOf, TheWalkEndsWhereNobodyHoldsAnyMore) {
  Bench bench(made());
  GoodOperator good(bench, 0.0);
  Operator person = good.person();
  person.is_held = [] {
    return false;
  };
  int asked = 0;
  person.has_left = [&asked] {
    return ++asked > 2;
  };
  config::HandConfig found = bench.config;
  const Findings findings = check(found, bench.maker(), bench.clock(), bench.sleeper(), person);
  EXPECT_EQ(findings.trouble, "it was ended early");
  EXPECT_FALSE(findings.isFine());
  EXPECT_EQ(asked, 3) << "let go, and once more";
}

TEST_P(BringUpOf, TheWalkAsksForNoHandAtADeviceThatIsInUse) {
  Bench bench(made());
  GoodOperator good(bench, 0.0);
  const bridge::MakeDevice in_use =
      [](const config::HandConfig& /*asked*/) -> bridge::DeviceStack {
    throw TransportError("/dev/ttyUSB0 is in use by another process");
  };
  config::HandConfig found = bench.config;
  const Findings findings = check(found, in_use, bench.clock(), bench.sleeper(), good.person());
  EXPECT_EQ(findings.trouble, "/dev/ttyUSB0 is in use by another process");
  EXPECT_EQ(good.asked, "");
}

TEST_P(BringUpOf, TheWalksDeviceIsOpenAndOffWhileAHandIsIn) {
  if (GetParam().has_zeros) GTEST_SKIP() << "it is not moved by hand";
  Bench bench(made());
  GoodOperator good(bench, 0.0);
  Operator person = good.person();
  int open = 0;
  const bridge::MakeDevice counted = [&](const config::HandConfig& asked) {
    bridge::DeviceStack stack = bench.maker()(asked);
    stack.bytes = std::make_unique<CountedPort>(open);
    return stack;
  };
  int hands = 0;
  person.ask = [&, ask = person.ask](const std::string& question) {
    if (question.find("by hand") != std::string::npos) {
      ++hands;
      EXPECT_EQ(open, 1) << question;
      EXPECT_FALSE(bench.rig().isPowered()) << question;
    }
    return ask(question);
  };
  config::HandConfig found = bench.config;
  const Findings findings = check(found, counted, bench.clock(), bench.sleeper(), person);
  EXPECT_TRUE(findings.isFine()) << findings.trouble;
  EXPECT_EQ(hands, 3 * count());
  EXPECT_EQ(open, 0);
}

TEST_P(BringUpOf, TheWalkFindsZerosAndDirectionsAndEndsWell) {
  Bench bench(made());
  const bool has_zeros = GetParam().has_zeros;
  GoodOperator good(bench, 0.3);
  config::HandConfig found = bench.config;
  const Findings findings =
      check(found, bench.maker(), bench.clock(), bench.sleeper(), good.person());
  EXPECT_TRUE(findings.isFine()) << findings.trouble << "\n"
                                 << reportText(found, findings) << good.asked << good.said;
  EXPECT_EQ(findings.lacks_watchdog, !GetParam().has_watchdog);
  EXPECT_EQ(good.asked.find("by hand") == std::string::npos, has_zeros) << good.asked;
  EXPECT_FALSE(bench.rig().isPowered());
  for (std::size_t i = 0; i < found.motors.size() && !has_zeros; ++i) {
    EXPECT_EQ(found.motors[i].direction, i == 1 ? -1 : 1) << i;
    EXPECT_NEAR(found.motors[i].zero_rad, 0.3, 2e-3) << i;
  }
}

// A pinion of 8 mm where the config has 12: all else of the walk is fine with it.
TEST(BringUpOfAGripper, TheWalkFindsAWrongTravel) {
  for (const double travel : {0.012, 0.008}) {
    Bench bench(config::readHandConfig(test::sourceDirectory() / "hardware" / "config" /
                                       "examples" / "printed_gripper.yaml"));
    std::string asked;
    Operator person;
    person.say = [](const std::string& /*line*/) {};
    person.is_held = [] {
      return true;
    };
    person.ask = [&](const std::string& question) -> std::optional<std::string> {
      asked += question + "\n";
      const auto has = [&question](const char* part) {
        return question.find(part) != std::string::npos;
      };
      if (has("to its zero") || has("to its lower end")) bench.rig().put(0, 0.0);
      if (has("to its upper end")) bench.rig().put(0, 0.036 / travel);
      return has("Once more?") ? "n" : has("[y/n]") ? "y" : "";
    };
    config::HandConfig found = bench.config;
    const Findings findings =
        check(found, bench.maker(), bench.clock(), bench.sleeper(), person);
    EXPECT_NE(asked.find("to its upper end, 0.036 m (3 rad)"), std::string::npos) << asked;
    ASSERT_EQ(findings.motors.size(), 1u) << findings.trouble;
    EXPECT_EQ(findings.motors[0].objection,
              travel == 0.012 ? ""
                              : "between its ends it turned by 4.50 rad, not 3.00: "
                                "travel_m_rad is 0.008 by that, and 0.012 in the config");
  }
}

TEST_P(BringUpOf, ScanFindsItOnATtyAndSaysWhatComesNext) {
  const config::HandConfig config = made();
  const auto rig = test::makeHandRig(config, true);
  const std::vector<Found> found = scan(test::portOf(rig->wire()));
  const bool has_ids = GetParam().own_motors == 0;
  ASSERT_EQ(found.size(), has_ids ? static_cast<std::size_t>(count()) : 1u);
  EXPECT_EQ(found[0].kind, GetParam().name);
  const std::string text = scanText("/dev/ttyACM3", found);
  const auto has = [&text](const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(fmt::format("--kind {} --port /dev/ttyACM3", GetParam().name))) << text;
  EXPECT_EQ(has("--ids 0,1,2,3"), has_ids) << text;
  EXPECT_EQ(has("--can-bitrate"), GetParam().wire == config::DeviceWire::kCan) << text;
  EXPECT_EQ(has("--baud"), GetParam().wire == config::DeviceWire::kTty) << text;
  EXPECT_FALSE(rig->isPowered());
}

std::vector<DeviceTraits> wiredKinds() {
  std::vector<DeviceTraits> kinds;
  for (const DeviceTraits& traits : config::deviceKinds())
    if (traits.wire != config::DeviceWire::kNone) kinds.push_back(traits);
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(EveryKind, BringUpOf, testing::ValuesIn(wiredKinds()), namedOf);

TEST(DeviceKinds, AreThereOnceEachAndKnowThemselves) {
  std::set<std::string> names;
  for (const DeviceTraits& traits : config::deviceKinds()) {
    EXPECT_TRUE(names.insert(traits.name).second) << traits.name;
    EXPECT_EQ(&config::traitsOf(traits.kind), &traits);
  }
  EXPECT_EQ(names.size(), 6u);
}

}  // namespace
}  // namespace handgraft::bringup
