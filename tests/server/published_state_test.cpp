// What is told of a session, when, and what is locked meanwhile.
#include "server/sessions/published_state.h"

#include <future>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

PublishedState::Change message(const std::string& text) {
  return [text](v1::SessionState& state) {
    state.message(text);
  };
}

PublishedState::Change phase(v1::SessionPhase phase) {
  return [phase](v1::SessionState& state) {
    state.phase(phase);
  };
}

class PublishedStateTest : public testing::Test {
 protected:
  std::vector<std::string> told;
  PublishedState::Clock::time_point now{std::chrono::hours(1)};
  PublishedState state{[this](const v1::SessionState& one) {
                         told.push_back(one.message());
                       },
                       [this] {
                         return now;
                       }};
};

TEST_F(PublishedStateTest, TellsEachChangeOnce) {
  state.change(message("a"));
  state.change(message("a"));
  state.change(message("b"));
  EXPECT_THAT(told, ElementsAre("a", "b"));
}

TEST_F(PublishedStateTest, KeepsSilentChangesForTheNextThatIsTold) {
  state.change(message("a"), PublishedState::kSilently);
  EXPECT_TRUE(told.empty());
  EXPECT_EQ(state.get().message(), "a");
  state.change([](v1::SessionState&) {});
  EXPECT_THAT(told, ElementsAre("a"));
}

TEST_F(PublishedStateTest, TellsNoMoreOftenThanItIsAsked) {
  constexpr PublishPolicy kRarely{milliseconds(100)};
  state.change(message("a"), kRarely);
  now += milliseconds(99);
  state.change(message("b"), kRarely);
  now += milliseconds(1);
  state.change(message("c"), kRarely);
  EXPECT_THAT(told, ElementsAre("a", "c"));
}

TEST_F(PublishedStateTest, SaysNothingOnceItIsClosed) {
  state.change(phase(v1::PHASE_CLOSED));
  EXPECT_TRUE(state.isClosed());
  told.clear();
  state.change(message("late"));
  EXPECT_TRUE(told.empty());
  EXPECT_NE(state.get().message(), "late");
}

// Who is told may wait for others, who ask.
TEST(PublishedStates, AreNotLockedWhileTheyAreTold) {
  PublishedState* asked = nullptr;
  std::thread other;
  bool is_answered = false;
  PublishedState state(
      [&](const v1::SessionState&) {
        std::promise<void> answered;
        std::future<void> answer = answered.get_future();
        other = std::thread([&asked, answered = std::move(answered)]() mutable {
          static_cast<void>(asked->get());
          answered.set_value();
        });
        constexpr std::chrono::seconds kForEver(10);
        is_answered = answer.wait_for(kForEver) == std::future_status::ready;
      },
      PublishedState::Clock::now);
  asked = &state;
  state.change(message("a"));
  other.join();
  EXPECT_TRUE(is_answered) << "the lock is held while this is told";
}

TEST(PublishedStates, AreToldInTheOrderOfTheirChanges) {
  constexpr int kChanges = 200;
  std::vector<std::uint64_t> told;
  PublishedState state(
      [&](const v1::SessionState& one) {
        told.push_back(one.revision());
      },
      PublishedState::Clock::now);
  const auto count = [&] {
    for (int i = 0; i < kChanges; ++i) {
      state.change([](v1::SessionState& one) {
        one.revision(one.revision() + 1);
      });
    }
  };
  std::thread other(count);
  count();
  other.join();
  ASSERT_EQ(told.size(), 2u * kChanges);
  for (std::size_t i = 0; i < told.size(); ++i)
    EXPECT_EQ(told[i], i + 1);
}

}  // namespace
}  // namespace handgraft::server
