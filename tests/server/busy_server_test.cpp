// What an edit's diagnosis waits for: one worker, which idle tasks never go to first.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/live_edits.h"

namespace handgraft::server {
namespace {

class BusyServer : public LiveEdits {
 protected:
  static ServiceOptions busy() {
    ServiceOptions options;
    options.workers = 1;
    options.patience = std::chrono::hours(1);
    return options;
  }

  BusyServer() : LiveEdits(busy()) {}

  /// Queues a solve that ends when somebody stops it.
  void occupy(std::uint64_t session) {
    bus.send(5000 + session, test::optimize(session, v1::SOLVER_ALL, 10'000));
  }

  void awaitOccupied(std::uint64_t session) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.session_id() == session &&
                                                     one.phase() == v1::PHASE_OPTIMIZING &&
                                                     one.progress() > 0.0;
                                            }))
        << "session " << session << " does not solve";
  }

  void stop(std::uint64_t session) {
    EXPECT_EQ(bus.ask(test::ofSession(v1::OP_STOP_SOLVING, session)).error(), v1::ERROR_NONE);
  }

  void awaitReady(std::uint64_t session, std::uint64_t revision) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.session_id() == session &&
                                                     one.revision() == revision &&
                                                     one.phase() == v1::PHASE_READY;
                                            }))
        << "session " << session << " is never ready at revision " << revision;
  }

  /// Edits `session` and lets the pose out; its diagnosis waits until `holder` is stopped.
  void holdDiagnosis(std::uint64_t session, std::uint64_t holder) {
    const std::uint64_t first = open();
    const std::uint64_t second = open();
    occupy(first);
    awaitOccupied(first);
    const v1::Edit edit = editOf(session, limit(-0.4));
    bus.send(edit);
    occupy(second);
    stop(first);
    EXPECT_EQ(replyTo(edit).revision(), 1u);
    awaitOccupied(second);
    occupy(holder);  // behind the solve
    stop(second);
    finalOf(session, 1);
    awaitOccupied(holder);
    EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
  }
};

TEST_F(BusyServer, DiagnosesPosesAfterWhatOtherSessionsHaveToDo) {
  const std::uint64_t mine = openSolved();
  const std::uint64_t yours = openSolved();
  const std::uint64_t holder = open();
  occupy(holder);
  awaitOccupied(holder);
  bus.send(editOf(mine, limit(-0.4)));
  bus.send(editOf(yours, limit(-0.4)));
  stop(holder);
  awaitReady(mine, 1);
  awaitReady(yours, 1);
  std::vector<std::pair<std::uint64_t, bool>> order;
  for (const v1::PoseSolution& one : finalsOf(bus, 1))
    order.emplace_back(one.session_id(), one.is_diagnosed());
  EXPECT_THAT(order, testing::ElementsAre(std::pair(mine, false), std::pair(yours, false),
                                          std::pair(mine, true), std::pair(yours, true)));
}

TEST_F(BusyServer, StopsDiagnosesThatWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  stop(session);
  stop(holder);
  awaitReady(session, 1);
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u) << "diagnosed, although somebody said stop";
  EXPECT_EQ(apply(session, limit(0.6)).revision(), 2u);
  awaitReady(session, 2);
  EXPECT_EQ(finalsOf(bus, 2).size(), 2u);
}

TEST_F(BusyServer, DoesNotDiagnosePosesThatAnEditOutdates) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  bus.send(editOf(session, limit(0.6)));
  stop(holder);
  awaitReady(session, 2);
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
  ASSERT_EQ(finalsOf(bus, 2).size(), 2u);
  EXPECT_TRUE(finalsOf(bus, 2).back().is_diagnosed());
}

TEST_F(BusyServer, DiagnosesPosesThatARefusedEditDoesNotOutdate) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  const std::size_t commands = bus.count(bus.commands);
  v1::EditBody wrong = limit(0.1);
  wrong.joint_limit().joint("no_such_joint");
  const v1::Edit edit = editOf(session, wrong);
  bus.send(edit);
  stop(holder);
  EXPECT_EQ(replyTo(edit).error(), v1::ERROR_INVALID_INPUT);
  awaitReady(session, 1);
  ASSERT_EQ(finalsOf(bus, 1).size(), 2u);
  EXPECT_TRUE(finalsOf(bus, 1).back().is_diagnosed());
  EXPECT_EQ(bus.count(bus.commands), commands) << "solved again";
}

TEST_F(BusyServer, ClosesSessionsWhoseDiagnosesWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  bus.send(77, test::ofSession(v1::OP_CLOSE_SESSION, session));
  stop(holder);
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& one) {
    return one.session_id() == session && one.phase() == v1::PHASE_CLOSED;
  }));
  service.stop();  // what waits is done
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
}

TEST_F(BusyServer, StopsWhileDiagnosesWait) {
  const std::uint64_t session = openSolved();
  const std::uint64_t holder = open();
  holdDiagnosis(session, holder);
  service.stop();
  EXPECT_EQ(finalsOf(bus, 1).size(), 1u);
}

}  // namespace
}  // namespace handgraft::server
