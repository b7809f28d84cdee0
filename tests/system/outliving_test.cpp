#include <csignal>
#include <future>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/cyclone/requester.h"

#include "tests/system/live_session.h"
#include "tests/system/service.h"

// What clients were told, and what was done, when servers die, fall silent or meet others.

namespace handgraft::test {
namespace {

using idl::cyclone::Participant;
using idl::cyclone::Refused;
using idl::cyclone::Requester;
using EditOutcome = Requester::Outcome<v1::EditReply>;
using testing::HasSubstr;

v1::EditBody weightOf(const std::string& patch, double weight) {
  v1::PatchWeightEdit edit;
  edit.patch(patch);
  edit.weight(weight);
  v1::EditBody body;
  body.patch_weight(edit);
  return body;
}

v1::RequestBody openingOf(const std::string& hand) {
  v1::OpenSessionRequest request;
  request.hand(hand);
  request.object("lemon");
  request.contacts("lemon_6");
  v1::RequestBody body;
  body.open_session(request);
  return body;
}

v1::RequestBody ofSession(v1::Operation operation, std::uint64_t session) {
  v1::SessionKey key;
  key.session_id(session);
  v1::RequestBody body;
  body.session(key);
  body._d(operation);
  return body;
}

/// One client, with one session on the server there is.
struct Editor {
  explicit Editor(const Network& network) : participant(network), requester(participant) {
    EXPECT_TRUE(requester.waitForServer(std::chrono::seconds(60)));
    session = requester.ask(openingOf("barrett8")).session().session_id();
  }

  std::future<EditOutcome> edit(const v1::EditBody& body) {
    const auto told = std::make_shared<std::promise<EditOutcome>>();
    requester.beginEdit(
        session, 0, body,
        [told](EditOutcome outcome) {
          told->set_value(std::move(outcome));
        },
        [this](const std::string& stage, double) {
          stages += stage;
        });
    return told->get_future();
  }

  std::uint64_t revision() {
    return requester.ask(ofSession(v1::OP_DESCRIBE_SESSION, session)).session().revision();
  }

  Participant participant;
  Requester requester;
  std::uint64_t session = 0;
  std::string stages;
};

/// Other threads may go on for a moment.
void pause(const Process& process) {
  process.send(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
}

v1::ErrorCode errorOf(const EditOutcome& outcome) {
  try {
    if (const auto* error = std::get_if<std::exception_ptr>(&outcome))
      std::rethrow_exception(*error);
    return v1::ERROR_NONE;
  } catch (const Refused& refused) {
    return refused.code();
  } catch (const std::exception& other) {
    ADD_FAILURE() << other.what();
    return v1::ERROR_INTERNAL;
  }
}

TEST(Outliving, AnEditRepeatedOverARestartNeverReachesAStrangersSession) {
  Service service;
  Editor editor(service.network());
  pause(service.server());
  auto outcome = editor.edit(weightOf("palm", 0.25));
  service.server().send(SIGKILL);
  service.server().wait();
  const auto another = service.start("handgraft-server", {});
  Editor stranger(service.network());
  ASSERT_EQ(outcome.wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_EQ(errorOf(outcome.get()), v1::ERROR_OTHER_SERVER);
  EXPECT_EQ(stranger.revision(), 0u);
  EXPECT_NE(stranger.session, editor.session);
  // Nor does what the first one asks from now on.
  EXPECT_EQ(errorOf(editor.edit(weightOf("palm", 0.25)).get()), v1::ERROR_NOT_FOUND);
  EXPECT_THROW(editor.requester.ask(ofSession(v1::OP_CLOSE_SESSION, editor.session)), Refused);
  EXPECT_EQ(stranger.revision(), 0u);
}

TEST(Outliving, WhatAnyServerCanAnswerGoesOnOverARestart) {
  Service service;
  Editor editor(service.network());
  service.server().send(SIGKILL);
  service.server().wait();
  const auto another = service.start("handgraft-server", {});
  ASSERT_TRUE(another->waitForText("event=ready"));
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(v1::OP_LIST_MODELS);
  EXPECT_FALSE(editor.requester.ask(body).models().models().empty());
}

TEST(Outliving, AnEditThatASilentServerGotIsAskedForUntilItIsKnown) {
  Service service;
  Editor editor(service.network());
  pause(service.server());
  auto outcome = editor.edit(weightOf("palm", 0.25));
  EXPECT_EQ(outcome.wait_for(std::chrono::seconds(6)), std::future_status::timeout)
      << "told before it was known";
  service.server().send(SIGCONT);
  ASSERT_EQ(outcome.wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_EQ(errorOf(outcome.get()), v1::ERROR_NONE);
  EXPECT_EQ(editor.revision(), 1u);
  EXPECT_THAT(editor.stages, HasSubstr("outcome unknown"));
}

TEST(Outliving, AnEditWhoseServerStaysSilentIsToldAsUnknown) {
  Service service;
  Editor editor(service.network());
  pause(service.server());
  auto outcome = editor.edit(weightOf("palm", 0.25));
  ASSERT_EQ(outcome.wait_for(std::chrono::seconds(120)), std::future_status::ready);
  EXPECT_EQ(errorOf(outcome.get()), v1::ERROR_OUTCOME_UNKNOWN);
  service.server().send(SIGCONT);
}

TEST(TwoServers, GoOnAndClientsStayWithTheirs) {
  Service service;
  Editor editor(service.network());
  const auto younger = service.start("handgraft-server", {});
  EXPECT_TRUE(younger->waitForText("event=another_server")) << younger->err();
  EXPECT_TRUE(service.server().waitForText("event=another_server"));
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(errorOf(editor.edit(weightOf("palm", 0.25 + 0.01 * i)).get()), v1::ERROR_NONE);
  EXPECT_EQ(editor.revision(), 20u);
  for (Process* server : {younger.get(), &service.server()}) {
    EXPECT_TRUE(server->running());
    server->send(SIGTERM);
    EXPECT_EQ(server->wait(), 0);
  }
}

TEST(ForgedStatus, EndsNoServerAndTakesNoClientAway) {
  Service service;
  Editor editor(service.network());
  const Participant forger(service.network());
  idl::cyclone::Writer<v1::ServerStatus> statuses(forger, idl::kStatusTopic);
  v1::ServerStatus forged = editor.requester.status();
  for (int i = 0; i < 50; ++i) {
    forged.server_id(forged.server_id() + 1);
    forged.uptime_s(1e9);
    statuses.write(forged);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(errorOf(editor.edit(weightOf("palm", 0.25)).get()), v1::ERROR_NONE);
  EXPECT_EQ(editor.revision(), 1u);
  EXPECT_TRUE(service.server().running());
}

}  // namespace
}  // namespace handgraft::test
