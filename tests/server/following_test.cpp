// A demonstrator's frames, through the service: answered by poses, refused with a reason.
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/hand/mano_joints.h"
#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;

class FollowingTest : public testing::Test {
 protected:
  FollowingTest() {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
    const v1::Reply opened = bus.ask(test::openSession("clamp", "fruit", "marks"));
    EXPECT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
    session = opened.body().session().session_id();
  }

  /// Of the clamp's joint, its root somewhere.
  v1::DemonstratorFrame joints(double time_s, std::vector<double> values) {
    v1::DemonstratorFrame frame;
    frame.session_id(session);
    frame.client({1});
    frame.sequence_number(++sent_);
    frame.time_s(time_s);
    frame.kind(v1::DEMONSTRATOR_JOINTS);
    frame.hand("clamp");
    frame.values(std::move(values));
    v1::Pose X;
    X.q_wxyz({1.0, 0.0, 0.0, 0.0});
    frame.X_WH().push_back(X);
    frame.X_WO(X);
    return frame;
  }

  v1::DemonstratorFrame places(double time_s, std::size_t numbers) {
    v1::DemonstratorFrame frame = joints(time_s, std::vector<double>(numbers, 9.0));
    frame.kind(v1::DEMONSTRATOR_JOINT_PLACES);
    frame.X_WH().clear();
    return frame;
  }

  bool isTold(const std::string& trouble, v1::FollowVerdict verdict = v1::FOLLOW_REFUSED) {
    return bus
        .await<v1::SessionState>(bus.states,
                                 [&](const v1::SessionState& state) {
                                   return state.message().find(trouble) != std::string::npos &&
                                          state.following().text().find(trouble) !=
                                              std::string::npos &&
                                          state.following().verdict() == verdict;
                                 })
        .has_value();
  }

  /// Waits until that is what the session says now.
  bool becomes(const std::string& trouble) {
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (message().find(trouble) == std::string::npos) {
      if (std::chrono::steady_clock::now() > patience) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

  /// Of the frame at that time.
  bool isAnswered(double time_s) {
    return bus
        .await<v1::PoseSolution>(bus.solutions,
                                 [&](const v1::PoseSolution& solution) {
                                   return solution.time_s() == std::vector<double>{time_s};
                                 })
        .has_value();
  }

  std::string message() {
    return bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session))
        .body()
        .session()
        .message();
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
  std::uint64_t session = 0;

 private:
  std::uint64_t sent_ = 0;
};

// The look after idle sessions, with each status, used to take it away.
TEST_F(FollowingTest, WhyAFrameIsRefusedIsToldUntilOneIsRight) {
  bus.send(places(0.0, 60));
  ASSERT_TRUE(isTold("values: 60 numbers; 21 joints' places have 63"));
  const std::size_t told = bus.count(bus.statuses);
  ASSERT_TRUE(bus.await<v1::ServerStatus>(bus.statuses, [&](const v1::ServerStatus&) {
    return bus.statuses.size() >= told + 2;
  }));
  EXPECT_THAT(message(), HasSubstr("values: 60 numbers"));
  bus.send(places(0.1, 63));
  EXPECT_TRUE(isTold("from the wrist along the middle finger to its tip 0 m; a hand has 0.05"));
}

TEST_F(FollowingTest, PlacesInMillimetresAreAskedFor) {
  v1::DemonstratorFrame frame = places(0.0, 63);
  const auto with_finger_of = [&](double length) {
    frame.values(std::vector<double>(63, 0.0));
    for (std::size_t joint = 9; joint < 13; ++joint)
      frame.values()[3 * joint] = length * static_cast<double>(joint - 8) / 4.0;
    frame.sequence_number(frame.sequence_number() + 1);
    return frame;
  };
  bus.send(with_finger_of(181.0));
  EXPECT_TRUE(isTold("to its tip 181 m; a hand has 0.05 to 0.5: millimetres?"));
  bus.send(with_finger_of(18.0));
  EXPECT_TRUE(isTold("to its tip 18 m; a hand has 0.05 to 0.5: centimetres?"));
  bus.send(with_finger_of(2000.0));
  ASSERT_TRUE(isTold("to its tip 2e+03 m"));
  EXPECT_EQ(message().find("metres?"), std::string::npos) << message();
}

TEST_F(FollowingTest, JointsInAnotherOrderAreRefused) {
  const hand::JointPlaces joints =
      hand::manoJointPlaces(Eigen::Matrix<double, hand::kManoPoseSize, 1>::Zero(),
                            Eigen::Vector3d::Zero(), hand::HandSide::kRight);
  v1::DemonstratorFrame frame = places(0.0, 63);
  hand::JointPlaces wrist_last;
  wrist_last << joints.rightCols<20>(), joints.col(0);
  frame.values().assign(wrist_last.data(), wrist_last.data() + wrist_last.size());
  bus.send(frame);
  EXPECT_TRUE(isTold("another order, the wrist last"));
}

// A hand that has no pose before it touches is told why.
TEST_F(FollowingTest, KnucklesInOneLineAreToldWhereTheHandWaits) {
  hand::JointPlaces joints =
      hand::manoJointPlaces(Eigen::Matrix<double, hand::kManoPoseSize, 1>::Zero(),
                            Eigen::Vector3d(0.0, 0.0, 1.0), hand::HandSide::kRight);
  for (const Eigen::Index knuckle : {5, 13, 17})
    joints.col(knuckle) = joints.col(9);
  v1::DemonstratorFrame frame = places(0.0, 63);
  frame.values().assign(joints.data(), joints.data() + joints.size());
  bus.send(frame);
  EXPECT_TRUE(isTold("its knuckles lie in one line", v1::FOLLOW_WAITS));
}

TEST_F(FollowingTest, AnotherDemonstratorIsToldAnewThoughItBeTheSame) {
  bus.send(places(0.0, 60));
  ASSERT_TRUE(becomes("values: 60 numbers"));
  const std::size_t before = bus.count(bus.states);
  v1::DemonstratorFrame of_another = places(0.0, 60);
  of_another.client({2});
  bus.send(of_another);
  EXPECT_TRUE(bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& newest) {
    const bool is_told = newest.message().find("values: 60 numbers") != std::string::npos;
    return is_told && std::any_of(bus.states.begin() + static_cast<std::ptrdiff_t>(before),
                                  bus.states.end(), [](const v1::SessionState& state) {
                                    return state.message().empty();
                                  });
  })) << "it was told nothing of its own";
}

