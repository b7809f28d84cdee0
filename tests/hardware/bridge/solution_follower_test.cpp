#include "hardware/bridge/solution_follower.h"

#include <gtest/gtest.h>

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;

const std::vector<std::string> two_joints = {"a", "b"};

TEST(SolutionFollower, GivesAPoseOnceItsSessionIsKnown) {
  SolutionFollower follower({}, false);
  follower.see(solution(4, 1, {0.1, 0.2}));
  EXPECT_FALSE(follower.take({})) << "nobody has said what the numbers mean";
  follower.see(sessionState(4, "hand", two_joints));
  const auto pose = follower.take({});
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->session_id, 4u);
  EXPECT_EQ(pose->hand, "hand");
  EXPECT_EQ(pose->names, two_joints);
  EXPECT_EQ(pose->joint_rad, (std::vector{0.1, 0.2}));
  EXPECT_FALSE(follower.take({})) << "a pose is given once";
}

TEST(SolutionFollower, GivesOnlyTheNewestPose) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(4, "hand", two_joints));
  follower.see(solution(4, 1, {0.1, 0.2}));
  follower.see(solution(4, 2, {0.3, 0.4}));
  EXPECT_EQ(follower.take({})->sequence_number, 2u);
  EXPECT_FALSE(follower.take({}));
}

TEST(SolutionFollower, PassesOverRepeatsAndWhatIsOlder) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(4, "hand", two_joints));
  follower.see(solution(4, 5, {0.1, 0.2}));
  follower.take({});
  follower.see(solution(4, 5, {0.9, 0.9}));
  follower.see(solution(4, 3, {0.9, 0.9}));
  EXPECT_FALSE(follower.take({}));
}

TEST(SolutionFollower, AcceptsAServerThatCountsFromOneAgain) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(4, "hand", two_joints));
  follower.see(solution(4, 50, {0.1, 0.2}));
  follower.take({});
  v1::PoseSolution anew = solution(4, 1, {0.3, 0.4});
  anew.stamp_ns(1'000'000);
  follower.see(anew);
  ASSERT_TRUE(follower.take({}));
}

TEST(SolutionFollower, PassesOverPosesThatAreNotFinalUnlessAsked) {
  SolutionFollower finals({}, false), all({}, true);
  for (SolutionFollower* follower : {&finals, &all}) {
    follower->see(sessionState(4, "hand", two_joints));
    follower->see(solution(4, 1, {0.1, 0.2}, false));
  }
  EXPECT_FALSE(finals.take({}));
  EXPECT_TRUE(all.take({}));
}

TEST(SolutionFollower, FollowsTheSessionThatBeganToStreamLast) {
  SolutionFollower follower({}, false);
  for (const std::uint64_t id : {3u, 9u, 5u})
    follower.see(sessionState(id, "hand", two_joints));
  follower.see(solution(3, 1, {0, 0}));
  EXPECT_EQ(follower.take({})->session_id, 3u);
  follower.see(solution(9, 1, {0, 0}));
  EXPECT_EQ(follower.take({})->session_id, 9u);
  follower.see(solution(5, 1, {0, 0}));  // its stream began before
  follower.see(solution(3, 2, {0, 0}));
  EXPECT_FALSE(follower.take({}));
  EXPECT_EQ(follower.session(), 9u);
}

TEST(SolutionFollower, FollowsOnlyTheSessionGiven) {
  SolutionFollower follower(3, false);
  follower.see(sessionState(3, "hand", two_joints));
  follower.see(sessionState(9, "hand", two_joints));
  follower.see(solution(9, 1, {0, 0}));
  EXPECT_FALSE(follower.take({}));
  follower.see(solution(3, 1, {0, 0}));
  EXPECT_EQ(follower.take({})->session_id, 3u);
}

TEST(SolutionFollower, TurnsToAnotherSessionWhenItsOwnIsClosed) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(3, "hand", two_joints));
  follower.see(sessionState(9, "hand", two_joints));
  follower.see(solution(3, 1, {0, 0}));
  follower.see(solution(9, 1, {0, 0}));
  EXPECT_EQ(follower.take({})->session_id, 9u);
  follower.see(sessionState(9, "hand", two_joints, v1::PHASE_CLOSED));
  EXPECT_FALSE(follower.take({}));
  follower.see(solution(3, 2, {0, 0}));
  EXPECT_EQ(follower.take({})->session_id, 3u);
}

TEST(SolutionFollower, TakesTheLastPoseOfASessionThatClosesRightAfterIt) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(3, "hand", two_joints, v1::PHASE_OPTIMIZING));
  follower.see(solution(3, 1, {0, 0}));
  follower.see(sessionState(3, "hand", two_joints, v1::PHASE_CLOSED));
  EXPECT_TRUE(follower.take({}));
}

