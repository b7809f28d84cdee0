#include "client/link/client.h"

#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/link/following.h"
#include "client/link/session.h"
#include "core/base/error.h"

#include "tests/client/fake_server.h"
#include "tests/support/test_domain.h"

namespace handgraft::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// A server that holds back what a test tells it to, and stops it when a client asks for that.
/// It answers descriptions of hands with their names.
class HoldingServer {
 public:
  bool operator()(const v1::Request& request, v1::Reply& reply) {
    const std::lock_guard lock(mutex_);
    const v1::Operation operation = request.body()._d();
    if (operation == v1::OP_CANCEL) {
      stopped_.insert(request.body().cancel().request_id());
    } else if (stopped_.count(request.request_id()) != 0) {
      reply.error(v1::ERROR_CANCELLED);
      reply.message("cancelled");
      return true;
    } else if (operation == v1::OP_DESCRIBE_MODEL) {
      const std::string& name = request.body().describe_model().model().name();
      if (held_.count(name) != 0) return false;
      if (name == "glove") {
        reply.error(v1::ERROR_NOT_FOUND);
        reply.message("no hand 'glove'");
        return true;
      }
      v1::HandDescription hand;
      hand.name(name);
      v1::ModelDescription description;
      description.hand(hand);
      reply.body().model(description);
    }
    reply.body()._d(operation);
    return true;
  }

  void hold(const std::string& name) {
    const std::lock_guard lock(mutex_);
    held_.insert(name);
  }

  void release(const std::string& name) {
    const std::lock_guard lock(mutex_);
    held_.erase(name);
  }

 private:
  std::mutex mutex_;
  std::set<std::string> held_;
  std::set<std::uint64_t> stopped_;
};

class ClientTest : public testing::Test {
 protected:
  ClientTest()
      : network{domain.number(), "lo"},
        server(network, [this](const v1::Request& request, v1::Reply& reply) {
          return script(request, reply);
        }) {}

  [[nodiscard]] ClientOptions options() const {
    ClientOptions options;
    options.network = network;
    return options;
  }

  test::TestDomain domain;
  Network network;
  HoldingServer script;
  test::FakeServer server;
};

Pending<v1::ModelDescription> askFor(Client& client, const std::string& hand) {
  return client.describe(v1::MODEL_HAND, hand, false);
}

TEST_F(ClientTest, AnswersSeveralCallsInWhateverOrderTheServerDoes) {
  Client client(options());
  script.hold("first");
  auto first = askFor(client, "first");
  auto second = askFor(client, "second");

  EXPECT_EQ(second.get().hand().name(), "second");
  EXPECT_FALSE(first.ready());
  script.release("first");
  EXPECT_EQ(first.get().hand().name(), "first");
}

TEST_F(ClientTest, GivesEachOfAHundredCallsItsOwnAnswer) {
  Client client(options());
  std::vector<Pending<v1::ModelDescription>> calls;
  for (int i = 0; i < 100; ++i)
    calls.push_back(askFor(client, "hand" + std::to_string(i)));
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(calls[static_cast<std::size_t>(i)].get().hand().name(),
              "hand" + std::to_string(i));
  }
}

TEST_F(ClientTest, KeepsToWhatTheServerRemembersWhileACallIsUnanswered) {
  // The server forgets the answers but the last 64 of a client, and never begins what is older.
  Client client(options());
  script.hold("first");
  auto first = askFor(client, "first");
  std::vector<Pending<v1::ModelDescription>> calls;
  for (int i = 0; i < 100; ++i)
    calls.push_back(askFor(client, "hand" + std::to_string(i)));
  EXPECT_FALSE(calls.back().waitFor(milliseconds(300)));
  EXPECT_LT(server.operations().size(), 64u);

  script.release("first");
  EXPECT_EQ(first.get().hand().name(), "first");
  for (auto& call : calls)
    call.get();
  EXPECT_EQ(server.operations().size(), 101u);
}

TEST_F(ClientTest, TellsACallbackOnceAndWithTheError) {
  Client client(options());
  std::promise<std::string> told;
  askFor(client, "glove").then([&](Outcome<v1::ModelDescription> outcome) {
    try {
      std::rethrow_exception(std::get<std::exception_ptr>(outcome));
    } catch (const Refused& refused) {
      told.set_value(refused.what());  // a second time would throw
    }
  });
  EXPECT_EQ(told.get_future().get(), "no hand 'glove'");
}

