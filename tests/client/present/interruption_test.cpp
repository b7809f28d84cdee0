#include "client/present/interruption.h"

#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "client/present/interactive_client.h"
#include "core/base/error.h"

namespace handgraft::client {
namespace {

TEST(Interruption, IsAWishOnceASignalCame) {
  const Interruption interruption;
  EXPECT_FALSE(interruption.requested());
  EXPECT_NO_THROW(interruption.checkpoint());
  raise(SIGINT);
  EXPECT_TRUE(interruption.requested());
  EXPECT_FALSE(interruption.terminated());
  EXPECT_THROW(interruption.checkpoint(), Cancelled);
}

TEST(Interruption, ComesByItselfOnceTheTimeIsOver) {
  Interruption interruption;
  interruption.endAfter(std::chrono::hours(1));
  EXPECT_FALSE(interruption.requested());
  interruption.endAfter(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(interruption.requested());
  EXPECT_FALSE(interruption.terminated());
  EXPECT_THROW(interruption.checkpoint(), TransportError);
}

TEST(Interruption, CountsAgainAfterAReset) {
  Interruption interruption;
  for (int i = 0; i < 3; ++i) {
    raise(SIGINT);
    ASSERT_TRUE(interruption.requested());
    interruption.reset();
    EXPECT_NO_THROW(interruption.checkpoint());
  }
}

TEST(Interruption, NoResetTakesBackATermination) {
  Interruption interruption;
  raise(SIGTERM);
  interruption.reset();
  EXPECT_TRUE(interruption.terminated());
  EXPECT_THROW(interruption.checkpoint(), Cancelled);
}

TEST(Interruption, IsForgottenForWhatIsWrittenInTheEnd) {
  Interruption interruption;
  raise(SIGTERM);
  interruption.forget();
  EXPECT_NO_THROW(interruption.checkpoint());
  raise(SIGTERM);
  EXPECT_THROW(interruption.checkpoint(), Cancelled);
}

TEST(Interruption, KnowsNothingOfSignalsBeforeIt) {
  {
    const Interruption before;
    raise(SIGINT);
  }
  const Interruption interruption;
  EXPECT_FALSE(interruption.requested());
}

TEST(Interruption, LeavesTheHandlersAsTheyWere) {
  struct sigaction before {};

  sigaction(SIGINT, nullptr, &before);
  { const Interruption interruption; }

  struct sigaction after {};

  sigaction(SIGINT, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

TEST(Attended, EndsAWaitWhereASignalCame) {
  const Interruption interruption;
  const ClientOptions options = interactiveClient({}, Absence::kFail, interruption);
  EXPECT_NO_THROW(options.waiting.checkpoint());
  raise(SIGINT);
  EXPECT_THROW(options.waiting.checkpoint(), Cancelled);
}

}  // namespace
}  // namespace handgraft::client
