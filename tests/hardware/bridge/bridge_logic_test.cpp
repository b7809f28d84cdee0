#include "hardware/bridge/bridge_logic.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hardware/bridge/simulated_hand.h"

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;
using testing::HasSubstr;

const std::vector<std::string> kNames = {"a", "b"};

/// A bridge with a simulated hand in virtual time.
class Rig {
 public:
  explicit Rig(BridgeOptions options = {}) : period_(options.period_s), logic(options) {}

  /// A server, one session of a hand of two joints, and the answer about it.
  void connect(std::uint64_t session = 3) {
    logic.serverIsThere(true);
    logic.see(sessionState(session, "tiny", kNames));
    pose(session, {0, 0});
    run(0.02);
  }

  void pose(std::uint64_t session, const std::vector<double>& joint_rad) {
    logic.see(solution(session, ++number_, joint_rad));
    if (logic.question()) {
      logic.answer(*logic.question(), handOf("tiny", {joint("a", -1, 1), joint("b", 0, 2)}));
    }
  }

  void order(v1::HandCommandKind kind) { logic.obey(command(++command_, kind)); }

  void run(double seconds) {
    for (double t = 0; t < seconds; t += period_)
      turn();
  }

  double position(std::size_t joint = 0) const { return reading_.position[joint]; }

  bool isPowered() const { return powered_; }

  double fastest = 0;
  double highest = -kInfinity;

 private:
  void turn() {
    now_ += std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(period_));
    if (logic.plan() != nullptr && !hand_) {
      hand_ = std::make_unique<SimulatedHand>(
          std::vector<SimulatedJoint>{{-1, 1, 2, 0}, {0, 2, 2, 0}}, [this] {
            return now_;
          });
      hand_->open();
    }
    if (!hand_) return;
    hand_->read(reading_);
    fastest = std::max(fastest, std::abs(reading_.velocity[0]));
    highest = std::max(highest, reading_.position[0]);
    const MotorOrder motors = logic.tick(reading_);
    powered_ = motors.powered;
    motors.powered ? hand_->write(motors.positions) : hand_->stop();
  }

  double period_;
  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
  std::unique_ptr<SimulatedHand> hand_;
  JointReading reading_;
  bool powered_ = false;
  std::uint64_t number_ = 0;
  std::uint64_t command_ = 0;

 public:
  BridgeLogic logic;
};

BridgeOptions careful() {
  BridgeOptions options;
  options.arms_itself = false;
  return options;
}

// === Following

TEST(BridgeLogic, MovesTheHandToTheSolvedPose) {
  Rig rig;
  rig.connect();
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ARMED);
  rig.pose(3, {0.7, 1.2});
  rig.run(3);
  EXPECT_NEAR(rig.position(0), 0.7, 1e-3);
  EXPECT_NEAR(rig.position(1), 1.2, 1e-3);
  EXPECT_EQ(rig.logic.message(), "session 3: pose reached");
  EXPECT_EQ(rig.logic.session(), 3u);
}

TEST(BridgeLogic, MovesWithinTheVelocityBound) {
  BridgeOptions options;
  options.bounds.revolute_velocity = 0.5;
  Rig rig(options);
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(1);
  EXPECT_LE(rig.fastest, 0.5 + 1e-9);
  EXPECT_GT(rig.fastest, 0.4);
}

TEST(BridgeLogic, ClampsPosesIntoTheLimits) {
  Rig rig;
  rig.connect();
  rig.pose(3, {8, -8});
  const double margin = safety::JointLimits{}.margin;
  EXPECT_THAT(rig.logic.target(), testing::ElementsAre(1 - margin, 0 + margin));
  rig.run(3);
  EXPECT_LE(rig.highest, 1);
  EXPECT_NEAR(rig.position(), 1, 1e-3);
}

