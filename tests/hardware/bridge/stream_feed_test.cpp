#include "hardware/bridge/stream_feed.h"

#include <gtest/gtest.h>

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;

class StreamFeedTest : public ::testing::Test {
 protected:
  /// The stream of the pose that comes of it; 0: none.
  std::uint64_t see(StreamFeed& by, const v1::PoseSolution& pose) {
    by.see(pose);
    const auto taken = by.take({}, {});
    return taken ? taken->stream : 0;
  }

  StreamFeed feed{std::nullopt, false, false};
};

TEST_F(StreamFeedTest, ASessionIsOneStreamThatLivesWhileItIsOpen) {
  feed.serverIsThere(true);
  EXPECT_FALSE(feed.alive({}));
  feed.see(sessionState(3, "hand", {"a"}));
  const std::uint64_t stream = see(feed, solution(3, 1, {0.1}));
  EXPECT_EQ(feed.alive({}), stream);
  EXPECT_EQ(see(feed, solution(3, 2, {0.2})), stream);
  feed.see(sessionState(3, "hand", {"a"}, v1::PHASE_CLOSED));
  EXPECT_FALSE(feed.alive({}));
}

TEST_F(StreamFeedTest, ASimulatedHandCompletesTheLastPoseOfAClosedSession) {
  StreamFeed simulated(std::nullopt, false, true);
  simulated.serverIsThere(true);
  simulated.see(sessionState(3, "hand", {"a"}));
  const std::uint64_t stream = see(simulated, solution(3, 1, {0.1}));
  simulated.see(sessionState(3, "hand", {"a"}, v1::PHASE_CLOSED));
  EXPECT_EQ(simulated.alive({}), stream);
}