TEST(SolutionFollower, LeavesSessionsAloneThatWereClosedBeforeItCame) {
  SolutionFollower follower({}, false);
  follower.see(solution(3, 8, {0, 0}));
  follower.see(sessionState(3, "hand", two_joints, v1::PHASE_CLOSED));
  EXPECT_FALSE(follower.take({}));
  EXPECT_EQ(follower.session(), 0u);
}

TEST(SolutionFollower, TakesOldPosesForNewsAfterForgetting) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(3, "hand", two_joints));
  follower.see(solution(3, 1, {0, 0}));
  follower.take({});
  follower.forget();
  EXPECT_EQ(follower.session(), 0u);
  follower.see(sessionState(3, "hand", two_joints));
  follower.see(solution(3, 1, {0, 0}));
  EXPECT_TRUE(follower.take({}));
}

/// A server that was started again opens what it kept in any order: another object's pose is
/// not what the next ARM shall move to.
TEST(SolutionFollower, ComesBackToItsOwnSessionAfterAGap) {
  SolutionFollower follower({}, false);
  const auto stream = [&](std::uint64_t id, std::int64_t stamp_ns) {
    follower.see(sessionState(id, "hand", two_joints));
    v1::PoseSolution pose = solution(id, 1, {0.1, 0.2});
    pose.stamp_ns(stamp_ns);
    follower.see(pose);
    return follower.take({});
  };
  stream(3, 100);
  stream(5, 200);
  ASSERT_EQ(follower.session(), 5u);
  follower.forget();
  EXPECT_FALSE(stream(3, 1'000)) << "an older one that comes first";
  EXPECT_TRUE(stream(5, 1'100));
  EXPECT_FALSE(stream(3, 1'200)) << "and one that comes last";
  EXPECT_EQ(follower.session(), 5u);
  EXPECT_TRUE(stream(7, 1'300)) << "a new one takes over as ever";
  EXPECT_FALSE(stream(3, 1'400));
  v1::SessionState closed = sessionState(7, "hand", two_joints);
  closed.phase(v1::PHASE_CLOSED);
  follower.see(closed);
  EXPECT_TRUE(stream(3, 1'500)) << "once that one is closed";
}

// A server out of whose store sessions come streams them, and nobody has asked for that.
TEST(SolutionFollower, PassesOverWhatAStoreKept) {
  constexpr std::int64_t kLongAfter = 3'600'000'000'000;
  SolutionFollower any({}, false);
  any.see(sessionState(4, "hand", two_joints));
  v1::PoseSolution kept = solution(4, 1, {0.1, 0.2});
  kept.stamp_ns(1'000'000'000);
  any.see(kept, kLongAfter);
  EXPECT_FALSE(any.take({}));
  EXPECT_EQ(any.takeKept(), 4u);
  EXPECT_FALSE(any.takeKept()) << "told once";
  v1::PoseSolution edited = solution(4, 2, {0.3, 0.4});
  edited.stamp_ns(kLongAfter + 1);
  any.see(edited, kLongAfter + 2);
  EXPECT_EQ(any.take({})->sequence_number, 2u);

  SolutionFollower named(4, false);
  named.see(sessionState(4, "hand", two_joints));
  named.see(kept, kLongAfter);
  EXPECT_FALSE(named.takeKept());
  EXPECT_EQ(named.take({})->stamp_ns, kLongAfter);
}

// Whoever was followed has gone; where they were last is nobody's wish.
TEST(SolutionFollower, PassesOverWhereADemonstratorWasASecondAgo) {
  constexpr std::int64_t kWritten = 5'000'000'000;
  v1::PoseSolution live = solution(4, 1, {0.1, 0.2});
  live.stamp_ns(kWritten);
  live.time_s({0.5});
  for (const std::optional<std::uint64_t> only : {std::optional<std::uint64_t>(), {4}}) {
    SolutionFollower follower(only, false);
    follower.see(sessionState(4, "hand", two_joints));
    follower.see(live, kWritten);
    EXPECT_FALSE(follower.take({})) << "how old it is, is not known yet";
    EXPECT_FALSE(follower.take(kWritten + 1'100'000'000));
    EXPECT_EQ(follower.takeLeft(), 4u);
    EXPECT_FALSE(follower.takeLeft()) << "told once";
    v1::PoseSolution next = live;
    next.sequence_number(2);
    next.stamp_ns(kWritten + 2'000'000'000);
    follower.see(next, kWritten + 2'000'000'000);
    const auto pose = follower.take(kWritten + 2'100'000'000);
    ASSERT_TRUE(pose);
    EXPECT_TRUE(pose->is_live);
    v1::PoseSolution edited = solution(4, 3, {0.3, 0.4});
    edited.stamp_ns(kWritten + 3'000'000'000);
    follower.see(edited, kWritten + 3'000'000'000);
    EXPECT_EQ(follower.take(kWritten + 90'000'000'000)->sequence_number, 3u)
        << "an edit's stands";
  }
}

// A session that is being played is the one meant, though another's pose came after its own.
TEST(SolutionFollower, FollowsWhatBeginsToBePlayed) {
  constexpr std::int64_t kBegin = 60'000'000'000;
  SolutionFollower follower({}, false);
  for (const std::uint64_t id : {4, 5}) {
    follower.see(sessionState(id, "hand", two_joints));
    follower.see(solution(id, 1, {0.1, 0.2}));
  }
  EXPECT_EQ(follower.take({})->session_id, 5u);
  EXPECT_NE(follower.hear(4, kBegin), nullptr);
  EXPECT_EQ(follower.session(), 4u);
  EXPECT_NE(follower.hear(4, kBegin + 500'000'000), nullptr);
  EXPECT_NE(follower.hear(5, kBegin + 600'000'000), nullptr);
  EXPECT_EQ(follower.hear(4, kBegin + 700'000'000), nullptr) << "5 began last";
}

// Whoever is followed anew means it, though another session began to stream in between.
TEST(SolutionFollower, ComesBackToASessionWhoseDemonstratorComesBack) {
  SolutionFollower follower({}, false);
  for (const std::uint64_t id : {4, 5})
    follower.see(sessionState(id, "hand", two_joints));
  std::uint64_t number = 0;
  const auto live = [&](std::uint64_t id, std::int64_t at_ns) {
    v1::PoseSolution answer = solution(id, ++number, {0.1, 0.2});
    answer.stamp_ns(at_ns);
    answer.time_s({1e-9 * static_cast<double>(at_ns)});
    follower.see(answer, at_ns);
    const auto taken = follower.take(at_ns);
    return taken ? taken->session_id : 0;
  };
  constexpr std::int64_t kSecond = 1'000'000'000;
  EXPECT_EQ(live(4, 10 * kSecond), 4u);
  EXPECT_EQ(live(5, 12 * kSecond), 5u);
  EXPECT_EQ(live(4, 14 * kSecond), 4u) << "after a silence";
  EXPECT_EQ(live(5, 14 * kSecond + 1), 5u) << "likewise";
  EXPECT_EQ(live(4, 14 * kSecond + 2), 0u) << "both go on, and 5 began last";
  EXPECT_EQ(follower.takeBeside(), 4u);
  EXPECT_FALSE(follower.takeBeside());
}

TEST(SolutionFollower, GoesOnWithItsOwnSessionOutOfAStore) {
  constexpr std::int64_t kLongAfter = 3'600'000'000'000;
  SolutionFollower follower({}, false);
  for (const std::uint64_t id : {4, 5}) {
    follower.see(sessionState(id, "hand", two_joints));
    v1::PoseSolution pose = solution(id, 1, {0.1, 0.2});
    pose.stamp_ns(static_cast<std::int64_t>(10 - id));  // 4 began last
    follower.see(pose);
  }
  EXPECT_EQ(follower.take({})->session_id, 4u);
  follower.forget();
  for (const std::uint64_t id : {5, 4}) {
    follower.see(sessionState(id, "hand", two_joints));
    v1::PoseSolution kept = solution(id, 7, {0.1, 0.2});
    kept.stamp_ns(static_cast<std::int64_t>(10 - id));
    follower.see(kept, kLongAfter);
  }
  EXPECT_EQ(follower.take({})->session_id, 4u);
  EXPECT_FALSE(follower.take({}));
}

TEST(SolutionFollower, IgnoresTheNumberThatMeansNoSession) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(0, "hand", two_joints));
  follower.see(solution(0, 1, {0, 0}));
  EXPECT_FALSE(follower.take({}));
}

TEST(SolutionFollower, KeepsItsSessionThroughAFloodOfOthers) {
  SolutionFollower follower({}, false);
  follower.see(sessionState(1'000'000, "hand", two_joints));
  follower.see(solution(1'000'000, 1, {0, 0}));
  ASSERT_TRUE(follower.take({}));
  for (std::uint64_t id = 1; id < 2000; ++id)
    follower.see(sessionState(id, "hand", two_joints));
  follower.see(solution(1'000'000, 2, {0.5, 0.5}));
  const auto pose = follower.take({});
  ASSERT_TRUE(pose) << "its state was thrown out";
  EXPECT_EQ(pose->session_id, 1'000'000u);
}

}  // namespace
}  // namespace handgraft::bridge
