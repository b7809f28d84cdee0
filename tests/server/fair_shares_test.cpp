#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/sanitized.h"
#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

// What one client costs the others.

namespace handgraft::server {
namespace {

using testing::HasSubstr;

// Loading and opening count, too: half a second on a busy machine, seconds under sanitizers; as
// do solves, which would take some 4 s here.
constexpr std::chrono::seconds kForsaken(kIsSanitized ? 8 : 2);
constexpr std::chrono::milliseconds kBudget(kIsSanitized ? 10'000 : 1500);
constexpr const char* kBudgetText = kIsSanitized ? "after 10 s" : "after 1.5 s";

/// A server of one worker.
class FairShares : public testing::Test {
 protected:
  explicit FairShares(ServiceOptions options = {}) : service(bus, models, alone(options)) {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  static ServiceOptions alone(ServiceOptions options) {
    options.workers = 1;
    return options;
  }

  std::uint64_t open() {
    return bus.ask(test::openSession("clamp", "fruit", "marks")).body().session().session_id();
  }

  /// Would take hours.
  static v1::RequestBody longSolve(std::uint64_t session) {
    v1::RequestBody body = test::optimize(session, v1::SOLVER_ALL, 10'000);
    body.optimize().options().front().max_evaluations(100'000);
    return body;
  }

  v1::Reply awaitReply(std::uint64_t id) {
    return bus
        .await<v1::Reply>(bus.replies,
                          [&](const v1::Reply& one) {
                            return one.request_id() == id;
                          })
        .value_or(v1::Reply());
  }

  v1::ErrorCode edit(std::uint64_t id, std::uint64_t session, const v1::EditBody& body) {
    v1::Edit message;
    message.client({1});
    message.edit_id(id);
    message.session_id(session);
    message.body(body);
    bus.send(message);
    return bus
        .await<v1::EditReply>(bus.edit_replies,
                              [&](const v1::EditReply& one) {
                                return one.edit_id() == id;
                              })
        ->error();
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

class Forsaken : public FairShares {
 protected:
  static ServiceOptions options() {
    ServiceOptions options;
    options.forsaken = kForsaken;
    return options;
  }

  Forsaken() : FairShares(options()) {}
};

TEST_F(Forsaken, SolvesEndAndRepeatedOnesGoOn) {
  // One of them takes seconds; those of one session take turns.
  constexpr std::uint64_t kTurns = 12;
  const auto send = [&](std::uint64_t session, std::uint64_t first) {
    for (std::uint64_t id = first; id < first + kTurns; ++id)
      bus.send(id, longSolve(session));
  };
  const std::uint64_t session = open();
  const std::uint64_t kept = open();
  send(session, 1);
  constexpr std::uint64_t kLast = kTurns;
  const v1::Reply given_up = awaitReply(kLast);
  EXPECT_EQ(given_up.error(), v1::ERROR_CANCELLED);
  EXPECT_THAT(given_up.message(), HasSubstr("given up"));
  constexpr std::uint64_t kFirst = 100;
  constexpr std::uint64_t kLastKept = kFirst + kTurns - 1;
  constexpr std::chrono::milliseconds kPause(100);
  for (std::chrono::milliseconds gone(0); gone < 2 * kForsaken; gone += kPause) {
    send(kept, kFirst);
    std::this_thread::sleep_for(kPause);
  }
  for (const v1::Reply& one : bus.copyOf(bus.replies))
    EXPECT_NE(one.request_id(), kLastKept) << one.message();
  EXPECT_EQ(bus.ask(test::cancel(kLastKept)).error(), v1::ERROR_NONE);
}

class Budget : public FairShares {
 protected:
  static ServiceOptions options() {
    ServiceOptions options;
    options.budget = kBudget;  // looked at once a second
    return options;
  }

  Budget() : FairShares(options()) {}
};

TEST_F(Budget, EndsASolveThatWasAskedFor) {
  bus.send(1, longSolve(open()));
  const v1::Reply reply = awaitReply(1);
  EXPECT_EQ(reply.error(), v1::ERROR_OUT_OF_TIME) << reply.message();
  EXPECT_THAT(reply.message(), HasSubstr(kBudgetText));
}

TEST_F(Budget, MayBeLessByRequest) {
  v1::Request request;
  request.client({1});
  request.request_id(1);
  request.protocol_version(v1::PROTOCOL_VERSION);
  request.budget_s(0.1);
  request.body(longSolve(open()));
  bus.send(request);
  EXPECT_THAT(awaitReply(1).message(), HasSubstr("0.1 s"));
}

TEST_F(Budget, EndsASolveThatFollowsAnEdit) {
  const std::uint64_t session = open();
  v1::SolveOptions solving;
  solving.solver(v1::SOLVER_ALL);
  solving.starts(10'000);
  solving.max_evaluations(100'000);
  v1::EditBody body;
  body.solving(solving);
  ASSERT_EQ(edit(1, session, body), v1::ERROR_NONE);
  EXPECT_TRUE(bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& state) {
    return state.session_id() == session && state.revision() == 1 &&
           state.message() == "stopped";
  }));
}

class Reserves : public FairShares {
 protected:
  static ServiceOptions options() {
    ServiceOptions options;
    options.reserves = 3;
    return options;
  }

  Reserves() : FairShares(options()) {}
};

TEST_F(Reserves, AnswerEditsBesideTwoLongSolves) {
  const std::uint64_t mine = open();
  bus.send(1, longSolve(open()), 7);
  bus.send(2, longSolve(open()), 7);
  v1::PatchWeightEdit weight;
  weight.patch("palm");
  weight.weight(0.5);
  v1::EditBody body;
  body.patch_weight(weight);
  EXPECT_EQ(edit(1, mine, body), v1::ERROR_NONE);
  for (const v1::Reply& one : bus.copyOf(bus.replies))
    EXPECT_GT(one.request_id(), 2u) << "a long solve had ended: nothing was shown";
}

}  // namespace
}  // namespace handgraft::server