TEST(BridgeLogic, ReadsAPoseByNamesNotByOrder) {
  Rig rig;
  rig.connect();
  rig.logic.see(sessionState(3, "tiny", {"b", "a"}));
  rig.pose(3, {1.5, 0.25});
  EXPECT_THAT(rig.logic.target(), testing::ElementsAre(0.25, 1.5));
}

TEST(BridgeLogic, RefusesPosesThatItCannotRead) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.5, 0.5});
  const auto refuses = [&](const std::vector<std::string>& names,
                           const std::vector<double>& values, const std::string& words) {
    rig.logic.see(sessionState(3, "tiny", names));
    rig.pose(3, values);
    EXPECT_THAT(rig.logic.message(), HasSubstr(words));
    EXPECT_THAT(rig.logic.target(), testing::ElementsAre(0.5, 0.5)) << words;
  };
  refuses(kNames, {kNaN, 0}, "joint 'a': nan is not finite");
  refuses(kNames, {0, -kInfinity}, "joint 'b': -inf is not finite");
  refuses(kNames, {0}, "1 values for 2 joints");
  refuses({"a", "a"}, {0, 0}, "'a' is named twice");
  refuses({"a"}, {0}, "'b' is missing");
  refuses({"a", "b", "c"}, {0, 0, 0}, "no joint 'c'");
}

// === Which hand

TEST(BridgeLogic, AsksForAHandOnceAndFollowsAfterTheAnswer) {
  BridgeLogic logic{BridgeOptions{}};
  logic.serverIsThere(true);
  EXPECT_EQ(logic.state(), v1::BRIDGE_DISCONNECTED);
  logic.see(sessionState(3, "tiny", kNames));
  EXPECT_FALSE(logic.question()) << "no pose, no need";
  logic.see(solution(3, 1, {0.5, 0.5}));
  ASSERT_EQ(logic.question(), (HandQuestion{3, "tiny"}));
  logic.answer(*logic.question(), handOf("tiny", {joint("a", -1, 1), joint("b", 0, 2)}));
  EXPECT_FALSE(logic.question());
  EXPECT_EQ(logic.planVersion(), 1u);
  EXPECT_THAT(logic.target(), testing::ElementsAre(0.5, 0.5));
}

TEST(BridgeLogic, KeepsItsHandWhenTheNextSessionHasTheSame) {
  Rig rig;
  rig.connect(3);
  rig.logic.see(sessionState(9, "tiny", kNames));
  rig.pose(9, {0.4, 0.4});
  EXPECT_EQ(rig.logic.planVersion(), 1u);
  EXPECT_EQ(rig.logic.session(), 9u);
}

TEST(BridgeLogic, ChangesItsHandWhenTheNextSessionHasAnother) {
  Rig rig;
  rig.connect(3);
  rig.logic.see(sessionState(9, "other", {"c"}));
  rig.logic.see(solution(9, 1, {0.4}));
  ASSERT_EQ(rig.logic.question(), (HandQuestion{9, "other"}));
  EXPECT_EQ(rig.logic.session(), 3u) << "until then it follows the old one";
  rig.logic.answer(*rig.logic.question(), handOf("other", {joint("c", 0, 1)}));
  EXPECT_EQ(rig.logic.planVersion(), 2u);
  EXPECT_EQ(rig.logic.plan()->hand, "other");
  EXPECT_THAT(rig.logic.target(), testing::ElementsAre(0.4));
}

TEST(BridgeLogic, AsksAgainAtTheNextPoseAfterARefusal) {
  BridgeLogic logic{BridgeOptions{}};
  logic.serverIsThere(true);
  logic.see(sessionState(3, "tiny", kNames));
  logic.see(solution(3, 1, {0.5, 0.5}));
  logic.refuse({3, "tiny"}, "no hand 'tiny'");
  EXPECT_FALSE(logic.question());
  EXPECT_EQ(logic.message(), "session 3: no hand 'tiny'");
  logic.see(solution(3, 2, {0.5, 0.5}));
  EXPECT_TRUE(logic.question());
}

