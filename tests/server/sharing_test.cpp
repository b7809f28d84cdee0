// Whose sessions are, in a secured domain: who is behind a request or an edit decides, not what
// it claims.
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/admission/service.h"
#include "server/store/state_store.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using idl::security::Named;
using idl::security::Role;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint8_t kAnna = 1;
constexpr std::uint8_t kBob = 2;
constexpr std::uint8_t kCarl = 3;
constexpr std::uint8_t kBoss = 4;
constexpr std::uint8_t kUnknown = 9;

class Sharing : public testing::Test {
 protected:
  Sharing() {
    bus.people = {{kAnna, Named{"anna", Role::kEditor}},
                  {kBob, Named{"bob", Role::kEditor}},
                  {kCarl, Named{"carl", Role::kEditor}},
                  {kBoss, Named{"boss", Role::kOperator}}};
    begin();
  }

  void begin() {
    models = std::make_unique<ModelStore>();
    ServiceOptions options;
    options.state = &state;
    service = std::make_unique<Service>(bus, *models, options);
    service->start();
  }

  std::uint64_t openAs(std::uint8_t who) {
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body, who).error(), v1::ERROR_NONE);
    const v1::Reply reply = bus.ask(test::openSession("clamp", "fruit", "marks"), who);
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.body().session().session_id();
  }

  v1::EditReply editAs(std::uint8_t who, std::uint64_t session) {
    v1::PatchWeightEdit body;
    body.patch("palm");
    body.weight(0.5);
    v1::Edit edit;
    edit.client({who});
    edit.edit_id(++last_edit_);
    edit.session_id(session);
    edit.body().patch_weight(body);
    edit.credentials().identity("anna");  // so says everybody
    bus.send(edit);
    return bus
        .await<v1::EditReply>(bus.edit_replies,
                              [&](const v1::EditReply& one) {
                                return one.edit_id() == edit.edit_id();
                              })
        .value_or(v1::EditReply());
  }

  v1::Reply shareAs(std::uint8_t who,
                    std::uint64_t session,
                    v1::Access access,
                    const std::vector<std::string>& with = {},
                    const std::string& owner = "") {
    v1::ShareRequest request;
    request.session_id(session);
    request.access(access);
    request.identities(with);
    request.owner(owner);
    v1::RequestBody body;
    body.share(request);
    return bus.ask(body, who);
  }

  static v1::RequestBody solveOf(std::uint64_t session) {
    v1::OptimizeRequest request;
    request.session_id(session);
    v1::RequestBody body;
    body.optimize(request);
    return body;
  }

  StateStore state{":memory:"};
  test::RecordingBus bus;
  std::unique_ptr<ModelStore> models;
  std::unique_ptr<Service> service;

 private:
  std::uint64_t last_edit_ = 0;
};

TEST_F(Sharing, ASessionIsItsOpenersAlone) {
  const std::uint64_t session = openAs(kAnna);
  EXPECT_EQ(editAs(kAnna, session).error(), v1::ERROR_NONE);
  for (const std::uint8_t other : {kBob, kUnknown}) {
    const v1::EditReply refused = editAs(other, session);
    EXPECT_EQ(refused.error(), v1::ERROR_NOT_PERMITTED);
    EXPECT_THAT(refused.message(), HasSubstr("is anna's"));
    for (const v1::Operation what : {v1::OP_CLOSE_SESSION, v1::OP_STOP_SOLVING})
      EXPECT_EQ(bus.ask(test::ofSession(what, session), other).error(),
                v1::ERROR_NOT_PERMITTED);
    EXPECT_EQ(bus.ask(solveOf(session), other).error(), v1::ERROR_NOT_PERMITTED);
    // Who may read may read it.
    EXPECT_EQ(bus.ask(test::ofSession(v1::OP_SESSION_SETTINGS, session), other).error(),
              v1::ERROR_NONE);
  }
  EXPECT_EQ(editAs(kBoss, session).error(), v1::ERROR_NONE) << "operators may";
  const v1::Reply told = bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session), kBob);
  EXPECT_EQ(told.body().session().owner(), "anna");
  EXPECT_EQ(told.body().session().access(), v1::ACCESS_OWNER);
  EXPECT_EQ(told.body().session().revision(), 2u) << "what was refused changed something";
}

TEST_F(Sharing, AStrangersCloseStopsNoSolve) {
  const std::uint64_t session = openAs(kAnna);
  EXPECT_EQ(bus.ask(test::ofSession(v1::OP_CLOSE_SESSION, session), kBob).error(),
            v1::ERROR_NOT_PERMITTED);
  EXPECT_EQ(bus.ask(solveOf(session), kAnna).error(), v1::ERROR_NONE);
}

