#include "server/admission/service.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random_id.h"

#include "tests/server/service_fixture.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;

v1::Edit weightEdit(std::uint64_t id, std::uint64_t session, double weight) {
  v1::PatchWeightEdit body;
  body.patch("palm");
  body.weight(weight);
  v1::Edit edit;
  edit.edit_id(id);
  edit.session_id(session);
  edit.body().patch_weight(body);
  return edit;
}

TEST_F(ServiceTest, AnswersARepeatFromMemory) {
  const auto upload = test::putFile(1, "a", "abc");
  bus.send(1, upload);
  const auto first = [](const v1::Reply& one) {
    return one.request_id() == 1;
  };
  ASSERT_EQ(bus.await<v1::Reply>(bus.replies, first)->error(), v1::ERROR_NONE);
  const std::size_t answered = bus.count(bus.replies);
  // Done twice, a chunk at offset 0 would begin the file again, and a bad one would be refused.
  bus.send(1, test::putFile(1, "a", ""));
  EXPECT_EQ(bus.count(bus.replies), answered + 1);
  EXPECT_EQ(bus.replies.back().error(), v1::ERROR_NONE);
  EXPECT_EQ(service.status().requests_answered(), 1u);
}

TEST_F(ServiceTest, GoesOnHoweverManySayThatTheyAreElderServers) {
  const std::uint64_t session = openSmallSession();
  v1::ServerStatus other = service.status();
  other.uptime_s(1e6);
  for (int i = 0; i < 1000; ++i) {
    other.server_id(other.server_id() + 1);
    bus.hear(other);
  }
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).error(), v1::ERROR_NONE);
  EXPECT_FALSE(service.status().stopping());
}

TEST_F(ServiceTest, GivesEverySessionAnIdThatNoServerGaveBefore) {
  const std::uint64_t first = openSmallSession();
  const std::uint64_t second =
      bus.ask(test::openSession("clamp", "fruit", "marks")).body().session().session_id();
  test::RecordingBus other_bus;
  ModelStore other_models;
  Service other(other_bus, other_models, ServiceOptions());
  other.start();
  for (const v1::RequestBody& body : test::smallGrasp())
    other_bus.ask(body);
  const std::uint64_t third =
      other_bus.ask(test::openSession("clamp", "fruit", "marks")).body().session().session_id();
  EXPECT_EQ(std::set({first, second, third}).size(), 3u);
  EXPECT_GE(std::min({first, second, third}), kSmallestId);
}

TEST_F(ServiceTest, SaysWhichServerHoldsASession) {
  const std::uint64_t session = openSmallSession();
  EXPECT_EQ(
      bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).body().session().server_id(),
      service.status().server_id());
}

TEST_F(ServiceTest, DoesNothingOfWhatIsMeantForAnotherServerAndMayDoItOnceItIsMeant) {
  const std::uint64_t session = openSmallSession();
  v1::Request request;
  request.client({1});
  request.request_id(1);
  request.protocol_version(v1::PROTOCOL_VERSION);
  request.server_id(service.status().server_id() + 1);
  request.body(test::ofSession(v1::OP_DESCRIBE_SESSION, session));
  bus.send(request);
  bus.send(request);
  const auto refusals = [&] {
    int count = 0;
    for (const v1::Reply& one : bus.copyOf(bus.replies))
      count += one.request_id() == 1 && one.error() == v1::ERROR_OTHER_SERVER ? 1 : 0;
    return count;
  };
  EXPECT_EQ(refusals(), 2) << "said every time";
  request.server_id(service.status().server_id());
  bus.send(request);
  EXPECT_TRUE(bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == 1 && one.error() == v1::ERROR_NONE;
  }));

  v1::Edit stray = weightEdit(1, session, 0.5);
  stray.server_id(service.status().server_id() + 1);
  EXPECT_EQ(edit(stray).error(), v1::ERROR_OTHER_SERVER);
  EXPECT_EQ(
      bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).body().session().revision(),
      0u);
}

TEST_F(ServiceTest, IsNotMutedByWhoClaimsAClientsName) {
  bus.ask(test::putFile(1, "a", "abc"));  // client 1, from its own participant
  // A stranger uses up all ids of client 1.
  constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t i = 0; i < 100; ++i)
    bus.send(kLast - 100 + i, test::cancel(7), 1, 66);
  const v1::Reply reply = bus.ask(test::putFile(1, "b", "abc"));
  EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
}