TEST(BridgeLogic, TakesADescriptionThatMakesNoSenseForARefusal) {
  BridgeLogic logic{BridgeOptions{}};
  logic.serverIsThere(true);
  logic.see(sessionState(3, "tiny", kNames));
  logic.see(solution(3, 1, {0.5, 0.5}));
  logic.answer({3, "tiny"}, handOf("tiny", {joint("a", 1, -1)}));
  EXPECT_EQ(logic.plan(), nullptr);
  EXPECT_THAT(logic.message(), HasSubstr("limits [1, -1]"));
}

// === Commands

TEST(BridgeLogic, StartsWithoutPowerWhenToldTo) {
  Rig rig(careful());
  rig.connect();
  rig.pose(3, {0.7, 0.7});
  rig.run(1);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE);
  EXPECT_FALSE(rig.isPowered());
  EXPECT_EQ(rig.position(), 0);
  rig.order(v1::COMMAND_ARM);
  rig.run(2);
  EXPECT_NEAR(rig.position(), 0.7, 1e-3);
}

TEST(BridgeLogic, BrakesThenCutsThePowerOnDisarm) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(0.35);
  rig.order(v1::COMMAND_DISARM);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE);
  rig.run(0.03);
  EXPECT_TRUE(rig.isPowered()) << "braking";
  rig.run(1);
  EXPECT_FALSE(rig.isPowered());
  EXPECT_LT(rig.position(), 0.85);
  EXPECT_GT(rig.position(), 0.1);
}

TEST(BridgeLogic, LatchesAnEmergencyStopUntilResetAndArm) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(0.3);
  rig.order(v1::COMMAND_ESTOP);
  rig.run(1);
  const double held = rig.position();
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ESTOP);
  EXPECT_FALSE(rig.isPowered());
  EXPECT_LT(held, 0.85);
  rig.order(v1::COMMAND_ARM);
  EXPECT_EQ(rig.logic.message(), "ARM refused: RESET first");
  rig.pose(3, {0.8, 0});
  rig.run(1);
  EXPECT_EQ(rig.position(), held) << "neither ARM nor a pose moves it";
  rig.order(v1::COMMAND_RESET);
  rig.run(1);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE);
  EXPECT_EQ(rig.position(), held) << "a reset moves nothing";
  rig.order(v1::COMMAND_ARM);
  rig.run(2);
  EXPECT_NEAR(rig.position(), 0.8, 1e-3);
}

TEST(BridgeLogic, ObeysARepeatedCommandOnce) {
  Rig rig;
  rig.connect();
  rig.logic.obey(command(100, v1::COMMAND_ESTOP));
  rig.logic.obey(command(101, v1::COMMAND_RESET));
  rig.logic.obey(command(100, v1::COMMAND_ESTOP));
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE) << "the repeat stopped it again";
  rig.logic.obey(command(102, v1::COMMAND_ESTOP));
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ESTOP);
}

TEST(BridgeLogic, ObeysAnEmergencyStopThatReusesAnotherCommandsId) {
  Rig rig;
  rig.connect();
  rig.logic.obey(command(1, v1::COMMAND_ARM));
  rig.logic.obey(command(1, v1::COMMAND_ESTOP));
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ESTOP);
}

TEST(BridgeLogic, IgnoresCommandsToAnotherBridge) {
  Rig rig;
  rig.connect();
  rig.logic.obey(command(1, v1::COMMAND_ESTOP, 2));
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ARMED);
}

TEST(BridgeLogic, RefusesToArmWithoutHandOrServer) {
  BridgeLogic logic{careful()};
  logic.obey(command(1, v1::COMMAND_ARM));
  EXPECT_EQ(logic.message(), "ARM refused: no hand yet");
  Rig rig(careful());
  rig.connect();
  rig.logic.serverIsThere(false);
  rig.order(v1::COMMAND_ARM);
  EXPECT_EQ(rig.logic.message(), "ARM refused: no server");
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE);
}

// === Loss and faults

