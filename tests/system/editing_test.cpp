// Several editors on one session, and what must not disturb them; real processes.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/fields.h"
#include "idl/service.h"

#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

using testing::HasSubstr;

v1::EditBody place(double z_m) {
  v1::Pose X_WO;
  X_WO.p_m({0.0, 0.0, z_m});
  X_WO.q_wxyz({1.0, 0.0, 0.0, 0.0});
  v1::EditBody body;
  body.X_WO(X_WO);
  return body;
}

v1::EditBody weightOf(const std::string& patch, double weight) {
  v1::PatchWeightEdit edit;
  edit.patch(patch);
  edit.weight(weight);
  v1::EditBody body;
  body.patch_weight(edit);
  return body;
}

v1::EditBody palmWeight(double weight) {
  return weightOf("palm", weight);
}

/// Another editor: a participant of its own, on a session that somebody opened.
class Editor {
 public:
  Editor(const Service& service, std::uint64_t session)
      : participant_(service.network()), requester_(participant_), session_(session) {}

  v1::EditReply edit(const v1::EditBody& body, std::uint64_t base_revision = 0) {
    try {
      return requester_.edit(session_, base_revision, body);
    } catch (const idl::cyclone::Refused& refused) {
      v1::EditReply reply;
      reply.error(refused.code());
      reply.message(refused.what());
      return reply;
    }
  }

  v1::ReplyBody ask(const v1::RequestBody& body) { return requester_.ask(body); }

 private:
  idl::cyclone::Participant participant_;
  idl::cyclone::Requester requester_;
  std::uint64_t session_;
};

/// Follows the states of a session without touching it.
class Watcher {
 public:
  Watcher(const Service& service, std::uint64_t session)
      : session_(session),
        participant_(service.network()),
        states_(participant_, idl::kSessionTopic, [this] {
          take();
        }) {}

  /// Distinct revisions in the order of arrival, waited for until `last` is among them.
  std::vector<std::uint64_t> revisionsUntil(std::uint64_t last) {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, std::chrono::seconds(60), [&] {
      return !revisions_.empty() && revisions_.back() >= last;
    });
    return revisions_;
  }

  /// Waits until a state `fits`; nothing after a minute.
  std::optional<v1::SessionState> await(
      const std::function<bool(const v1::SessionState&)>& fits) {
    std::unique_lock lock(mutex_);
    std::optional<v1::SessionState> found;
    news_.wait_for(lock, std::chrono::seconds(60), [&] {
      const auto at = std::find_if(all_.begin(), all_.end(), fits);
      if (at != all_.end()) found = *at;
      return found.has_value();
    });
    return found;
  }

 private:
  void take() {
    states_.take([this](const v1::SessionState& state) {
      if (state.session_id() != session_) return;
      const std::lock_guard lock(mutex_);
      all_.push_back(state);
      if (revisions_.empty() || revisions_.back() != state.revision())
        revisions_.push_back(state.revision());
    });
    news_.notify_all();
  }

  std::uint64_t session_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::vector<std::uint64_t> revisions_;
  std::vector<v1::SessionState> all_;
  idl::cyclone::Participant participant_;
  // Its listener touches all of the above: made last, gone first.
  idl::cyclone::Reader<v1::SessionState> states_;
};

class Editing : public testing::Test {
 protected:
  Service service;
  LiveSession session{service, "barrett8", "lemon", "lemon_6"};
};

