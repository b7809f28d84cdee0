#include "client/gateway/gateway.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/gateway/model_frame.h"

#include "tests/client/fake_server.h"
#include "tests/client/gateway/bare_page.h"
#include "tests/support/test_domain.h"

namespace handgraft::client::gateway {

namespace {

using nlohmann::json;
using test::BarePage;
using testing::HasSubstr;

/// Knows session 7, which is open, and no other.
bool answer(const v1::Request& request, v1::Reply& reply) {
  if (request.body()._d() == v1::OP_DESCRIBE_SESSION &&
      request.body().session().session_id() == 7) {
    v1::SessionState state;
    state.session_id(7);
    state.hand("small");
    reply.body().session(state);
    reply.body()._d(v1::OP_DESCRIBE_SESSION);
  } else if (request.body()._d() == v1::OP_LIST_MODELS) {
    v1::ModelSummary summary;
    summary.name("small");
    v1::ModelList list;
    list.models().push_back(summary);
    reply.body().models(list);
    reply.body()._d(v1::OP_LIST_MODELS);
  } else {
    reply.error(v1::ERROR_NOT_FOUND);
    reply.message("there is none");
  }
  return true;
}

class GatewayTest : public testing::Test {
 protected:
  void serve(bool read_only = false) {
    WebOptions options;
    options.read_only = read_only;
    gateway = std::make_unique<Gateway>(client, options, WebFiles());
  }

  /// What is answered to a message.
  json ask(BarePage& page, const std::string& message) {
    page.say(message);
    return answerTo(page);
  }

  /// Likewise, to part of a file.
  json give(BarePage& page, const std::string& head, const std::string& bytes) {
    std::string frame(4, '\0');
    frame[0] = static_cast<char>(head.size());
    frame += head + bytes;
    page.send(BarePage::frameHead(frame.size(), 2) + frame);
    return answerTo(page);
  }

  static json answerTo(BarePage& page) {
    while (const auto frame = page.frame()) {
      json heard = json::parse(frame->payload);
      if (heard.contains("reply")) return heard;
    }
    throw std::runtime_error("no answer");
  }

  std::unique_ptr<BarePage> join() {
    auto page = std::make_unique<BarePage>(gateway->port());
    page->upgrade();
    return page;
  }

