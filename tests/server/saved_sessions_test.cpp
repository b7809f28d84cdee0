// What sessions came to, written down: exports, saved sessions, and servers that open them.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "idl/json.h"
#include "server/store/state_store.h"

#include "tests/server/live_edits.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST_F(LiveEdits, ExportWhatTheyCameTo) {
  const std::uint64_t session = open();
  const auto exported = [&](v1::ExportFormat format) {
    v1::ExportRequest request;
    request.session_id(session);
    request.format(format);
    v1::RequestBody body;
    body.export_file(request);
    return bus.ask(body);
  };
  const auto text = [&](v1::ExportFormat format) {
    const v1::Reply reply = exported(format);
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    if (reply.error() != v1::ERROR_NONE) return std::string();
    const auto& content = reply.body().exported_file().content();
    return std::string(content.begin(), content.end());
  };
  EXPECT_THAT(exported(v1::EXPORT_CSV).message(), HasSubstr("solve it first"));
  bus.ask(test::optimize(session));
  apply(session, limit(-0.45));
  EXPECT_THAT(text(v1::EXPORT_CSV), StartsWith("name,value,unit\nhinge,"));
  EXPECT_LE(
      std::stod(text(v1::EXPORT_CSV).substr(std::string("name,value,unit\nhinge,").size())),
      -0.45)
      << "not the pose that answers the edit";
  EXPECT_THAT(text(v1::EXPORT_JSON), HasSubstr("\"handgraft-grasp/1\""));
  EXPECT_THAT(text(v1::EXPORT_JSON), HasSubstr("\"palm\""));
  EXPECT_THAT(text(v1::EXPORT_OBJ), HasSubstr("g jaw\n"));
  EXPECT_THAT(text(v1::EXPORT_GLB), StartsWith("glTF"));
  EXPECT_THAT(text(v1::EXPORT_ISAAC_GRASP), StartsWith("format: isaac_grasp\n"));
  EXPECT_THAT(text(v1::EXPORT_NPZ), StartsWith("PK"));
  EXPECT_THAT(text(v1::EXPORT_MJCF), HasSubstr("<key name=\"grasp_0\" time=\"0\" qpos=\""));
  EXPECT_THAT(text(v1::EXPORT_ROS_TRAJECTORY), HasSubstr("joint_names:\n- \"hinge\"\n"));
  EXPECT_THAT(exported(static_cast<v1::ExportFormat>(99)).message(), HasSubstr("isaac_grasp"));
}

