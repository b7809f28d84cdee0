#include <chrono>
#include <csignal>
#include <future>
#include <utility>

#include <gtest/gtest.h>

#include "idl/sensor_msgs.h"
#include "idl/service.h"

#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

TEST(Stream, CarriesTheSolutionThatTheReplyCarries) {
  const Service service;
  LiveSession session(service, "tendon16", "wine_glass", "wine_glass_4");
  const v1::PoseSolution reply = session.optimize();
  const auto streamed = session.solution([](const auto& s) {
    return s.is_final();
  });
  ASSERT_TRUE(streamed.has_value());
  EXPECT_EQ(streamed->joint_positions(), reply.joint_positions());
  EXPECT_EQ(streamed->X_WH(), reply.X_WH());
  EXPECT_EQ(streamed->terms(), reply.terms());
}

TEST(Stream, NumbersItsSamplesWithoutGaps) {
  const Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  unsigned long long previous = 0;
  for (int i = 0; i < 5; ++i) {
    session.optimize();
    const auto solution = session.solution([&](const auto& s) {
      return s.is_final() && s.sequence_number() > previous;
    });
    ASSERT_TRUE(solution.has_value());
    previous = solution->sequence_number();
  }
  for (std::size_t i = 1; i < session.solutions().size(); ++i) {
    EXPECT_GT(session.solutions()[i].sequence_number(),
              session.solutions()[i - 1].sequence_number());
  }
}

TEST(Stream, IsSeenByALateJoiner) {
  const Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  const v1::PoseSolution solved = session.optimize();

  const idl::cyclone::Participant late(service.network());
  idl::cyclone::Reader<v1::PoseSolution> solutions(late, idl::kSolutionTopic);
  idl::cyclone::Reader<v1::SessionState> states(late, idl::kSessionTopic);
  std::optional<v1::PoseSolution> seen;
  std::optional<v1::SessionState> state;
  for (int i = 0; i < 600 && !(seen && state); ++i) {
    solutions.wait(std::chrono::milliseconds(100));
    solutions.take([&](const v1::PoseSolution& sample) {
      seen = sample;
    });
    states.take([&](const v1::SessionState& sample) {
      state = sample;
    });
  }

  ASSERT_TRUE(seen.has_value() && state.has_value());
  EXPECT_EQ(seen->joint_positions(), solved.joint_positions());
  EXPECT_EQ(state->session_id(), session.id());
  EXPECT_EQ(state->hand(), "barrett8");
}

TEST(Stream, GivesRosTheSolvedJointsByName) {
  const Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  const std::string topic = "rt/handgraft/" + std::to_string(session.id()) + "/joint_command";
  const idl::cyclone::Participant ros(service.network());
  idl::cyclone::Reader<sensor_msgs::msg::dds_::JointState_> commands(
      ros, {topic.c_str(), idl::kRosJointStatesTopic.qos});
  std::optional<sensor_msgs::msg::dds_::JointState_> seen;
  v1::PoseSolution solved;
  // A volatile topic: what was solved before the match is rightly not seen, so solve until it
  // is.
  for (int i = 0; i < 50 && !seen; ++i) {
    solved = session.optimize();
    commands.wait(std::chrono::milliseconds(500));
    commands.take([&](const auto& sample) {
      seen = sample;
    });
  }
  ASSERT_TRUE(seen.has_value()) << "nothing on " << topic;
  ASSERT_EQ(seen->name().size(), seen->position().size());
  ASSERT_GE(seen->name().size(), solved.joint_positions().size());
  for (std::size_t i = 0; i < solved.joint_positions().size(); ++i) {
    EXPECT_EQ(seen->name()[i], session.opened().joint_names()[i]);
  }
}

TEST(Sessions, AreSolvedAlikeSideBySide) {
  const Service service({"--workers", "2"});
  LiveSession first(service, "barrett8", "lemon", "lemon_6");
  LiveSession second(service, "barrett8", "lemon", "lemon_6");
  EXPECT_NE(first.id(), second.id());
  EXPECT_EQ(first.optimize().joint_positions(), second.optimize().joint_positions());
}

TEST(Server, StopsCleanlyOnSigterm) {
  Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  service.server().send(SIGTERM);
  EXPECT_EQ(service.server().wait(), 0) << service.server().err();
}

TEST(Server, StopsCleanlyInTheMiddleOfWork) {
  constexpr std::chrono::seconds kPatience(60);
  std::promise<void> at_work;
  std::promise<void> ended;
  Service service;
  const idl::cyclone::Participant participant(service.network());
  idl::cyclone::Requester requester(participant);
  ASSERT_TRUE(requester.waitForServer(kPatience));
  v1::OpenSessionRequest request;
  request.hand("human20");
  request.object("box");
  request.contacts("box_5");
  v1::RequestBody body;
  body.open_session(request);
  requester.begin(
      body,
      [&](const auto&) {
        ended.set_value();
      },
      [&, is_told = false](const std::string&, double) mutable {
        if (!std::exchange(is_told, true)) at_work.set_value();
      });
  ASSERT_EQ(at_work.get_future().wait_for(kPatience), std::future_status::ready);
  service.server().send(SIGTERM);
  EXPECT_EQ(service.server().wait(), 0) << service.server().err();
  EXPECT_EQ(ended.get_future().wait_for(kPatience), std::future_status::ready)
      << "the client must notice that its server is gone";
}

}  // namespace
}  // namespace handgraft::test