TEST_F(StreamFeedTest, ADemonstratorsStreamLivesWhileFramesAreAnswered) {
  using std::chrono::milliseconds;
  feed.serverIsThere(true);
  feed.see(sessionState(3, "hand", {"a"}));
  v1::PoseSolution live = solution(3, 1, {0.1});
  live.time_s({0.5});
  feed.see(live);
  const StreamFeed::Time begin{};
  const std::uint64_t stream = feed.take(live.stamp_ns(), begin)->stream;
  EXPECT_EQ(feed.alive(begin + milliseconds(400)), stream);
  EXPECT_FALSE(feed.alive(begin + milliseconds(600)));
  EXPECT_TRUE(feed.isLeft(begin + milliseconds(600)));
  live.sequence_number(2);
  feed.see(live);
  EXPECT_EQ(feed.take(live.stamp_ns(), begin + milliseconds(700))->stream, stream);
  EXPECT_EQ(feed.alive(begin + milliseconds(800)), stream);
  EXPECT_EQ(see(feed, solution(3, 3, {0.2})), stream);
  EXPECT_EQ(feed.alive(begin + milliseconds(90'000)), stream) << "an edit's pose stands";
}

TEST_F(StreamFeedTest, AnotherSessionIsAnotherStream) {
  feed.serverIsThere(true);
  feed.see(sessionState(3, "hand", {"a"}));
  feed.see(sessionState(4, "hand", {"a"}));
  const std::uint64_t first = see(feed, solution(3, 7, {0.1}));
  const std::uint64_t second = see(feed, solution(4, 1, {0.1}));
  EXPECT_NE(first, 0);
  EXPECT_NE(second, 0);
  EXPECT_NE(first, second);
}

TEST_F(StreamFeedTest, TellsAPoseOfARestartedServerFromTheNextOne) {
  constexpr std::uint64_t kLife = std::uint64_t{1} << 32;
  feed.serverIsThere(true);
  EXPECT_FALSE(feed.isAnew(solution(3, 2 * kLife + 1, {0.1}))) << "nothing is followed yet";
  feed.see(sessionState(3, "hand", {"a"}));
  see(feed, solution(3, 7, {0.1}));
  EXPECT_FALSE(feed.isAnew(solution(3, 8, {0.1})));
  EXPECT_FALSE(feed.isAnew(solution(4, 2 * kLife + 1, {0.1}))) << "another session's";
  EXPECT_TRUE(feed.isAnew(solution(3, 2 * kLife + 1, {0.1})));
}

TEST_F(StreamFeedTest, AServerThatStartsAnewIsAnotherStream) {
  feed.serverIsThere(true);
  feed.see(sessionState(3, "hand", {"a"}));
  const std::uint64_t first = see(feed, solution(3, 7, {0.1}));
  feed.serverIsThere(false);
  EXPECT_FALSE(feed.alive({}));
  feed.serverIsThere(true);
  EXPECT_FALSE(feed.alive({})) << "nothing was said since it is back";
  feed.see(sessionState(3, "hand", {"a"}));
  EXPECT_NE(see(feed, solution(3, 8, {0.2})), first);
}

TEST_F(StreamFeedTest, NumbersThatRunBackwardsAreAnotherStream) {
  feed.serverIsThere(true);
  feed.see(sessionState(3, "hand", {"a"}));
  const std::uint64_t first = see(feed, solution(3, 7, {0.1}));
  v1::PoseSolution anew = solution(3, 1, {0.2});
  anew.stamp_ns(solution(3, 7, {}).stamp_ns() + 1);
  const std::uint64_t second = see(feed, anew);
  EXPECT_NE(second, 0);
  EXPECT_NE(second, first);
}

// A final pose comes at once, and again with the next number once it is diagnosed.
TEST_F(StreamFeedTest, ADiagnosedPoseIsTheSameStreamAndARepeat) {
  feed.serverIsThere(true);
  feed.see(sessionState(3, "hand", {"a"}));
  v1::PoseSolution pose = solution(3, 7, {0.25});
  pose.is_diagnosed(false);
  feed.see(pose);
  const auto first = feed.take({}, {});
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->is_repeat);
  v1::PoseSolution diagnosed = solution(3, 8, {0.25});
  diagnosed.is_diagnosed(true);
  feed.see(diagnosed);
  const auto second = feed.take({}, {});
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->is_repeat);
  EXPECT_EQ(second->stream, first->stream);
  EXPECT_EQ(feed.alive({}), first->stream);
  feed.see(solution(3, 9, {0.5}));
  EXPECT_FALSE(feed.take({}, {})->is_repeat) << "an edit's pose is news";
  feed.see(solution(4, 1, {0.5}));
  feed.see(sessionState(4, "hand", {"a"}));
  feed.see(sessionState(3, "hand", {"a"}, v1::PHASE_CLOSED));
  EXPECT_FALSE(feed.take({}, {})->is_repeat) << "and so is another session's, be it the same";
}

TEST_F(StreamFeedTest, SessionsOfAnotherHandArePassedOver) {
  StreamFeed feed(std::nullopt, false, false, "leap");
  feed.serverIsThere(true);
  EXPECT_TRUE(feed.see(sessionState(3, "leap", {"a"})));
  const std::uint64_t stream = see(feed, solution(3, 1, {0.1}));
  EXPECT_FALSE(feed.see(sessionState(4, "leap_left", {"a"})));
  EXPECT_EQ(see(feed, solution(4, 1, {0.5})), 0);
  EXPECT_EQ(feed.alive({}), stream) << "and do not take the hand away";
}

TEST_F(StreamFeedTest, TheFollowedSessionsOwnHandSwappedEndsTheStream) {
  StreamFeed feed(std::nullopt, false, false, "leap");
  const auto at = [](auto message, std::uint64_t revision) {
    message.revision(revision);
    return message;
  };
  feed.serverIsThere(true);
  feed.see(at(sessionState(3, "leap", {"a"}), 4));
  const std::uint64_t stream = see(feed, at(solution(3, 1, {0.1}), 4));
  ASSERT_NE(stream, 0);
  EXPECT_EQ(see(feed, at(solution(3, 2, {0.9}), 5)), 0) << "whose it is was not said yet";
  EXPECT_FALSE(feed.see(at(sessionState(3, "leap_left", {"a"}), 5)));
  EXPECT_FALSE(feed.take({}, {}));
  EXPECT_FALSE(feed.alive({}));
  EXPECT_EQ(see(feed, at(solution(3, 3, {0.8}), 5)), 0);

  EXPECT_TRUE(feed.see(at(sessionState(3, "leap", {"a"}), 6)));
  EXPECT_FALSE(feed.take({}, {})) << "the newest pose is the other hand's";
  EXPECT_EQ(see(feed, at(solution(3, 4, {0.7}), 5)), 0) << "and so is one that was late";
  EXPECT_FALSE(feed.alive({}));
  const std::uint64_t returned = see(feed, at(solution(3, 5, {0.1}), 6));
  EXPECT_NE(returned, 0);
  EXPECT_NE(returned, stream) << "it takes an ARM";
  EXPECT_EQ(feed.alive({}), returned);
  EXPECT_EQ(see(feed, at(solution(3, 6, {0.2}), 6)), returned);
}

TEST_F(StreamFeedTest, AnotherSessionIsFollowedOnceTheHandIsSwapped) {
  StreamFeed feed(std::nullopt, false, false, "leap");
  feed.serverIsThere(true);
  feed.see(sessionState(3, "leap", {"a"}));
  const std::uint64_t stream = see(feed, solution(3, 1, {0.1}));
  feed.see(sessionState(3, "leap_left", {"a"}));
  feed.see(sessionState(2, "leap", {"a"}));
  const std::uint64_t other = see(feed, solution(2, 1, {0.2}));
  EXPECT_NE(other, 0);
  EXPECT_NE(other, stream);
  EXPECT_EQ(feed.session(), 2);
}

}  // namespace
}  // namespace handgraft::bridge