TEST_F(LiveEdits, ExportTheDiagnosisWithThePose) {
  const std::uint64_t session = open();
  const v1::Reply solved = bus.ask(test::optimize(session));
  ASSERT_EQ(solved.error(), v1::ERROR_NONE) << solved.message();
  const v1::PoseSolution& solution = solved.body().solution();
  ASSERT_TRUE(solution.is_diagnosed());
  v1::ExportRequest request;
  request.session_id(session);
  request.format(v1::EXPORT_JSON);
  v1::RequestBody body;
  body.export_file(request);
  const v1::Reply reply = bus.ask(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const auto& content = reply.body().exported_file().content();
  const idl::Json file = idl::Json::parse(content.begin(), content.end());
  EXPECT_EQ(file["is_diagnosed"], true);
  EXPECT_EQ(file["verdict"], solution.verdict());
  EXPECT_GT(solution.evaluations(), 0U);
  EXPECT_EQ(file["evaluations"], solution.evaluations()) << "of the search that found it";
  EXPECT_EQ(file["terms"]["prior"], solution.terms().prior());
  EXPECT_EQ(file["penetration"], idl::jsonOf(solution)["penetration"]);
  EXPECT_GE(file["terms"]["penetration"].get<double>(), 0.0);
  EXPECT_GT(file["weights"]["distance"].get<double>(), 0.0);
  EXPECT_EQ(file["options"], idl::jsonOf(solution)["options"]);
  ASSERT_FALSE(solution.patches().empty());
  for (std::size_t i = 0; i < solution.patches().size(); ++i) {
    const v1::PatchDiagnosis& diagnosis = solution.patches()[i].diagnosis();
    const idl::Json& told = file["patches"][i]["diagnosis"];
    EXPECT_EQ(told["verdict"], nameOf(diagnosis.verdict()));
    EXPECT_EQ(told["text"], diagnosis.text());
    EXPECT_EQ(told["sensitivities"].size(), diagnosis.sensitivities().size());
  }
  EXPECT_GT(file["patches"].size(), solution.patches().size()) << "dropped ones";
}

v1::RequestBody loadSession(const std::string& text) {
  v1::LoadSessionRequest request;
  request.text(text);
  v1::RequestBody body;
  body.load_session(request);
  return body;
}

TEST_F(LiveEdits, AreSavedLoadedAndReplayed) {
  const std::uint64_t session = openSolved();
  apply(session, limit(0.6));
  finalOf(session, 1);
  apply(session, weight(2.5));
  const v1::PoseSolution last = finalOf(session, 2);
  apply(session, steps(v1::EDIT_UNDO));
  finalOf(session, 3);
  apply(session, steps(v1::EDIT_REDO));
  finalOf(session, 4);
  const v1::Reply saved = bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session));
  ASSERT_EQ(saved.error(), v1::ERROR_NONE) << saved.message();
  const std::string text = saved.body().saved_session().text();

  const v1::Reply loaded = bus.ask(loadSession(text));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  const std::uint64_t twin = loaded.body().session().session_id();
  EXPECT_NE(twin, session);
  EXPECT_EQ(settings(twin).joints(), settings(session).joints());
  EXPECT_EQ(settings(twin).undo(), settings(session).undo());
  EXPECT_EQ(finalOf(twin, 4).joint_positions(), last.joint_positions())
      << "watchers see the saved pose";
  EXPECT_EQ(apply(twin, steps(v1::EDIT_UNDO)).revision(), 5u);

  v1::ReplayRequest request;
  request.text(text);
  v1::RequestBody body;
  body.replay(request);
  const v1::Reply replayed = bus.ask(body);
  ASSERT_EQ(replayed.error(), v1::ERROR_NONE) << replayed.message();
  EXPECT_TRUE(replayed.body().replay().same()) << replayed.body().replay().message();
  EXPECT_GE(replayed.body().replay().entries(), 4u);
  EXPECT_EQ(replayed.body().replay().result().text(), text);
}

/// A variant of `clamp`, called "stiff".
v1::RequestBody stiffClamp() {
  v1::VariantRequest variant;
  variant.hand("clamp");
  variant.name("stiff");
  v1::RequestBody made;
  made.variant(variant);
  made._d(v1::OP_MAKE_VARIANT);
  return made;
}

/// Another server, with nothing but what is built in.
struct FreshServer {
  FreshServer() : service(bus, models, {}) { service.start(); }

  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

TEST_F(LiveEdits, OpenOnAServerThatHasNoneOfTheirModels) {
  const std::uint64_t session = openSolved();
  ASSERT_EQ(bus.ask(stiffClamp()).error(), v1::ERROR_NONE);
  v1::ModelEdit hand;
  hand.name("stiff");
  v1::EditBody swap;
  swap.swapped_model(hand);
  swap._d(v1::EDIT_HAND);
  ASSERT_EQ(apply(session, swap).error(), v1::ERROR_NONE);
  const v1::PoseSolution last = finalOf(session, 1);
  const std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();

  FreshServer other;
  const v1::Reply loaded = other.bus.ask(loadSession(text));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_EQ(loaded.body().session().hand(), "stiff");
  const std::uint64_t twin = loaded.body().session().session_id();
  const auto pose =
      other.bus.await<v1::PoseSolution>(other.bus.solutions, [&](const v1::PoseSolution& one) {
        return one.session_id() == twin && one.is_final();
      });
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->joint_positions(), last.joint_positions());
  EXPECT_NO_THROW((void)other.models.hand("clamp")) << "what the variant rests on";

  // From there it goes on to a third one.
  const std::string again =
      other.bus.ask(test::ofSession(v1::OP_SAVE_SESSION, twin)).body().saved_session().text();
  FreshServer third;
  EXPECT_EQ(third.bus.ask(loadSession(again)).error(), v1::ERROR_NONE);
}