TEST_F(ServiceTest, AnswersWhatItHasForgottenThatTheOutcomeIsUnknown) {
  for (std::uint64_t id = 1; id <= 100; ++id)
    bus.send(id, test::cancel(7));
  bus.send(1, test::cancel(7));
  EXPECT_TRUE(bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == 1 && one.error() == v1::ERROR_OUTCOME_UNKNOWN;
  }));
}

TEST_F(ServiceTest, LimitsAParticipantByWhateverNamesItAsks) {
  loadSmallGrasp();
  ServiceOptions options;
  options.most_per_client = 2;
  options.workers = 1;
  test::RecordingBus other_bus;
  Service strict(other_bus, models, options);
  strict.start();
  for (std::uint8_t name = 1; name <= 3; ++name)  // the first makes a skin, which takes a while
    other_bus.send(name, test::openSession("clamp", "fruit", "marks"), name, 9);
  const auto third = other_bus.await<v1::Reply>(other_bus.replies, [](const v1::Reply& one) {
    return one.request_id() == 3;
  });
  EXPECT_EQ(third->error(), v1::ERROR_OVERLOADED) << third->message();
}

TEST_F(ServiceTest, RefusesAnotherProtocol) {
  v1::Request request;
  request.request_id(5);
  request.protocol_version(99);
  bus.send(request);
  ASSERT_EQ(bus.count(bus.replies), 1u);
  EXPECT_EQ(bus.replies[0].error(), v1::ERROR_VERSION);
  EXPECT_THAT(bus.replies[0].message(), HasSubstr("99"));
}

TEST_F(ServiceTest, SurvivesOperationsAndEnumeratorsThatDoNotExist) {
  v1::RequestBody kind = test::describeModel(static_cast<v1::ModelKind>(77), "x", false);
  EXPECT_EQ(bus.ask(kind).error(), v1::ERROR_INVALID_INPUT);
  kind = test::unloadModel(static_cast<v1::ModelKind>(77), "x");
  EXPECT_EQ(bus.ask(kind).error(), v1::ERROR_INVALID_INPUT);
  v1::Request request;
  request.request_id(6);
  request.protocol_version(v1::PROTOCOL_VERSION);
  request.body()._d() = static_cast<v1::Operation>(1234);
  bus.send(request);
  EXPECT_EQ(bus.replies.back().error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(bus.replies.back().message(), HasSubstr("1234"));
}

TEST_F(ServiceTest, NamesWhatItDoesNotKnow) {
  const v1::Reply hand = bus.ask(test::openSession("nobody", "x", "y"));
  EXPECT_EQ(hand.error(), v1::ERROR_NOT_FOUND);
  EXPECT_THAT(hand.message(), HasSubstr("hand 'nobody'"));
  const v1::Reply session = bus.ask(test::ofSession(v1::OP_TRANSFER, 42));
  EXPECT_EQ(session.error(), v1::ERROR_NOT_FOUND);
  EXPECT_THAT(session.message(), HasSubstr("session 42"));
}

TEST_F(ServiceTest, TakesTheSameModelAgainButNotAnotherOfThatName) {
  loadSmallGrasp();
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(bus.ask(test::putFile(9, "clamp.urdf", test::clamp_urdf)).error(),
              v1::ERROR_NONE);
    const bool same = round == 0;
    if (same) bus.ask(test::putFile(9, "sites.yaml", test::clamp_sites));
    const v1::Reply reply = bus.ask(test::loadModel(9, v1::MODEL_HAND, "clamp", "clamp.urdf"));
    EXPECT_EQ(reply.error(), same ? v1::ERROR_NONE : v1::ERROR_CONFLICT) << reply.message();
  }
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_HAND, "clamp")).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_HAND, "clamp")).error(), v1::ERROR_NOT_FOUND);
}

TEST_F(ServiceTest, OpensNoFileOfItsOwnMachine) {
  std::string urdf = test::clamp_urdf;
  const std::string box = "<box size=\"0.02 0.06 0.06\"/>";
  const std::string file =
      (test::sourceDirectory() / "server/models/objects/lemon.obj").string();
  ASSERT_TRUE(std::filesystem::exists(file));
  urdf.replace(urdf.find(box), box.size(), "<mesh filename=\"" + file + "\"/>");
  bus.ask(test::putFile(1, "spy.urdf", urdf));
  const v1::Reply reply = bus.ask(test::loadModel(1, v1::MODEL_HAND, "spy", "spy.urdf"));
  EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(reply.message(), HasSubstr("was not uploaded"));
}

