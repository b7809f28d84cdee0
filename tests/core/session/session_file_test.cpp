// Files of sessions: whole ones open as they were, damaged ones and those of other models do
// not.
#include "core/io/session_file.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/named_models.h"

namespace handgraft::io {
namespace {

using session::Session;
using session::SessionModels;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

SessionModels models() {
  static const SessionModels known_models = [] {
    const test::BallGrasp grasp;
    return test::withOthers(grasp.hand(), grasp.ball, grasp.contacts);
  }();
  return known_models;
}

/// With something of everything in it.
const std::string& savedText() {
  static const std::string session_text = [] {
    Session session(models(), Pose::Identity(), {});
    session.apply(session::SnapshotEdit{"first"});
    session.apply(session::JointLimitEdit{"index_1", 0.0, 0.7});
    session.commit(session.solve({}, {}, Progress()));
    session.apply(session::HandEdit{"found"});
    session.noteCancelledSolve();
    session.apply(session::PatchWeightEdit{"thumb", 0.1});
    session.apply(session::UndoEdit{});
    return sessionText(session);
  }();
  return session_text;
}

Session opened(const std::string& text) {
  return openSession(readSessionText(text), models(), Progress());
}

void expectRefused(const std::string& text, const char* why) {
  EXPECT_THAT(
      [&] {
        (void)opened(text);
      },
      ThrowsMessage<InvalidInput>(HasSubstr(why)));
}

/// The text with one thing changed.
template <class Change>
std::string changed(const Change& change) {
  auto file = nlohmann::ordered_json::parse(savedText());
  change(file);
  return file.dump();
}

TEST(SessionFile, OpensAsItWasSaved) {
  Session session = opened(savedText());
  EXPECT_TRUE(sessionText(session) == savedText());
  EXPECT_EQ(session.revision(), 5u);
  EXPECT_EQ(session.document().hand, "found");
  EXPECT_EQ(session.history().redoCount(), 1u);
  session.apply(session::RedoEdit{});
  EXPECT_EQ(session.document().patches[0].weight, 0.1);
  session.apply(session::RestoreEdit{"first"});
  EXPECT_EQ(session.document().hand, "hand");
}

TEST(SessionFile, KeepsEveryNumberToTheBit) {
  Session session(models(), Pose::Identity(), {});
  const double odd = 0.1 + 0.2;
  session.apply(session::PatchWeightEdit{"thumb", odd});
  session.apply(session::PatchWeightEdit{"index", 5e-324});
  session.apply(session::JointSoftEdit{"thumb_1", -0.0, 1.0 / 3.0});
  const Session again = opened(sessionText(session));
  EXPECT_TRUE(again.document() == session.document());
  EXPECT_TRUE(std::signbit(again.document().joints[0].soft_value));
}

TEST(SessionFile, IsRefusedOnOtherModels) {
  const SessionFile file = readSessionText(savedText());
  SessionModels other = models();
  other.object_O = std::make_shared<const geometry::TriangleMesh>(
      geometry::transformed(*other.object_O, Eigen::Affine3d(Eigen::Scaling(1.001))));
  EXPECT_THAT(
      [&] {
        (void)openSession(file, other, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'object object' is another one")));
  other = models();
  other.hand.sites[0].p_L.x() += 1e-6;
  EXPECT_THAT(
      [&] {
        (void)openSession(file, other, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'hand hand' is another one")));
  other = models();
  other.contacts_name = "others";
  EXPECT_THAT(
      [&] {
        (void)openSession(file, other, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("contacts 'contacts'")));
  other = models();
  other.source = nullptr;
  EXPECT_THAT(
      [&] {
        (void)openSession(file, other, Progress());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("no hand 'found'")));
}

TEST(SessionFile, NamesTheFieldThatIsWrong) {
  using Json = nlohmann::ordered_json;
  expectRefused("", "not JSON");
  expectRefused("[]", "the whole");
  expectRefused(savedText().substr(0, savedText().size() / 2), "not JSON");
  expectRefused(changed([](Json& file) {
                  file["format"] = "handgraft-session/2";
                }),
                "must be 'handgraft-session/1'");
  expectRefused(changed([](Json& file) {
                  file["extra"] = 1;
                }),
                "'extra' is unknown");
  expectRefused(changed([](Json& file) {
                  file["revision"] = -1;
                }),
                "'revision'");
  expectRefused(changed([](Json& file) {
                  file["log"][0]["edit"]["kind"] = "dance";
                }),
                "'log[0].edit.kind'");
  expectRefused(changed([](Json& file) {
                  file["log"][0]["edit"]["nme"] = "x";
                }),
                "'nme'");
  expectRefused(changed([](Json& file) {
                  file["models"]["hashes"].erase("hand hand");
                }),
                "lacks 'hand hand'");
  const auto present = [](Json& file) -> Json& {
    return file["history"]["present"];
  };
  expectRefused(changed([&](Json& file) {
                  present(file)["X_WO"][3] = 5;
                }),
                "rigid");
  expectRefused(changed([&](Json& file) {
                  present(file)["X_WO"] = {1, 2};
                }),
                "a pose has 12");
  expectRefused(changed([&](Json& file) {
                  present(file)["joints"].erase(0);
                }),
                "5 joints");
  expectRefused(changed([&](Json& file) {
                  present(file)["start"]["q"].erase(0);
                }),
                "joints");
  expectRefused(changed([&](Json& file) {
                  present(file)["patches"] = Json::array();
                }),
                "no patch");
  expectRefused(changed([&](Json& file) {
                  present(file)["patches"][0]["name"] = "nose";
                }),
                "no patch 'nose'");
  expectRefused(changed([&](Json& file) {
                  present(file)["patches"][0]["root_O"]["face"] = 1 << 30;
                }),
                "root of patch 'thumb'");
  expectRefused(changed([&](Json& file) {
                  present(file)["patches"][0]["placement"]["direction_S"] = {2, 0, 0};
                }),
                "must be 1");
  expectRefused(changed([&](Json& file) {
                  present(file)["joints"][0]["lower"] = 99;
                }),
                "hold nothing");
  expectRefused(changed([&](Json& file) {
                  present(file)["solving"]["starts"] = 0;
                }),
                "starts");
  expectRefused(changed([&](Json& file) {
                  present(file)["hand"] = "none";
                }),
                "no hand 'none'");
  expectRefused(changed([&](Json& file) {
                  present(file)["contacts"] = "x";
                }),
                "contacts 'x'");
  expectRefused(changed([](Json& file) {
                  file["history"]["undo"][0]["change"]["patches"] = {
                      {99, file["history"]["present"]["patches"][0]}};
                }),
                "number 99");
}

TEST(SessionFile, SurvivesRandomDamage) {
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string text = savedText();
    for (int k = 0; k < 3; ++k)
      text[random() % text.size()] = static_cast<char>(32 + random() % 90);
    try {
      Session session = opened(text);
      (void)sessionText(session);
    } catch (const InvalidInput& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace handgraft::io