TEST_F(Sharing, IsItsOwnersToShareAndToTakeBack) {
  const std::uint64_t session = openAs(kAnna);
  EXPECT_EQ(shareAs(kBob, session, v1::ACCESS_ALL).error(), v1::ERROR_NOT_PERMITTED);
  EXPECT_EQ(shareAs(kAnna, session, v1::ACCESS_LISTED, {"bob"}).error(), v1::ERROR_NONE);
  EXPECT_EQ(editAs(kBob, session).error(), v1::ERROR_NONE);
  EXPECT_EQ(editAs(kCarl, session).error(), v1::ERROR_NOT_PERMITTED);
  EXPECT_EQ(shareAs(kBob, session, v1::ACCESS_ALL).error(), v1::ERROR_NOT_PERMITTED)
      << "who may edit may not share";
  EXPECT_EQ(shareAs(kAnna, session, v1::ACCESS_ALL).error(), v1::ERROR_NONE);
  EXPECT_EQ(editAs(kCarl, session).error(), v1::ERROR_NONE);
  EXPECT_EQ(shareAs(kAnna, session, v1::ACCESS_OWNER).error(), v1::ERROR_NONE);
  EXPECT_EQ(editAs(kBob, session).error(), v1::ERROR_NOT_PERMITTED);
  EXPECT_EQ(shareAs(kBoss, session, v1::ACCESS_OWNER, {}, "carl").error(), v1::ERROR_NONE);
  EXPECT_EQ(editAs(kCarl, session).error(), v1::ERROR_NONE) << "it was handed over";
  EXPECT_EQ(editAs(kAnna, session).error(), v1::ERROR_NOT_PERMITTED);
}

TEST_F(Sharing, NamesWhatCannotBeShared) {
  const std::uint64_t session = openAs(kAnna);
  const v1::Reply unknown = shareAs(kAnna, session, v1::ACCESS_LISTED, {"b ob"});
  EXPECT_EQ(unknown.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(unknown.message(), HasSubstr("'b ob'"));
  EXPECT_EQ(shareAs(kAnna, session, v1::ACCESS_LISTED).error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(shareAs(kAnna, session, v1::ACCESS_ALL, {"bob"}).error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(
      shareAs(kAnna, session, v1::ACCESS_LISTED, std::vector<std::string>(65, "bob")).error(),
      v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(shareAs(kAnna, session, static_cast<v1::Access>(77)).error(),
            v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(editAs(kBob, session).error(), v1::ERROR_NOT_PERMITTED);
}

TEST_F(Sharing, OutlivesTheServer) {
  const std::uint64_t session = openAs(kAnna);
  ASSERT_EQ(shareAs(kAnna, session, v1::ACCESS_LISTED, {"bob", "dora"}).error(),
            v1::ERROR_NONE);
  service.reset();
  begin();
  const v1::Reply told = bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session), kCarl);
  EXPECT_EQ(told.body().session().owner(), "anna");
  EXPECT_EQ(told.body().session().access(), v1::ACCESS_LISTED);
  EXPECT_EQ(editAs(kCarl, session).error(), v1::ERROR_NOT_PERMITTED);
  EXPECT_EQ(editAs(kBob, session).error(), v1::ERROR_NONE);
  EXPECT_THAT(state.session(session).access.identities, ElementsAre("bob", "dora"));
}

TEST_F(Sharing, ASavedSessionIsWhoseLoadsIt) {
  const std::uint64_t session = openAs(kAnna);
  const v1::Reply saved = bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session), kAnna);
  ASSERT_EQ(saved.error(), v1::ERROR_NONE) << saved.message();
  v1::LoadSessionRequest load;
  load.text(saved.body().saved_session().text());
  v1::RequestBody body;
  body.load_session(load);
  const v1::Reply loaded = bus.ask(body, kBob);
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_EQ(loaded.body().session().owner(), "bob");
  EXPECT_EQ(editAs(kAnna, loaded.body().session().session_id()).error(),
            v1::ERROR_NOT_PERMITTED);
}

TEST_F(Sharing, AServerSaysThatItChecksIdentities) {
  EXPECT_TRUE(bus.await<v1::ServerStatus>(bus.statuses, [](const v1::ServerStatus& status) {
    return status.secured();
  }));
}

TEST_F(Sharing, IsNothingWhereNobodyKnowsWhoAsks) {
  bus.people.clear();
  const std::uint64_t session = openAs(kAnna);
  EXPECT_EQ(editAs(kBob, session).error(), v1::ERROR_NONE);
  const v1::Reply refused = shareAs(kAnna, session, v1::ACCESS_OWNER);
  EXPECT_EQ(refused.error(), v1::ERROR_UNSUPPORTED);
  EXPECT_THAT(refused.message(), HasSubstr("handgraft keys"));
}

}  // namespace
}  // namespace handgraft::server