TEST(BridgeLogic, BrakesAndHoldsWhenTheServerIsLost) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(0.3);
  rig.logic.serverIsThere(false);
  rig.run(1);
  const double held = rig.position();
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_HOLDING);
  EXPECT_TRUE(rig.isPowered());
  EXPECT_LT(held, 0.85);
  rig.run(1);
  EXPECT_NEAR(rig.position(), held, 1e-6);
}

TEST(BridgeLogic, GoesOnWithAFreshPoseWhenItArmsItself) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(0.2);
  rig.logic.serverIsThere(false);
  rig.run(1);
  const double held = rig.position();
  rig.logic.serverIsThere(true);
  rig.run(1);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_HOLDING) << "a server alone moves nothing";
  EXPECT_NEAR(rig.position(), held, 1e-6);
  rig.logic.see(sessionState(3, "tiny", kNames));
  rig.pose(3, {0.9, 0});
  rig.run(2);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_ARMED);
  EXPECT_NEAR(rig.position(), 0.9, 1e-3);
}

TEST(BridgeLogic, NeedsArmAfterALossWhenItDoesNotArmItself) {
  Rig rig(careful());
  rig.connect();
  rig.order(v1::COMMAND_ARM);
  rig.pose(3, {0.9, 0});
  rig.run(0.2);
  rig.logic.serverIsThere(false);
  rig.run(1);
  const double held = rig.position();
  rig.logic.serverIsThere(true);
  rig.logic.see(sessionState(3, "tiny", kNames));
  rig.pose(3, {0.9, 0});
  rig.run(1);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_HOLDING);
  EXPECT_NEAR(rig.position(), held, 1e-6);
  rig.order(v1::COMMAND_ARM);
  rig.run(2);
  EXPECT_NEAR(rig.position(), 0.9, 1e-3);
}

TEST(BridgeLogic, KeepsGoingToTheLastPoseWhenTheSessionIsClosed) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.logic.see(sessionState(3, "tiny", kNames, v1::PHASE_CLOSED));
  rig.run(3);
  EXPECT_NEAR(rig.position(), 0.9, 1e-3);
}

TEST(BridgeLogic, CutsThePowerAtOnceOnAFaultAndLatches) {
  Rig rig;
  rig.connect();
  rig.pose(3, {0.9, 0});
  rig.run(0.3);
  rig.logic.fail("bus: no answer");
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_FAULT);
  rig.run(0.01);
  EXPECT_FALSE(rig.isPowered());
  rig.order(v1::COMMAND_ARM);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_FAULT);
  rig.order(v1::COMMAND_RESET);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_IDLE);
}

TEST(BridgeLogic, TakesAMeasurementThatIsNotFiniteForAFault) {
  Rig rig;
  rig.connect();
  JointReading reading{{}, {0, kNaN}, {0, 0}};
  EXPECT_FALSE(rig.logic.tick(reading).powered);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_FAULT);
  EXPECT_THAT(rig.logic.message(), HasSubstr("joint 'b'"));
  rig.order(v1::COMMAND_RESET);
  EXPECT_FALSE(rig.logic.tick(reading).powered);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_FAULT) << "its cause has not gone";
}

TEST(BridgeLogic, TakesAMeasurementOfAnotherSizeForAFault) {
  Rig rig;
  rig.connect();
  EXPECT_FALSE(rig.logic.tick({{}, {0}, {0}}).powered);
  EXPECT_EQ(rig.logic.state(), v1::BRIDGE_FAULT);
}

TEST(BridgeLogic, KeepsABoundedNumberOfRemarks) {
  Rig rig;
  rig.connect();
  for (int k = 0; k < 1000; ++k)
    rig.logic.say(std::to_string(k));
  const auto remarks = rig.logic.takeRemarks();
  EXPECT_EQ(remarks.size(), 64u);
  EXPECT_EQ(remarks.back(), "999");
  EXPECT_TRUE(rig.logic.takeRemarks().empty());
}

}  // namespace
}  // namespace handgraft::bridge