TEST_F(ClientTest, BeginsFurtherCallsFromACallback) {
  Client client(options());
  std::promise<std::string> told;
  askFor(client, "one").then([&](Outcome<v1::ModelDescription>) {
    askFor(client, "two").then([&](Outcome<v1::ModelDescription> outcome) {
      told.set_value(std::get<v1::ModelDescription>(outcome).hand().name());
    });
  });
  EXPECT_EQ(told.get_future().get(), "two");
}

TEST_F(ClientTest, CancelsOneCallAndNoOther) {
  Client client(options());
  script.hold("first");
  script.hold("second");
  auto first = askFor(client, "first");
  auto second = askFor(client, "second");
  first.cancel();

  EXPECT_THROW(first.get(), Cancelled);
  EXPECT_FALSE(second.ready());
  script.release("second");
  EXPECT_EQ(second.get().hand().name(), "second");
}

TEST_F(ClientTest, EndsAWaitByItsCheckpointOnceTheServerHasStopped) {
  struct Enough {};

  ClientOptions chosen = options();
  std::atomic<bool> enough{false};
  chosen.waiting.checkpoint = [&] {
    if (enough) throw Enough();
  };
  Client client(chosen);
  script.hold("first");
  auto first = askFor(client, "first");
  enough = true;
  EXPECT_THROW(first.get(), Enough);
  EXPECT_THAT(server.operations(), testing::Contains(v1::OP_CANCEL));
}

TEST_F(ClientTest, EndsWhatIsUnderWayWhenItGoes) {
  auto client = std::make_unique<Client>(options());
  script.hold("first");
  auto first = askFor(*client, "first");
  client.reset();
  EXPECT_THROW(first.get(), NoServer);
  first.cancel();  // of a client that is gone: nothing
}

TEST_F(ClientTest, HandsAnAnswerOutOnce) {
  Client client(options());
  auto first = askFor(client, "first");
  first.get();
  EXPECT_THROW(first.get(), BrokenContract);
}

/// A server that takes uploads, and loses all of them after so many steps of one.
class ForgetfulServer {
 public:
  using Files = std::map<std::string, std::string>;

  explicit ForgetfulServer(int steps) : steps_(steps) {}

  bool operator()(const v1::Request& request, v1::Reply& reply) {
    const std::lock_guard lock(mutex_);
    const v1::Operation operation = request.body()._d();
    reply.body().nothing(v1::Nothing());
    if (operation == v1::OP_PUT_FILE) {
      put(request.body().put_file(), reply);
    } else if (operation == v1::OP_LOAD_MODEL) {
      load(request.body().load_model(), reply);
    }
    if (++step_ == steps_) uploads_.clear();
    return true;
  }

  [[nodiscard]] std::vector<Files> loaded() const {
    const std::lock_guard lock(mutex_);
    return loaded_;
  }

 private:
  static void refuse(v1::Reply& reply) {
    reply.error(v1::ERROR_UPLOAD_GONE);
    reply.message("gone");
  }

  void put(const v1::PutFileRequest& chunk, v1::Reply& reply) {
    Files& files = uploads_[chunk.upload_id()];
    if (chunk.offset() == 0) files[chunk.uri()].clear();
    if (files.count(chunk.uri()) == 0) return refuse(reply);
    if (files[chunk.uri()].size() != chunk.offset()) return refuse(reply);
    files[chunk.uri()].append(chunk.bytes().begin(), chunk.bytes().end());
  }

  void load(const v1::LoadModelRequest& what, v1::Reply& reply) {
    if (uploads_.count(what.upload_id()) == 0) return refuse(reply);
    loaded_.push_back(uploads_[what.upload_id()]);
    v1::ModelSummary summary;
    summary.kind(what.kind());
    summary.name(what.name());
    v1::ModelList list;
    list.models().push_back(summary);
    reply.body().models(list);
    reply.body()._d(v1::OP_LOAD_MODEL);
  }

  const int steps_;
  mutable std::mutex mutex_;
  int step_ = 0;
  std::map<std::uint64_t, Files> uploads_;
  std::vector<Files> loaded_;
};