TEST_F(ServiceTest, SaysTheClientsNameOfABadFile) {
  bus.ask(test::putFile(1, "meshes/broken.stl", "not a mesh"));
  const v1::Reply reply =
      bus.ask(test::loadModel(1, v1::MODEL_OBJECT, "broken", "meshes/broken.stl"));
  EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(reply.message(), HasSubstr("meshes/broken.stl"));
  EXPECT_THAT(reply.message(), testing::Not(HasSubstr("handgraft-server-")));
  EXPECT_THAT(reply.message(), testing::Not(HasSubstr("\n")));
}

TEST_F(ServiceTest, AnswersAnEditWithANewRevisionAndPose) {
  const std::uint64_t session = openSmallSession();
  bus.ask(test::optimize(session));
  const v1::EditReply reply = edit(weightEdit(1, session, 2.0));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  EXPECT_EQ(reply.revision(), 1u);
  const auto solved =
      bus.await<v1::PoseSolution>(bus.solutions, [](const v1::PoseSolution& one) {
        return one.revision() == 1 && one.is_final();
      });
  EXPECT_TRUE(solved.has_value());
}

TEST_F(ServiceTest, AppliesARepeatedEditOnce) {
  const std::uint64_t session = openSmallSession();
  const v1::Edit twice = weightEdit(1, session, 2.0);
  EXPECT_EQ(edit(twice).revision(), 1u);
  EXPECT_EQ(edit(twice).revision(), 1u);
  EXPECT_EQ(edit(weightEdit(2, session, 3.0)).revision(), 2u);
}

TEST_F(ServiceTest, RefusesAnEditOfAnOldRevisionAndABadOne) {
  const std::uint64_t session = openSmallSession();
  ASSERT_EQ(edit(weightEdit(1, session, 2.0)).error(), v1::ERROR_NONE);
  v1::Edit old = weightEdit(2, session, 3.0);
  old.base_revision(7);
  EXPECT_EQ(edit(old).error(), v1::ERROR_CONFLICT);
  const v1::EditReply bad = edit(weightEdit(3, session, std::nan("")));
  EXPECT_EQ(bad.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(bad.revision(), 1u);
  EXPECT_EQ(edit(weightEdit(4, 999, 1.0)).error(), v1::ERROR_NOT_FOUND);
}

TEST_F(ServiceTest, RefusesASolverThatDoesNotExist) {
  const std::uint64_t session = openSmallSession();
  const v1::Reply reply = bus.ask(test::optimize(session, static_cast<v1::Solver>(99)));
  EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(reply.message(), HasSubstr("slsqp"));
}

TEST_F(ServiceTest, CancelsARunningOptimisation) {
  const std::uint64_t session = openSmallSession();
  bus.send(1, test::optimize(session, v1::SOLVER_DEFAULT, 1000));
  const auto optimizing = [](const v1::SessionState& one) {
    return one.phase() == v1::PHASE_OPTIMIZING;
  };
  ASSERT_TRUE(bus.await<v1::SessionState>(bus.states, optimizing));
  EXPECT_EQ(bus.ask(test::cancel(1)).error(), v1::ERROR_NONE);
  const auto cancelled = bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == 1;
  });
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->error(), v1::ERROR_CANCELLED);
  EXPECT_EQ(bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);
}

TEST_F(ServiceTest, CancelsARequestThatItsCancellationOvertook) {
  ASSERT_EQ(bus.ask(test::cancel(7)).error(), v1::ERROR_NONE);
  bus.send(7, test::plain(v1::OP_LIST_MODELS));
  EXPECT_EQ(bus.replies.back().request_id(), 7u);
  EXPECT_EQ(bus.replies.back().error(), v1::ERROR_CANCELLED);
}

TEST_F(ServiceTest, TellsThatASessionIsClosed) {
  const std::uint64_t session = openSmallSession();
  EXPECT_EQ(bus.ask(test::plain(v1::OP_LIST_SESSIONS)).body().sessions().sessions().size(), 1u);
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_CLOSE_SESSION, session)).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.states.back().phase(), v1::PHASE_CLOSED);
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).error(),
            v1::ERROR_NOT_FOUND);
}

TEST_F(ServiceTest, SaysGoodbyeWhenItStops) {
  openSmallSession();
  service.stop();
  EXPECT_TRUE(bus.statuses.back().stopping());
  EXPECT_EQ(bus.states.back().phase(), v1::PHASE_CLOSED);
}

}  // namespace
}  // namespace handgraft::server