TEST_F(Editing, TwoEditorsAndAWatcherSeeTheSameRevisionsInOrder) {
  session.optimize();
  // One who only watches, and what the two editors see.
  Watcher watcher(service, session.id());
  Watcher of_a(service, session.id());
  Watcher of_b(service, session.id());
  for (Watcher* each : {&watcher, &of_a, &of_b})
    ASSERT_FALSE(each->revisionsUntil(0).empty());
  Editor a(service, session.id());
  Editor b(service, session.id());
  for (int i = 0; i < 10; ++i) {
    Editor& editor = i % 2 == 0 ? a : b;
    const v1::EditReply reply = editor.edit(palmWeight(1.0 + 0.1 * i));
    ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    EXPECT_EQ(reply.revision(), static_cast<std::uint64_t>(i) + 1);
  }
  for (Watcher* each : {&watcher, &of_a, &of_b}) {
    EXPECT_THAT(each->revisionsUntil(10),
                testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  }
}

TEST_F(Editing, TwoEditorsWhoHurryAndAWatcherSeeTheSameRevisionsInOrder) {
  session.optimize();
  Watcher watcher(service, session.id());
  Watcher of_a(service, session.id());
  Watcher of_b(service, session.id());
  for (Watcher* each : {&watcher, &of_a, &of_b})
    ASSERT_FALSE(each->revisionsUntil(0).empty());
  constexpr std::uint64_t kEach = 100;
  const auto work = [&](double first) {
    Editor editor(service, session.id());
    for (std::uint64_t i = 0; i < kEach; ++i) {
      const v1::EditReply reply =
          editor.edit(palmWeight(first + 0.01 * static_cast<double>(i)));
      EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    }
  };
  std::thread other([&] {
    work(1.0);
  });
  work(2.0);
  other.join();
  std::vector<std::uint64_t> all(2 * kEach + 1);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(watcher.revisionsUntil(2 * kEach), all);
  EXPECT_EQ(of_a.revisionsUntil(2 * kEach), all);
  EXPECT_EQ(of_b.revisionsUntil(2 * kEach), all);
}

TEST_F(Editing, StoppedByOneEditorKeepsTheEditAndTellsTheOther) {
  session.optimize();
  Watcher watcher(service, session.id());
  Editor a(service, session.id());
  Editor b(service, session.id());
  v1::SolveOptions slow;
  slow.solver(v1::SOLVER_ALL);
  slow.starts(10'000);
  v1::EditBody solving;
  solving.solving(slow);
  ASSERT_EQ(a.edit(solving).revision(), 1u);
  ASSERT_TRUE(watcher.await([](const v1::SessionState& state) {
    return state.phase() == v1::PHASE_OPTIMIZING && state.revision() == 1;
  }));
  v1::SessionKey key;
  key.session_id(session.id());
  v1::RequestBody stop;
  stop.session(key);
  stop._d(v1::OP_STOP_SOLVING);
  EXPECT_NO_THROW(b.ask(stop));
  const auto stopped = watcher.await([](const v1::SessionState& state) {
    return state.message() == "stopped";
  });
  ASSERT_TRUE(stopped.has_value());
  EXPECT_EQ(stopped->revision(), 1u);
  EXPECT_EQ(stopped->phase(), v1::PHASE_READY);
  v1::EditBody undo;
  undo.steps(v1::StepsEdit());
  undo._d(v1::EDIT_UNDO);
  EXPECT_EQ(b.edit(undo).revision(), 2u) << "the session goes on";
}

TEST_F(Editing, AStaleEditIsToldWhatTheOtherEditorDid) {
  session.optimize();
  Editor a(service, session.id());
  Editor b(service, session.id());
  ASSERT_EQ(a.edit(palmWeight(2.0), 0).revision(), 1u);
  const v1::EditReply stale = b.edit(place(0.1), 0);
  EXPECT_EQ(stale.error(), v1::ERROR_NONE) << "revision 0 means: whatever it is";
  const v1::EditReply late = a.edit(palmWeight(3.0), 1);
  EXPECT_EQ(late.error(), v1::ERROR_CONFLICT);
  EXPECT_THAT(late.message(), HasSubstr("place object"));
  EXPECT_THAT(late.message(), HasSubstr("by client"));
  EXPECT_EQ(a.edit(palmWeight(3.0), 2).revision(), 3u);
}

TEST_F(Editing, OutlivesItsClient) {
  // A client that opens, edits and is killed while its solve is on its way.
  const auto client = service.start(
      "handgraft", {"grasp", "--hand", "barrett8", "--object", "box", "--contacts", "box_5",
                    "--starts", "10000", "--solver", "all", "--keep"});
  const idl::cyclone::Participant participant(service.network());
  idl::cyclone::Reader<v1::SessionState> states(participant, idl::kSessionTopic);
  std::uint64_t theirs = 0;
  std::string told;  // what was heard instead
  for (int i = 0; i < 600 && theirs == 0; ++i) {
    states.wait(std::chrono::milliseconds(100));
    states.take([&](const v1::SessionState& state) {
      told += state.object() + " " + v1::nameOf(state.phase()) + "\n";
      if (state.object() == "box" && state.phase() == v1::PHASE_OPTIMIZING)
        theirs = state.session_id();
    });
  }
  ASSERT_NE(theirs, 0u) << told << client->err();
  client->send(SIGKILL);

  Editor heir(service, theirs);
  const v1::EditReply reply = heir.edit(weightOf("thumb", 2.0));
  EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  EXPECT_EQ(reply.revision(), 1u);
  // Others noticed nothing.
  EXPECT_EQ(session.optimize().outcome(), v1::OUTCOME_CONVERGED);
}

TEST_F(Editing, FloodOfOneSessionLeavesOthersAlone) {
  session.optimize();
  LiveSession calm(service, "barrett8", "lemon", "lemon_6");
  calm.optimize();
  const idl::cyclone::Participant wild(service.network());
  idl::cyclone::Writer<v1::Edit> edits(wild, idl::kEditTopic);
  for (int i = 0; i < 600 && edits.readers() == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_GT(edits.readers(), 0);
  std::atomic<bool> stop{false};
  std::thread flood([&] {
    v1::Edit edit;
    edit.client({0xF1, 0x00, 0xD0});
    edit.session_id(session.id());
    for (std::uint64_t id = 1; id <= 20'000 && !stop; ++id) {
      edit.edit_id(id);
      edit.body(palmWeight(1.0 + 1e-5 * static_cast<double>(id)));
      try {
        edits.write(edit);
      } catch (const idl::cyclone::WriteTimeout&) {
      }
    }
  });
  for (int i = 0; i < 10; ++i) {
    const v1::EditReply reply = calm.edit(palmWeight(1.0 + 0.1 * i));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    const auto solution = calm.solution([&](const v1::PoseSolution& one) {
      return one.is_final() && one.revision() >= reply.revision();
    });
    EXPECT_TRUE(solution.has_value());
  }
  stop = true;
  flood.join();
  EXPECT_TRUE(service.server().running());
  v1::EditReply after = session.edit(place(0.2));
  // Some of the flood may still wait.
  for (int i = 0; i < 600 && after.error() == v1::ERROR_OVERLOADED; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    after = session.edit(place(0.2));
  }
  ASSERT_EQ(after.error(), v1::ERROR_NONE) << after.message();
  EXPECT_TRUE(session.solution([&](const v1::PoseSolution& one) {
    return one.is_final() && one.revision() >= after.revision();
  }));
}

TEST_F(Editing, SlowReadersGetTheNewestPoseNotTheOldestOnes) {
  session.optimize();
  const idl::cyclone::Participant participant(service.network());
  idl::cyclone::Reader<v1::PoseSolution> slow(participant, idl::kSolutionTopic);
  ASSERT_TRUE(slow.wait(std::chrono::seconds(60)));
  std::uint64_t revision = 0;
  for (int i = 0; i < 20; ++i)
    revision = session.edit(palmWeight(1.0 + 0.1 * i)).revision();
  ASSERT_TRUE(session.solution([&](const v1::PoseSolution& one) {
    return one.is_final() && one.revision() == revision;
  }));
  // Until now nobody took anything from `slow`: one sample waits, the last.
  std::vector<std::uint64_t> seen;
  for (int i = 0; i < 600 && (seen.empty() || seen.back() < revision); ++i) {
    slow.wait(std::chrono::milliseconds(100));
    slow.take([&](const v1::PoseSolution& one) {
      if (one.session_id() == session.id()) seen.push_back(one.revision());
    });
  }
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back(), revision);
  EXPECT_LE(seen.size(), 2u) << "old poses were kept for a reader that was late";
}

TEST_F(Editing, IsUndoneByWhoeverAsks) {
  const v1::PoseSolution first = session.optimize();
  Editor other(service, session.id());
  ASSERT_EQ(session.edit(place(0.5)).revision(), 1u);
  v1::StepsEdit steps;
  v1::EditBody undo;
  undo.steps(steps);
  undo._d(v1::EDIT_UNDO);
  ASSERT_EQ(other.edit(undo).revision(), 2u);
  const auto undone = session.solution([](const v1::PoseSolution& one) {
    return one.is_final() && one.revision() == 2;
  });
  ASSERT_TRUE(undone.has_value());
  EXPECT_EQ(undone->joint_positions(), first.joint_positions());
  EXPECT_EQ(undone->X_WH(), first.X_WH());
}

}  // namespace
}  // namespace handgraft::test