/// Likewise, but it keeps what it has.
struct KeepingServer {
  KeepingServer() : service(bus, models, options()) {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  ServiceOptions options() {
    ServiceOptions made;
    made.state = &state;
    return made;
  }

  StateStore state{":memory:"};
  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

TEST(SavedSessions, HoldTheirOwnModelsThoughAnotherHasTheName) {
  KeepingServer server;
  ASSERT_EQ(server.bus.ask(stiffClamp()).error(), v1::ERROR_NONE);
  const v1::Reply opened = server.bus.ask(test::openSession("stiff", "fruit", "marks"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const std::uint64_t session = opened.body().session().session_id();
  ASSERT_EQ(server.bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);

  // Both names go to hands that are longer.
  for (const char* name : {"stiff", "clamp"})
    ASSERT_EQ(server.bus.ask(test::unloadModel(v1::MODEL_HAND, name)).error(), v1::ERROR_NONE);
  std::string urdf = test::clamp_urdf;
  urdf.replace(urdf.find("0.035"), 5, "0.070");
  for (const auto& body :
       {test::putFile(4, "clamp.urdf", urdf), test::putFile(4, "sites.yaml", test::clamp_sites),
        test::loadModel(4, v1::MODEL_HAND, "clamp", "clamp.urdf")})
    ASSERT_EQ(server.bus.ask(body).error(), v1::ERROR_NONE);
  ASSERT_EQ(server.bus.ask(stiffClamp()).error(), v1::ERROR_NONE);

  const std::string text = server.bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session))
                               .body()
                               .saved_session()
                               .text();
  FreshServer other;
  const v1::Reply loaded = other.bus.ask(loadSession(text));
  EXPECT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
}

TEST_F(LiveEdits, NameAllModelsThatAreLacking) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  const std::size_t held = text.find(",\"held\":[");
  ASSERT_NE(held, std::string::npos);
  text.erase(held, text.find(']', held) + 1 - held);
  FreshServer other;
  const v1::Reply reply = other.bus.ask(loadSession(text));
  EXPECT_EQ(reply.error(), v1::ERROR_NOT_FOUND);
  EXPECT_THAT(reply.message(), HasSubstr("contacts marks, hand clamp, object fruit"));
}

TEST_F(LiveEdits, OfADamagedModelAreRefusedByName) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  const std::size_t bytes = text.find("\"bytes\":\"", text.find("\"name\":\"clamp\""));
  ASSERT_NE(bytes, std::string::npos);
  for (const auto& [damage, told] : {std::pair{"****", "base64"}, {"AAAA", "clamp"}}) {
    std::string damaged = text;
    damaged.replace(bytes + 9, 4, damage);
    FreshServer other;
    const v1::Reply reply = other.bus.ask(loadSession(damaged));
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reply.message();
    EXPECT_THAT(reply.message(), HasSubstr(told));
  }
}

TEST_F(LiveEdits, OfADamagedFileAreRefusedByName) {
  const std::uint64_t session = openSolved();
  std::string text =
      bus.ask(test::ofSession(v1::OP_SAVE_SESSION, session)).body().saved_session().text();
  EXPECT_EQ(bus.ask(loadSession("not a session")).error(), v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(bus.ask(loadSession(text.substr(0, text.size() / 2))).error(),
            v1::ERROR_INVALID_INPUT);
  const std::size_t hand = text.find("\"clamp\"");
  ASSERT_NE(hand, std::string::npos);
  text.replace(hand, 7, "\"cramp\"");
  const v1::Reply reply = bus.ask(loadSession(text));
  EXPECT_NE(reply.error(), v1::ERROR_NONE);
  EXPECT_NE(reply.error(), v1::ERROR_INTERNAL) << reply.message();
}

class FewBytes : public LiveEdits {
 protected:
  static constexpr std::size_t kMost = 1 << 20;

  static ServiceOptions few() {
    ServiceOptions options;
    options.most_bytes = kMost;
    return options;
  }

  FewBytes() : LiveEdits(few()) {}
};

TEST_F(FewBytes, AreTakenAgainOnceTheyAreAnswered) {
  for (int i = 0; i < 5; ++i) {  // together more than may wait at once
    EXPECT_EQ(bus.ask(loadSession(std::string(kMost / 6, ' '))).error(),
              v1::ERROR_INVALID_INPUT);
  }
  // It takes several times its size.
  const v1::Reply refused = bus.ask(loadSession(std::string(kMost / 3, ' ')));
  EXPECT_EQ(refused.error(), v1::ERROR_OVERLOADED);
  EXPECT_THAT(refused.message(), HasSubstr("1048576"));
}

}  // namespace
}  // namespace handgraft::server