TEST(Upload, BeginsAnewWhereItsServerLostWhatWasSent) {
  constexpr std::size_t kTwoChunks = 600'000;
  const ForgetfulServer::Files files{{"hand.urdf", "<robot/>"},
                                     {"palm.stl", std::string(kTwoChunks, 'p')}};
  ModelFiles model;
  model.kind = v1::MODEL_HAND;
  model.name = "mitten";
  model.main_uri = "hand.urdf";
  for (const char* uri : {"hand.urdf", "palm.stl"}) {
    UploadFile file;
    file.uri = uri;
    file.text = files.at(uri);
    model.files.push_back(file);
  }
  // Three chunks, and a look at whether the first one is still there, before it is loaded.
  for (int steps = 1; steps <= 4; ++steps) {
    const test::TestDomain domain;
    const Network network{domain.number(), "lo"};
    ForgetfulServer script(steps);
    test::FakeServer server(network, [&script](const v1::Request& request, v1::Reply& reply) {
      return script(request, reply);
    });
    ClientOptions options;
    options.network = network;
    Client client(options);
    EXPECT_EQ(client.load(model).get().name(), "mitten") << "lost after step " << steps;
    const std::vector<ForgetfulServer::Files> loaded = script.loaded();
    ASSERT_EQ(loaded.size(), 1u) << "lost after step " << steps;
    EXPECT_EQ(loaded.front(), files) << "lost after step " << steps;
  }
}

TEST(ClientWithoutServer, SaysWhereItLooked) {
  const test::TestDomain domain;
  ClientOptions options;
  options.network = {domain.number(), "lo"};
  try {
    const Client client(options);
    FAIL() << "a server answered";
  } catch (const NoServer& error) {
    EXPECT_THAT(error.what(), HasSubstr("domain " + std::to_string(domain.number())));
  }
}

// === Streams

class FollowingTest : public ClientTest {
 protected:
  FollowingTest()
      : participant(network),
        states(participant, idl::kSessionTopic),
        solutions(participant, idl::kSolutionTopic) {}

  void publishState(std::uint64_t session, std::uint64_t revision, v1::SessionPhase phase) {
    v1::SessionState state;
    state.session_id(session);
    state.revision(revision);
    state.phase(phase);
    states.write(state);
  }

  void publishPose(std::uint64_t session, std::uint64_t revision, bool is_final) {
    v1::PoseSolution solution;
    solution.session_id(session);
    solution.revision(revision);
    solution.sequence_number(++sequence);
    solution.is_final(is_final);
    solution.X_WH().q_wxyz() = {1.0, 0.0, 0.0, 0.0};
    solution.X_WO().q_wxyz() = {1.0, 0.0, 0.0, 0.0};
    solutions.write(solution);
  }

  static v1::SessionState sessionOf(std::uint64_t id) {
    v1::SessionState state;
    state.session_id(id);
    state.phase(v1::PHASE_READY);
    return state;
  }

  idl::cyclone::Participant participant;
  idl::cyclone::Writer<v1::SessionState> states;
  idl::cyclone::Writer<v1::PoseSolution> solutions;
  std::uint64_t sequence = 0;
};

TEST_F(FollowingTest, TellsWhoComesLateTheLastPoseAndThenTheEnd) {
  Client client(options());
  publishPose(7, 3, true);
  publishPose(8, 1, true);  // of another session
  std::promise<std::uint64_t> pose;
  std::promise<bool> end;
  const Following following(client, 7,
                            {.on_solution =
                                 [&](const v1::PoseSolution& solution) {
                                   EXPECT_EQ(solution.session_id(), 7u);
                                   pose.set_value(solution.revision());
                                 },
                             .on_end =
                                 [&](std::exception_ptr error) {
                                   end.set_value(error == nullptr);
                                 }});
  EXPECT_EQ(pose.get_future().get(), 3u);
  publishState(7, 4, v1::PHASE_CLOSED);
  EXPECT_TRUE(end.get_future().get());
}

TEST_F(FollowingTest, WaitsForTheFinalPoseOfAnEdit) {
  Client client(options());
  Session session(client, sessionOf(7));
  publishPose(7, 1, true);
  publishPose(7, 2, false);
  publishPose(7, 2, true);
  const v1::PoseSolution* pose = session.awaitFinal(2);
  ASSERT_NE(pose, nullptr);
  EXPECT_EQ(pose->revision(), 2u);
  EXPECT_TRUE(pose->is_final());
}

TEST_F(FollowingTest, SaysThatASessionWasClosed) {
  Client client(options());
  Session session(client, sessionOf(7));
  publishState(7, 1, v1::PHASE_CLOSED);
  try {
    session.awaitFinal(5);
    FAIL() << "a pose came";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code(), v1::ERROR_NOT_FOUND);
    EXPECT_THAT(refused.what(), HasSubstr("closed"));
  }
}

}  // namespace
}  // namespace handgraft::client
