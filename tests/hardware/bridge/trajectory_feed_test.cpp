#include "hardware/bridge/trajectory_feed.h"

#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/topics.h"

#include "tests/hardware/bridge/messages.h"
#include "tests/support/test_domain.h"

namespace handgraft::bridge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> finger_joints{"thumb", "index"};

TrajectoryFeed::Message trajectory(const std::vector<std::string>& names,
                                   const std::vector<std::vector<double>>& points,
                                   std::int32_t stamp_s) {
  TrajectoryFeed::Message message;
  message.header().stamp().sec(stamp_s);
  message.header().stamp().nanosec(stamp_s == 0 ? 0 : 5);
  message.joint_names(names);
  std::uint32_t millisecond = 0;
  for (const std::vector<double>& positions : points) {
    trajectory_msgs::msg::dds_::JointTrajectoryPoint_ point;
    point.positions(positions);
    point.time_from_start().nanosec(1'000'000 * millisecond++);
    message.points().push_back(point);
  }
  return message;
}

TEST(ReadTrajectory, PutsJointsInTheHandsOrderAndTimesEachPoint) {
  const ReadTrajectory read =
      readTrajectory(trajectory({"index", "thumb"}, {{1, 2}, {3, 4}}, 7), finger_joints, 99);
  ASSERT_EQ(read.poses.size(), 2u) << read.refusal;
  EXPECT_THAT(read.poses[0].joint_rad, ElementsAre(2, 1));
  EXPECT_THAT(read.poses[1].joint_rad, ElementsAre(4, 3));
  EXPECT_EQ(read.poses[0].source_ns, 7'000'000'005);
  EXPECT_EQ(read.poses[1].source_ns, 7'001'000'005);
  EXPECT_FALSE(read.poses[0].continues);
  EXPECT_TRUE(read.poses[1].continues);
}

TEST(ReadTrajectory, WithoutAStampItBeginsNow) {
  EXPECT_EQ(readTrajectory(trajectory(finger_joints, {{1, 2}}, 0), finger_joints, 99)
                .poses[0]
                .source_ns,
            99);
}

TEST(ReadTrajectory, SaysWhatIsWrong) {
  const auto refusal = [](const std::vector<std::string>& names,
                          const std::vector<std::vector<double>>& points) {
    const ReadTrajectory read = readTrajectory(trajectory(names, points, 0), finger_joints, 1);
    EXPECT_TRUE(read.poses.empty());
    return read.refusal;
  };
  EXPECT_THAT(refusal({"thumb"}, {{1}}), HasSubstr("'index' is missing"));
  EXPECT_THAT(refusal({"thumb", "thumb"}, {{1, 2}}), HasSubstr("'index' is missing"));
  EXPECT_THAT(refusal({"thumb", "toe"}, {{1, 2}}), HasSubstr("'toe' is none of its joints"));
  EXPECT_THAT(refusal(finger_joints, {{1}}), HasSubstr("1 positions for 2 joints"));
  EXPECT_THAT(refusal(finger_joints, {}), HasSubstr("0 points"));
}

TEST(TrajectoryFeed, HearsOpenSessionsThatSomebodyWritesFor) {
  const handgraft::test::TestDomain domain;
  const idl::cyclone::Participant participant({domain.number(), "lo"});
  const auto bell = std::make_shared<WakeEvent>();
  TrajectoryFeed feed(participant, bell);
  feed.see(test::sessionState(7, "hand", finger_joints));
  const std::string name = idl::sampleTopicName(7);
  idl::Topic<TrajectoryFeed::Message> topic = idl::kRosSamplesTopic;
  topic.name = name.c_str();
  idl::cyclone::Writer<TrajectoryFeed::Message> writer(participant, topic);
  const std::string others_name = idl::sampleTopicName(8);
  topic.name = others_name.c_str();
  const idl::cyclone::Writer<TrajectoryFeed::Message> of_unknown_session(participant, topic);
  std::vector<std::uint64_t> heard;
  const auto take_until = [&](const auto& is_done) {
    for (int i = 0; i < 600 && !is_done(); ++i) {
      bell->wait(std::chrono::milliseconds(10));
      feed.take(std::chrono::steady_clock::now(),
                [&](std::uint64_t session, const TrajectoryFeed::Message&) {
                  heard.push_back(session);
                });
    }
  };
  take_until([&] {
    return writer.readers() != 0;
  });
  ASSERT_EQ(writer.readers(), 1);
  writer.write(trajectory(finger_joints, {{1, 2}}, 3));
  take_until([&] {
    return !heard.empty();
  });
  EXPECT_THAT(heard, ElementsAre(7));
  EXPECT_EQ(of_unknown_session.readers(), 0);
  feed.see(test::sessionState(7, "hand", finger_joints, v1::PHASE_CLOSED));
  for (int i = 0; i < 600 && writer.readers() != 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(writer.readers(), 0);
}

TEST(TrajectoryFeed, FollowsTheFirstOfTwoThatPlayASession) {
  const handgraft::test::TestDomain domain;
  const idl::cyclone::Participant participant({domain.number(), "lo"});
  const auto bell = std::make_shared<WakeEvent>();
  TrajectoryFeed feed(participant, bell);
  feed.see(test::sessionState(7, "hand", finger_joints));
  const std::string name = idl::sampleTopicName(7);
  idl::Topic<TrajectoryFeed::Message> topic = idl::kRosSamplesTopic;
  topic.name = name.c_str();
  idl::cyclone::Writer<TrajectoryFeed::Message> first(participant, topic);
  idl::cyclone::Writer<TrajectoryFeed::Message> second(participant, topic);
  std::chrono::steady_clock::time_point now{};
  std::vector<double> heard;
  const auto take_until = [&](const auto& is_done) {
    for (int i = 0; i < 600 && !is_done(); ++i) {
      bell->wait(std::chrono::milliseconds(10));
      feed.take(now, [&](std::uint64_t, const TrajectoryFeed::Message& message) {
        heard.push_back(message.points().front().positions().front());
      });
    }
  };
  take_until([&] {
    return first.readers() != 0 && second.readers() != 0;
  });
  first.write(trajectory(finger_joints, {{1, 0}}, 3));
  take_until([&] {
    return !heard.empty();
  });
  EXPECT_FALSE(feed.takeOther());
  second.write(trajectory(finger_joints, {{2, 0}}, 3));
  std::optional<std::uint64_t> told;
  take_until([&] {
    return (told = feed.takeOther()).has_value();
  });
  EXPECT_EQ(told, 7u);
  EXPECT_FALSE(feed.takeOther()) << "once";
  first.write(trajectory(finger_joints, {{3, 0}}, 4));
  take_until([&] {
    return heard.size() > 1;
  });
  EXPECT_THAT(heard, ElementsAre(1, 3));
  now += std::chrono::milliseconds(300);  // the first has stopped
  second.write(trajectory(finger_joints, {{4, 0}}, 4));
  take_until([&] {
    return heard.size() > 2;
  });
  EXPECT_THAT(heard, ElementsAre(1, 3, 4));
}

}  // namespace
}  // namespace handgraft::bridge
