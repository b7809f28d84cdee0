#include "tests/system/nothing_lost.h"

#include <future>
#include <random>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/hardware.h"

// What clients were told is there after their server was killed, once; they go on by
// themselves.

namespace handgraft::test {
namespace {

using idl::cyclone::Reader;

/// The newest final pose that a session streams to who joins now.
v1::PoseSolution poseOf(const Participant& participant, std::uint64_t session) {
  Reader<v1::PoseSolution> solutions(participant, idl::kSolutionTopic);
  v1::PoseSolution newest;
  for (const auto end = Clock::now() + kLong; Clock::now() < end;) {
    solutions.take([&](const v1::PoseSolution& one) {
      if (one.session_id() == session && one.is_final()) newest = one;
    });
    if (newest.session_id() != 0 && newest.is_diagnosed()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return newest;
}

TEST_F(NothingLost, ASessionIsTheSameAfterItsServerWasKilled) {
  Editor editor(service->network());
  editor.edit(0.5);
  editor.edit(0.75);
  const v1::PoseSolution before = poseOf(editor.participant, editor.session);
  ASSERT_EQ(before.revision(), 2u);
  restart();
  // Nobody asks for it: it was in use when its server died.
  const v1::PoseSolution after = [&] {
    const Participant late(service->network());
    return poseOf(late, editor.session);
  }();
  EXPECT_EQ(after.revision(), 2u);
  EXPECT_EQ(after.joint_positions(), before.joint_positions());
  EXPECT_EQ(after.X_WH().p_m(), before.X_WH().p_m());
  EXPECT_EQ(after.X_WH().q_wxyz(), before.X_WH().q_wxyz());
  EXPECT_GT(after.sequence_number(), before.sequence_number());

  const v1::SessionSettings settings = editor.settings();
  EXPECT_EQ(settings.state().revision(), 2u);
  EXPECT_EQ(settings.undo().size(), 2u);
  v1::EditBody body;
  body.steps(v1::StepsEdit());
  body._d(v1::EDIT_UNDO);
  EXPECT_EQ(editor.requester.edit(editor.session, 2, body).revision(), 3u);
  EXPECT_EQ(editor.settings().patches().front().weight(), 0.5);
}

TEST_F(NothingLost, ClosingDeletesForGood) {
  Editor editor(service->network());
  editor.edit(0.5);
  editor.requester.ask(ofSession(v1::OP_CLOSE_SESSION, editor.session));
  restart();
  EXPECT_THROW(editor.settings(), Refused);
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(v1::OP_LIST_SESSIONS);
  EXPECT_TRUE(editor.requester.ask(body).sessions().sessions().empty());
}

TEST_F(NothingLost, AServerThatIsStoppedIsAwaitedAndGoesOn) {
  Editor editor(service->network());
  editor.edit(0.5);
  running->send(SIGTERM);
  EXPECT_EQ(running->wait(), 0);
  auto outcome = std::async(std::launch::async, [&] {
    return editor.edit(0.75);
  });
  startServer();
  EXPECT_EQ(outcome.get().revision(), 2u);
  EXPECT_EQ(editor.settings().patches().front().weight(), 0.75);
}

TEST_F(NothingLost, EveryAcknowledgedEditIsThereOnceHoweverOftenItsServerIsKilled) {
  const int kills = countOf("HANDGRAFT_KILLS", 8);
  Editor editor(service->network());
  std::atomic<bool> stops{false};
  std::atomic<std::uint64_t> acknowledged{0};
  std::uint64_t refused = 0;
  std::vector<std::uint64_t> revisions;
  double last = 0.0;
  std::thread hand([&] {
    for (int i = 0; !stops; ++i) {
      const double weight = 0.1 + 0.001 * (i % 800);
      try {
        revisions.push_back(editor.edit(weight).revision());
        last = weight;
        ++acknowledged;
      } catch (const std::exception& error) {
        ++refused;
        ADD_FAILURE() << "edit " << i << ": " << error.what();
      }
    }
  });
  std::mt19937 chance(20);
  std::vector<double> seconds;
  for (int i = 0; i < kills; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + chance() % 400));
    killServer();
    const std::uint64_t before = acknowledged;
    startServer();
    const Clock::time_point begin = Clock::now();
    // The one that was answered just before the end may be counted after it.
    while (acknowledged < before + 2 && Clock::now() - begin < kLong)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  }
  stops = true;
  hand.join();
  const v1::SessionSettings settings = editor.settings();
  std::uint64_t twice = 0;
  std::uint64_t out_of_order = 0;
  for (std::size_t i = 1; i < revisions.size(); ++i) {
    if (revisions[i] == revisions[i - 1]) ++twice;
    if (revisions[i] != revisions[i - 1] + 1) ++out_of_order;
  }
  const auto lost = static_cast<std::int64_t>(acknowledged.load()) -
                    static_cast<std::int64_t>(settings.state().revision());
  std::printf(
      "kills %d, edits acknowledged %llu, refused %llu, lost %lld, out of order %llu, "
      "goes on after p50 %.2f s, p95 %.2f s, max %.2f s\n",
      kills, static_cast<unsigned long long>(acknowledged.load()),
      static_cast<unsigned long long>(refused), static_cast<long long>(lost),
      static_cast<unsigned long long>(out_of_order), percentile(seconds, 0.5),
      percentile(seconds, 0.95), percentile(seconds, 1.0));
  EXPECT_EQ(lost, 0) << "edits that were acknowledged, less those that are there";
  EXPECT_EQ(out_of_order, 0u);
  EXPECT_EQ(settings.patches().front().weight(), last);
  killServer();
  const Finished check = checkOf(folder / "state");
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

TEST_F(NothingLost, ABridgeMovesByNoPoseOfARestartedServerUnlessItIsArmed) {
  Editor editor(service->network());
  Reader<v1::JointState> states(editor.participant, idl::kJointStateTopic);
  const auto bridge = service->start("handgraft-bridge", {});
  bool is_armed = false;
  const auto look = [&] {
    states.take([&](const v1::JointState& state) {
      is_armed = state.state() == v1::BridgeState::BRIDGE_ARMED;
    });
  };
  for (const auto end = Clock::now() + kLong; !is_armed && Clock::now() < end; look()) {
    editor.edit(0.5);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_TRUE(is_armed) << bridge->err();
  restart();
  ASSERT_TRUE(bridge->waitForText("ARM moves on")) << bridge->err();
  for (const auto end = Clock::now() + kLong; is_armed && Clock::now() < end; look())
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  for (int i = 0; i < 10; ++i) {
    editor.edit(0.3 + 0.1 * (i % 2));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    look();
    EXPECT_FALSE(is_armed) << "armed itself: " << bridge->err();
  }
}

// === Disks that fail

TEST_F(FailingDisk, RefusesPlainlyAndLosesNothing) {
  Editor editor(service->network());
  const int edits = countOf("HANDGRAFT_EDITS", 200);
  fail(40, 'r');
  std::uint64_t acknowledged = 0;
  std::uint64_t refused = 0;
  double last = 0.0;
  for (int i = 0; i < edits; ++i) {
    const double weight = 0.1 + 0.001 * (i % 800);
    if (const std::uint64_t revision = tryEdit(editor, weight); revision != 0) {
      EXPECT_EQ(revision, ++acknowledged) << "what was refused was not done";
      last = weight;
    } else {
      ++refused;
    }
  }
  std::printf("on a disk that fails: %llu edits acknowledged, %llu refused\n",
              static_cast<unsigned long long>(acknowledged),
              static_cast<unsigned long long>(refused));
  EXPECT_GT(refused, 0u) << "nothing failed";
  EXPECT_GT(acknowledged, 0u);
  EXPECT_TRUE(running->running());
  restart();  // on a sound disk, as killed on the other
  const v1::SessionSettings settings = editor.settings();
  EXPECT_EQ(settings.state().revision(), acknowledged);
  EXPECT_EQ(settings.patches().front().weight(), last);
  killServer();
  const Finished check = checkOf(folder / "state");
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

TEST_F(FailingDisk, GoesOnOnceAFullOneHasRoomAgain) {
  Editor editor(service->network());
  EXPECT_EQ(tryEdit(editor, 0.5), 1u);
  for (const char how : {'f', 'o'}) {
    fail(255, how);
    EXPECT_EQ(tryEdit(editor, 0.75), 0u);
    EXPECT_THROW(editor.requester.ask(openSession("clamp", "fruit", "marks")), Refused);
    EXPECT_THROW(editor.requester.ask(ofSession(v1::OP_CLOSE_SESSION, editor.session)),
                 Refused);
    EXPECT_EQ(editor.settings().state().revision(), 1u) << "what is there is answered";
    fail(0, how);
  }
  EXPECT_EQ(tryEdit(editor, 0.75), 2u);
  restart();  // DDS offers it anew what was refused; that was answered, and is not done now
  EXPECT_EQ(editor.settings().state().revision(), 2u);
  EXPECT_EQ(editor.settings().patches().front().weight(), 0.75);
}

TEST_F(NothingLost, IsBackedUpWhileItRunsAndGoesOnFromThere) {
  Editor editor(service->network());
  editor.edit(0.5);
  fs::create_directories(folder / "copy");
  const std::string file = "domain-" + std::to_string(service->domain()) + ".db";
  const Finished backup =
      run(program("handgraft-server"),
          {"--backup", (folder / "copy" / file).string(), "--state",
           (folder / "state").string(), "--domain", std::to_string(service->domain())});
  ASSERT_EQ(backup.exit_code, 0) << backup.err;
  EXPECT_EQ(checkOf(folder / "copy").exit_code, 0);
  editor.edit(0.75);
  killServer();
  fs::remove_all(folder / "state");
  fs::rename(folder / "copy", folder / "state");
  startServer();
  const v1::SessionSettings settings = editor.settings();
  EXPECT_EQ(settings.state().revision(), 1u);
  EXPECT_EQ(settings.patches().front().weight(), 0.5);
}

// === Much of it

TEST_F(NothingLost, ManySessionsKeepNoServerFromStarting) {
  const int sessions = countOf("HANDGRAFT_SESSIONS", 120);
  Editor editor(service->network());
  for (int i = 1; i < sessions; ++i)
    editor.requester.ask(openSession("clamp", "fruit", "marks"));
  killServer();
  const Clock::time_point begin = Clock::now();
  startServer();
  ASSERT_TRUE(running->waitForText("event=ready"));
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  std::printf("%d sessions: ready after %.2f s\n", sessions, seconds);
  EXPECT_THAT(running->err(), testing::HasSubstr("sessions=" + std::to_string(sessions)));
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(v1::OP_LIST_SESSIONS);
  EXPECT_EQ(editor.requester.ask(body).sessions().sessions().size(),
            static_cast<std::size_t>(sessions));
  EXPECT_EQ(editor.edit(0.5).revision(), 1u);
}

TEST_F(NothingLost, ASecondServerOnTheSameStateIsRefusedPlainly) {
  const auto second = service->start("handgraft-server", arguments());
  EXPECT_EQ(second->wait(), 2);
  EXPECT_THAT(second->err(), testing::HasSubstr("another handgraft-server has it open"));
}

}  // namespace
}  // namespace handgraft::test
