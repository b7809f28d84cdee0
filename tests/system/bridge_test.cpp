// The bridge as a process: it follows a session's solutions and publishes what it measures.

#include <cmath>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "idl/hardware.h"
#include "idl/sensor_msgs.h"

#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

/// Takes from a reader until `wanted` holds, for at most a minute.
template <class Message, class Predicate>
std::optional<Message> await(idl::cyclone::Reader<Message>& reader, const Predicate& wanted) {
  std::optional<Message> found;
  for (int i = 0; i < 600 && !found; ++i) {
    reader.wait(std::chrono::milliseconds(100));
    reader.take([&](const Message& message) {
      if (!found && wanted(message)) found = message;
    });
  }
  return found;
}

class Bridge : public testing::Test {
 protected:
  Service service;
  LiveSession session{service, "barrett8", "lemon", "lemon_6"};
  idl::cyclone::Participant participant{service.network()};
  idl::cyclone::Reader<v1::JointState> states{participant, idl::kJointStateTopic};
};

TEST_F(Bridge, MovesItsHandToTheSolution) {
  const auto bridge = service.start("handgraft-bridge", {});
  const v1::PoseSolution solved = session.optimize();
  const auto arrived = await(states, [&](const v1::JointState& state) {
    if (state.position().size() != solved.joint_positions().size()) return false;
    double worst = 0.0;
    for (std::size_t i = 0; i < solved.joint_positions().size(); ++i) {
      worst = std::max(worst, std::abs(state.position()[i] - solved.joint_positions()[i]));
    }
    return worst < 5e-3;  // rad; targets keep a margin inside the limits
  });
  ASSERT_TRUE(arrived.has_value()) << bridge->err();
  EXPECT_EQ(arrived->session_id(), session.id());
  EXPECT_EQ(arrived->names(), session.opened().joint_names());
}

TEST_F(Bridge, GivesRosTheMeasuredJoints) {
  idl::cyclone::Reader<sensor_msgs::msg::dds_::JointState_> ros(participant,
                                                                idl::kRosJointStatesTopic);
  const auto bridge = service.start("handgraft-bridge", {});
  session.optimize();
  const auto sample = await(ros, [](const auto& message) {
    return !message.name().empty();
  });
  ASSERT_TRUE(sample.has_value()) << bridge->err();
  EXPECT_EQ(sample->name(), session.opened().joint_names());
  EXPECT_EQ(sample->position().size(), sample->name().size());
  EXPECT_EQ(sample->velocity().size(), sample->name().size());
  EXPECT_GT(sample->header().stamp().sec(), 0);
}

TEST_F(Bridge, LearnsALateSolutionOnItsOwnStart) {
  const v1::PoseSolution solved = session.optimize();
  const auto bridge = service.start("handgraft-bridge", {});  // joins late
  const auto moving = await(states, [&](const v1::JointState& state) {
    return state.session_id() == session.id() && !state.target().empty();
  });
  ASSERT_TRUE(moving.has_value()) << bridge->err();
  EXPECT_EQ(moving->target().size(), solved.joint_positions().size());
}

TEST_F(Bridge, StopsForGoodOnAnEstop) {
  idl::cyclone::Writer<v1::HandCommand> commands(participant, idl::kHandCommandTopic);
  const auto bridge = service.start("handgraft-bridge", {"--bridge-id", "7"});
  session.optimize();
  ASSERT_TRUE(await(states, [](const auto& s) {
    return !s.position().empty();
  }));
  v1::HandCommand command;
  command.bridge_id(7);
  command.command_id(1);
  command.kind(v1::HandCommandKind::COMMAND_ESTOP);
  commands.write(command);
  const auto stopped = await(states, [](const v1::JointState& state) {
    return state.state() == v1::BridgeState::BRIDGE_ESTOP;
  });
  EXPECT_TRUE(stopped.has_value());
}

TEST_F(Bridge, ArmsItselfNoMoreOnceItsServerWasGone) {
  idl::cyclone::Writer<v1::HandCommand> commands(participant, idl::kHandCommandTopic);
  const auto bridge = service.start("handgraft-bridge", {});
  session.optimize();
  const auto armed = [](const v1::JointState& state) {
    return state.state() == v1::BridgeState::BRIDGE_ARMED;
  };
  ASSERT_TRUE(await(states, armed)) << bridge->err();
  service.server().send(SIGSTOP);
  ASSERT_TRUE(bridge->waitForText("the server is gone"));
  ASSERT_TRUE(await(states, [](const v1::JointState& state) {
    return state.state() == v1::BridgeState::BRIDGE_IDLE;
  }));
  // Refused now, it moves nothing when poses come again.
  v1::HandCommand command;
  command.bridge_id(1);
  command.kind(v1::HandCommandKind::COMMAND_ARM);
  command.command_id(10);
  commands.write(command);
  ASSERT_TRUE(bridge->waitForText("ARM refused")) << bridge->err();
  service.server().send(SIGCONT);
  ASSERT_TRUE(bridge->waitForText("server found"));
  session.optimize();
  EXPECT_TRUE(await(states, [&](const v1::JointState& state) {
    EXPECT_FALSE(armed(state)) << "armed itself";
    return state.state() == v1::BridgeState::BRIDGE_IDLE && !state.target().empty();
  }));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  states.take([&](const v1::JointState& state) {
    EXPECT_FALSE(armed(state)) << "armed itself";
  });
  command.command_id(11);
  commands.write(command);
  EXPECT_TRUE(await(states, armed)) << bridge->err();
}

TEST_F(Bridge, EndsCleanlyOnSigterm) {
  const auto bridge = service.start("handgraft-bridge", {});
  session.optimize();
  ASSERT_TRUE(await(states, [](const auto& s) {
    return !s.position().empty();
  }));
  bridge->send(SIGTERM);
  EXPECT_EQ(bridge->wait(), 0) << bridge->err();
}

}  // namespace
}  // namespace handgraft::test