TEST_F(FollowingTest, JointsThatSayNothingAreRefused) {
  bus.send(joints(0.0, {0.1, 0.2}));
  EXPECT_TRUE(isTold("values: 2 numbers; hand 'clamp' has 1 joints"));
  bus.send(joints(0.1, {std::nan("")}));
  EXPECT_TRUE(isTold("values: one of them is not finite"));
  v1::DemonstratorFrame frame = joints(0.2, {0.1});
  frame.X_WH().clear();
  bus.send(frame);
  EXPECT_TRUE(isTold("X_WH: missing"));
  frame = joints(0.3, {0.1});
  frame.hand("claw");
  bus.send(frame);
  EXPECT_TRUE(isTold("'claw'"));
  EXPECT_EQ(bus.count(bus.solutions), 0u);
  // One that is right: the hand comes near, though nothing touches yet.
  bus.send(joints(0.4, {0.1}));
  ASSERT_TRUE(isAnswered(0.4));
  EXPECT_EQ(bus.solutions.back().verdict(), "the demonstrator touches nothing");
  EXPECT_TRUE(bus.solutions.back().patches().empty());
}

TEST_F(FollowingTest, WhatWasNotFollowedIsNoFile) {
  v1::RequestBody body;
  v1::ExportRequest ask;
  ask.session_id(session);
  ask.format(v1::EXPORT_NPZ);
  ask.live(true);
  body.export_file(ask);
  const v1::Reply refused = bus.ask(body);
  EXPECT_EQ(refused.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(refused.message(), HasSubstr("has followed no demonstrator yet"));
}

TEST_F(FollowingTest, OneDemonstratorAtATime) {
  bus.send(joints(0.0, {0.1}));
  EXPECT_TRUE(isAnswered(0.0));
  // The first one took its time: the hand was made ready. This is heard at once.
  bus.send(joints(0.05, {std::nan("")}));
  ASSERT_TRUE(becomes("one of them is not finite"));
  v1::DemonstratorFrame of_another = joints(0.1, {0.1});
  of_another.client({2});
  bus.send(of_another);
  EXPECT_TRUE(becomes("another one is followed, until it has stopped for 500 ms"));
  // It goes on as if nobody had spoken; a writer that counts anew has a clock of its own.
  bus.send(joints(0.2, {0.1}));
  EXPECT_TRUE(isAnswered(0.2));
  bus.send(joints(0.1, {0.1}));
  EXPECT_TRUE(becomes("does not lie behind the one before it"));
  v1::DemonstratorFrame anew = joints(0.1, {0.1});
  anew.sequence_number(1);
  bus.send(anew);
  EXPECT_TRUE(isAnswered(0.1));
}

}  // namespace
}  // namespace handgraft::server