  test::TestDomain domain;
  test::FakeServer server{{domain.number(), "lo"}, answer};
  Client client{{{domain.number(), "lo"}, Absence::kFail, {}, {}}};
  std::unique_ptr<Gateway> gateway;
};

TEST_F(GatewayTest, AnswersWhatPagesAsk) {
  serve();
  const auto page = join();
  const json reply = ask(*page, R"({"id": 5, "do": "ask", "body": {"kind": "list_models"}})");
  EXPECT_EQ(reply["reply"], 5);
  EXPECT_EQ(reply["body"]["models"]["models"][0]["name"], "small");
}

TEST_F(GatewayTest, AnswersNonsenseWithWhatIsWrong) {
  serve();
  const auto page = join();
  for (
      const char* nonsense :
      {"", "{", "[]", "42", R"({"id": -1, "do": "ask"})", R"({"do": "dance"})",
       R"({"do": "ask", "body": 3})", R"({"do": "ask", "body": {"kind": "erase_all"}})",
       R"({"do": "ask"})", R"({"do": "follow", "session": "seven"})",
       R"({"do": "edit", "session": 7, "body": {"kind": "patch_weight", "patch_weight": {"weight": -1}}})",
       R"({"do": "describe", "kind": "foot", "name": "x"})"}) {
    EXPECT_EQ(ask(*page, nonsense)["error"]["code"], "invalid_input") << nonsense;
  }
  EXPECT_EQ(ask(*page, std::string(100000, '['))["error"]["code"], "invalid_input");
  EXPECT_TRUE(ask(*page, R"({"do": "ask", "body": {"kind": "list_models"}})").contains("body"));
}

// A limit that nobody said is no limit of 0.
TEST_F(GatewayTest, TakesNoEditOfWhichAPartIsNotSaid) {
  serve();
  const auto page = join();
  const json refused = ask(
      *page,
      R"({"do": "edit", "session": 7, "body": {"kind": "joint_limit", "joint_limit": {"joint": "a", "lower": 0}}})");
  EXPECT_EQ(refused["error"]["code"], "invalid_input");
  EXPECT_THAT(refused["error"]["message"].get<std::string>(),
              testing::HasSubstr("body.joint_limit.upper: it is not said"));
  EXPECT_EQ(
      ask(*page, R"({"do": "edit", "session": 7, "body": {"kind": "undo"}})")["error"]["code"],
      "invalid_input");
  EXPECT_EQ(
      ask(*page,
          R"({"do": "edit", "session": 7, "body": {"kind": "undo", "steps": {"count": 1}}, "when": {"time_s": 1}})")
          ["error"]["code"],
      "invalid_input")
      << "no falloff";
  EXPECT_EQ(server.operations(), std::vector<v1::Operation>());
}

TEST_F(GatewayTest, AsksTheServerForNothingThatIsNotForPages) {
  serve();
  const auto page = join();
  for (const char* kind : {"close_session", "unload_model", "cancel", "replay", "sweep",
                           "put_file", "load_model"}) {
    EXPECT_EQ(ask(*page, fmt::format(R"({{"do": "ask", "body": {{"kind": "{}"}}}})",
                                     kind))["error"]["code"],
              "not_permitted")
        << kind;
  }
  EXPECT_EQ(server.operations(), std::vector<v1::Operation>());
}

TEST_F(GatewayTest, ThoseWhoLookDoNotEdit) {
  serve(true);
  const auto page = join();
  EXPECT_EQ(
      ask(*page, R"({"do": "edit", "session": 7, "body": {"kind": "undo"}})")["error"]["code"],
      "not_permitted");
  EXPECT_EQ(ask(*page, R"({"do": "ask", "body": {"kind": "open_session"}})")["error"]["code"],
            "not_permitted");
  EXPECT_EQ(server.operations(), std::vector<v1::Operation>());
  EXPECT_TRUE(ask(*page, R"({"do": "ask", "body": {"kind": "list_models"}})").contains("body"));
}

TEST_F(GatewayTest, TakesFilesInParts) {
  serve();
  const auto page = join();
  const auto put = [&](const char* path) {
    return give(
        *page,
        fmt::format(R"({{"do": "put", "group": 1, "path": "{}", "total_bytes": 3}})", path),
        "v 1");
  };
  EXPECT_FALSE(put("cube.obj").contains("error"));
  EXPECT_EQ(put("../cube.obj")["error"]["code"], "invalid_input");
  for (const char* head : {"", "[]", "{", R"({"do": "load"})"})
    EXPECT_EQ(give(*page, head, "")["error"]["code"], "invalid_input") << head;
  page->send(BarePage::frameHead(4, 2) + "\xff\xff\xff\xff");
  EXPECT_EQ(answerTo(*page)["error"]["code"], "invalid_input");

  // What the server says of it comes back: this one knows no files.
  const std::string load = R"({"id": 8, "do": "load", "group": 1, "kind": "object", )"
                           R"("object": "", "units": "", "main": )";
  EXPECT_EQ(ask(*page, load + R"("cube.obj"})")["error"]["code"], "not_found");
  EXPECT_EQ(ask(*page, load + R"("sphere.obj"})")["error"]["code"], "invalid_input");
  EXPECT_EQ(server.operations(), std::vector<v1::Operation>{v1::OP_PUT_FILE});
  EXPECT_FALSE(ask(*page, R"({"do": "drop", "group": 1})").contains("error"));
  EXPECT_EQ(ask(*page, load + R"("cube.obj"})")["error"]["code"], "invalid_input");
}

TEST_F(GatewayTest, TakesNoFilesOfThoseWhoLook) {
  serve(true);
  const auto page = join();
  EXPECT_EQ(give(*page, R"({"do": "put", "group": 1, "path": "a.obj", "total_bytes": 1})",
                 "v")["error"]["code"],
            "not_permitted");
  EXPECT_EQ(
      ask(*page,
          R"({"do": "load", "group": 1, "kind": "object", "main": "a.obj"})")["error"]["code"],
      "not_permitted");
  EXPECT_EQ(server.operations(), std::vector<v1::Operation>());
}

TEST_F(GatewayTest, FollowsSessionsThatThereAre) {
  serve();
  const auto page = join();
  EXPECT_EQ(ask(*page, R"({"id": 1, "do": "follow", "session": 7})")["session"]["hand"],
            "small");
  EXPECT_EQ(ask(*page, R"({"id": 2, "do": "follow", "session": 8})")["error"]["code"],
            "not_found");
  EXPECT_EQ(ask(*page, R"({"id": 3, "do": "show", "session": 8})")["error"]["code"],
            "not_found");
}

TEST_F(GatewayTest, TellsPagesOfEachOther) {
  serve();
  const auto first = join();
  ask(*first, R"({"do": "ping"})");
  const auto second = join();
  ask(*second, R"({"do": "ping"})");
  std::size_t most = 0;
  first->say(R"({"id": 9, "do": "ping"})");
  while (most < 2) {
    const auto frame = first->frame();
    ASSERT_TRUE(frame.has_value());
    const json heard = json::parse(frame->payload);
    if (heard.value("event", "") == "pages") most = heard["pages"].size();
  }
  EXPECT_EQ(most, 2u);
}

TEST(AddressOf, IsOneThatABrowserTakes) {
  WebOptions options;
  EXPECT_EQ(addressOf(options, 8080), "http://127.0.0.1:8080/");
  options.address = "::1";
  EXPECT_EQ(addressOf(options, 8080), "http://[::1]:8080/");
  options.address = "0.0.0.0";
  EXPECT_THAT(addressOf(options, 8080), testing::Not(testing::HasSubstr("0.0.0.0")));
}

TEST(RandomToken, IsLongAndAnotherOneEachTime) {
  EXPECT_EQ(randomToken().size(), 32u);
  EXPECT_NE(randomToken(), randomToken());
}

TEST(ModelFrame, CarriesMeshesAsTheyLie) {
  v1::ObjectDescription object;
  object.name("tetrahedron");
  object.mesh_O().vertices_m() = {0.0F, 0.5F, -1.25F};
  object.mesh_O().triangles() = {7, 8, 9};
  v1::ModelDescription description;
  description.object(object);
  const std::string frame = modelFrame(258, description);

  EXPECT_EQ(frame.substr(0, 4), std::string("\2\1\0\0", 4));
  std::uint32_t length = 0;
  std::memcpy(&length, frame.data() + 4, sizeof length);
  const json head = json::parse(frame.substr(8, length));
  EXPECT_EQ(head["description"]["object"]["name"], "tetrahedron");
  const std::size_t begin = (8 + length + 3) / 4 * 4;
  for (const json& array : head["arrays"]) {
    ASSERT_EQ(array["count"], 3);
    const char* at = frame.data() + begin + array["at"].get<std::size_t>();
    if (array["name"] == "mesh/vertices") {
      float values[3];
      std::memcpy(values, at, sizeof values);
      EXPECT_THAT(values, testing::ElementsAre(0.0F, 0.5F, -1.25F));
    } else {
      std::uint32_t values[3];
      std::memcpy(values, at, sizeof values);
      EXPECT_THAT(values, testing::ElementsAre(7U, 8U, 9U));
    }
  }
  EXPECT_EQ(head["arrays"].size(), 2u);
  EXPECT_EQ(frame.size(), begin + 6 * 4);
}

}  // namespace

}  // namespace handgraft::client::gateway
