#include "client/editor/editor.h"

#include <csignal>
#include <fstream>
#include <sstream>
#include <thread>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/editor/show.h"
#include "client/editor/show_solution.h"
#include "client/link/model_files.h"
#include "client/present/failure.h"
#include "client/present/interactive_client.h"
#include "core/base/error.h"
#include "core/base/progress.h"

#include "tests/client/editor/fake_edit_server.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"

namespace handgraft::client::editor {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class EditorTest : public testing::Test {
 protected:
  EditorTest()
      : network{domain.number(), "lo"},
        edit_server(network),
        server(interactiveClient(network, Absence::kFail, interruption)),
        editor(server, interruption, sink, edit_server.state()) {}

  std::string output(const std::string& line) {
    testing::internal::CaptureStdout();
    try {
      editor.run(line);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    return testing::internal::GetCapturedStdout();
  }

  Failure failureOfScript(const std::string& text) {
    std::istringstream lines(text);
    testing::internal::CaptureStdout();
    Failure failure{0, ""};
    try {
      editor.runScript(
          [&]() -> std::optional<std::string> {
            std::string line;
            if (!std::getline(lines, line)) return std::nullopt;
            return line;
          },
          "test.hg");
    } catch (const std::exception& error) {
      failure = failureOf(error);
    }
    echoed = testing::internal::GetCapturedStdout();
    return failure;
  }

  test::TestDomain domain;
  Network network;
  test::FakeEditServer edit_server;
  Interruption interruption;
  Client server;
  ProgressLine progress;
  Sink sink{Sink::Form::kText, progress};
  Editor editor;
  std::string echoed;
};

TEST_F(EditorTest, TellsASolutionForEveryEdit) {
  EXPECT_EQ(output("lock bend"),
            "revision 1: objective 11, mean 2.50 mm, worst index 3.00 mm; 2 of 2 patches "
            "reached\n");
  EXPECT_THAT(output("weight thumb 0.2; unlock bend"),
              AllOf(HasSubstr("revision 2: objective 12"), HasSubstr("revision 3: ")));
  ASSERT_EQ(edit_server.edits().size(), 3U);
  EXPECT_EQ(edit_server.edits()[0].body()._d(), v1::EDIT_JOINT_LOCK);
  EXPECT_EQ(edit_server.edits()[1].base_revision(), 1U);
  EXPECT_EQ(edit_server.edits()[2].base_revision(), 2U);
}

TEST_F(EditorTest, ANewSnapshotWaitsForNoSolution) {
  EXPECT_EQ(output("snapshot before"), "revision 1\n");
}

TEST_F(EditorTest, TellsWhyASolveFailed) {
  edit_server.fail = true;
  try {
    output("disable thumb");
    FAIL() << "a failed solve was taken for a solution";
  } catch (const SolveFailed& failed) {
    EXPECT_STREQ(failed.what(), "the hand has no point left");
  }
}

TEST_F(EditorTest, UnitsInDoubtAreToldToTheCommandThatTakesThem) {
  const std::string path = (test::scratchDirectory() / "bulb.obj").string();
  std::ofstream(path) << "v 0 0 0";
  try {
    output("object " + path);
    FAIL() << "an object 152 m across was taken";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()),
              "152 m across: say --units mm to handgraft load object '" + path + "'");
  }
}

TEST_F(EditorTest, AStaleEditIsRefusedWithWhatCameBefore) {
  output("lock bend");
  edit_server.editByOther("limit bend upper 0.6", false);
  try {
    output("unlock bend");
    FAIL() << "a stale edit was applied";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code(), v1::ERROR_CONFLICT);
    EXPECT_THAT(refused.what(), AllOf(HasSubstr("revision 2"), HasSubstr("client abababab"),
                                      HasSubstr("limit bend upper 0.6")));
    EXPECT_EQ(failureOf(refused).exit_code, 2);
  }
  EXPECT_EQ(edit_server.edits().size(), 1U);
  EXPECT_THAT(output("unlock bend"), HasSubstr("revision 3"));  // now it has been shown
}

TEST_F(EditorTest, WhatOthersDoIsNewsOnce) {
  output("lock bend");
  edit_server.editByOther("lock slide", true);
  std::vector<std::string> news;
  for (int i = 0; i < 500 && news.empty(); ++i) {
    news = editor.session().news();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_EQ(news.size(), 1U);
  EXPECT_THAT(news[0], AllOf(HasSubstr("revision 2"), HasSubstr("lock slide")));
  EXPECT_TRUE(editor.session().news().empty());
  EXPECT_THAT(output("unlock bend"), HasSubstr("revision 3"));
}

TEST_F(EditorTest, CtrlCCancelsASolveAndNothingElse) {
  edit_server.hang = true;
  std::thread user([this] {
    while (!edit_server.hanging)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    raise(SIGINT);
  });
  EXPECT_THROW(output("solve"), Cancelled);
  user.join();
  interruption.reset();
  edit_server.hang = false;
  EXPECT_THAT(output("lock bend"), HasSubstr("revision 1: objective 11"));
  EXPECT_THAT(output("solve"), HasSubstr("objective 11"));
  EXPECT_THAT(edit_server.operations(), Not(testing::Contains(v1::OP_CLOSE_SESSION)));
}

TEST_F(EditorTest, CtrlCStopsTheSolveThatFollowsAnEdit) {
  edit_server.hold_poses = true;
  std::thread user([this] {
    while (edit_server.edits().empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    raise(SIGINT);
  });
  try {
    output("lock bend");
    FAIL() << "there was no pose to tell of";
  } catch (const CommandFailed& failed) {
    EXPECT_EQ(failed.exitCode(), 1);
    EXPECT_THAT(failed.what(), HasSubstr("stopped: revision 1 stands"));
  }
  user.join();
  interruption.reset();
  EXPECT_THAT(edit_server.operations(), AllOf(testing::Contains(v1::OP_STOP_SOLVING),
                                              Not(testing::Contains(v1::OP_CLOSE_SESSION))));
  edit_server.hold_poses = false;
  EXPECT_THAT(output("unlock bend"), HasSubstr("revision 2: objective 12"));
}

// === Poses and their explanations

TEST_F(EditorTest, AScriptWaitsForTheExplanation) {
  edit_server.hold_explanations = true;
  std::thread diagnosing([this] {
    while (edit_server.edits().empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // longer than a prompt waits
    edit_server.diagnose();
  });
  editor.showPosesAtOnce();  // which is for those who type
  EXPECT_EQ(failureOfScript("lock bend\n").exit_code, 0);
  diagnosing.join();
  EXPECT_THAT(echoed, HasSubstr("revision 1: objective 11, mean 2.50 mm, worst index 3.00 mm; "
                                "2 of 2 patches reached\n"));
}

TEST_F(EditorTest, ANewerRevisionAnswersForOneThatIsNotDiagnosed) {
  edit_server.hold_explanations = true;
  std::thread other([this] {
    while (edit_server.edits().empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    edit_server.editByOther("lock slide", true);
  });
  EXPECT_EQ(output("lock bend"),
            "revision 2: objective 12, mean 2.50 mm, worst index 3.00 mm; 2 of 2 patches "
            "reached\n");
  other.join();
}

TEST_F(EditorTest, AtThePromptPosesComeAtOnceAndExplanationsAsNews) {
  editor.showPosesAtOnce();
  EXPECT_THAT(output("lock bend"), HasSubstr("worst index 3.00 mm; 2 of 2 patches reached\n"));
  edit_server.hold_explanations = true;
  EXPECT_EQ(output("unlock bend"),
            "revision 2: objective 12, mean 2.50 mm, worst index 3.00 mm\n");
  EXPECT_TRUE(editor.session().news().empty());
  edit_server.diagnose();
  std::vector<std::string> news;
  for (int i = 0; i < 500 && news.empty(); ++i) {
    news = editor.session().news();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_THAT(news, testing::ElementsAre("revision 2: 2 of 2 patches reached"));
  EXPECT_TRUE(editor.session().news().empty());
}

TEST_F(EditorTest, ShowWaitsForTheExplanation) {
  editor.showPosesAtOnce();
  edit_server.hold_explanations = true;
  EXPECT_THAT(output("lock bend"), Not(HasSubstr("reached")));
  std::thread diagnosing([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    edit_server.diagnose();
  });
  EXPECT_THAT(output("show"), HasSubstr("2 of 2 patches reached"));
  diagnosing.join();
}

TEST(Solutions, LeaveOutPatchesThatDoNotCount) {
  v1::PoseSolution solution;
  for (const auto& [name, verdict, mean_mm] :
       {std::tuple("thumb", v1::VERDICT_REACHED, 1.0),
        std::tuple("palm", v1::VERDICT_NONE, 9.0),
        std::tuple("index", v1::VERDICT_AT_LIMIT, 3.0)}) {
    v1::PatchFit patch;
    patch.name(name);
    patch.point_count(10);
    patch.mean_mm(mean_mm);
    patch.diagnosis().verdict(verdict);
    solution.patches().push_back(patch);
  }
  EXPECT_EQ(offIn(solution), Off{"palm"});
  EXPECT_THAT(poseLine(solution, offIn(solution)), HasSubstr("mean 2.00 mm, worst index 3.00"));
  EXPECT_THAT(poseLine(solution, {}), HasSubstr("worst palm 9.00"));
  EXPECT_EQ(status(solution, {"palm"})["mean_mm"], 2.0);
}

TEST_F(EditorTest, APatchThatIsSwitchedOffBeforeItIsDiagnosedIsLeftOut) {
  editor.showPosesAtOnce();
  edit_server.hold_explanations = true;
  edit_server.switchOff("index");  // as the settings tell
  EXPECT_THAT(output("disable index"), HasSubstr("mean 1.00 mm, worst thumb 1.00 mm\n"));
}

TEST_F(EditorTest, StatesThatAreOverChangeNothing) {
  output("lock bend");
  edit_server.repeatOldState();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_TRUE(editor.session().news().empty());
  EXPECT_EQ(editor.session().state().revision(), 1U);
  EXPECT_EQ(editor.session().state().hand(), "claw");
}

TEST_F(EditorTest, AScriptEchoesAndStopsAtItsFirstFailure) {
  const Failure failure = failureOfScript("# a comment\n\nlock bend\nlock bent\nunlock bend\n");
  EXPECT_EQ(failure.exit_code, 2);
  EXPECT_THAT(failure.message, AllOf(testing::StartsWith("test.hg:4: "), HasSubstr("'bent'")));
  EXPECT_THAT(echoed, AllOf(testing::StartsWith("> lock bend\nrevision 1"),
                            HasSubstr("> lock bent"), Not(HasSubstr("> unlock"))));
  EXPECT_EQ(edit_server.edits().size(), 1U);
}

TEST_F(EditorTest, ScriptsRunScripts) {
  const auto inner = test::scratchDirectory() / "inner.hg";
  std::ofstream(inner) << "lock bend\nlock nothing\n";
  const Failure failure = failureOfScript("!script " + inner.string() + "\n");
  EXPECT_THAT(failure.message,
              testing::StartsWith("test.hg:1: " + inner.string() + ":2: lock: 'nothing'"));
  EXPECT_EQ(edit_server.edits().size(), 1U);

  const auto endless = test::scratchDirectory() / "endless.hg";
  std::ofstream(endless) << "!script " << endless.string() << "\n";
  EXPECT_THAT(failureOfScript("!script " + endless.string()).message, HasSubstr("nest"));
}

TEST_F(EditorTest, AFolderIsNoScript) {
  const std::string folder = test::scratchDirectory().string();
  try {
    output("!script " + folder);
    FAIL() << "a folder was taken for an empty script";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(folder), HasSubstr("folder")));
  }
}

TEST_F(EditorTest, SaysThatTheSearchMovesAJointThatIsNotLocked) {
  EXPECT_THAT(output("joint bend 0.3"), HasSubstr("moved bend on to 28.65 deg"));
  EXPECT_THAT(output("joint bend 0.5"), Not(HasSubstr("moved")));  // where the search leaves it
}

TEST_F(EditorTest, SaysWhoseTheLastEditWas) {
  output("lock bend");
  EXPECT_THAT(output("show session"), HasSubstr("an edit (by you)"));
  edit_server.editByOther("lock slide", true);
  std::string shown;
  for (int i = 0; i < 500 && shown.find("slide") == std::string::npos; ++i) {
    shown = output("show session");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_THAT(shown, HasSubstr("lock slide (by client abababab)"));
}

TEST(Clients, ThatAServerBeforeKnewHaveNoNames) {
  v1::ClientId own{};
  own.fill(0xab);
  EXPECT_EQ(nameOf(own, own), "you");
  EXPECT_EQ(nameOf(v1::ClientId{}, own), "an earlier client");
}

TEST_F(EditorTest, AGraspHasNoTimes) {
  try {
    output("at 1");
    FAIL() << "a time was taken";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("at 1 s"), HasSubstr("no motion")));
  }
  EXPECT_THAT(output("lock bend"), HasSubstr("revision 1")) << "edits go on";
  ASSERT_EQ(edit_server.edits().size(), 1U);
  EXPECT_TRUE(edit_server.edits()[0].when().empty());
}

TEST_F(EditorTest, QuitEndsAScript) {
  EXPECT_EQ(failureOfScript("quit\nlock bend\n").exit_code, 0);
  EXPECT_TRUE(editor.finished());
  EXPECT_FALSE(editor.closed());
  EXPECT_TRUE(edit_server.edits().empty());
}

TEST_F(EditorTest, CloseEndsTheSession) {
  EXPECT_EQ(output("close; lock bend"), "closed session 7\n");
  EXPECT_TRUE(editor.closed());
  EXPECT_THAT(edit_server.operations(), testing::Contains(v1::OP_CLOSE_SESSION));
}

TEST_F(EditorTest, JoinsASessionByItsId) {
  EXPECT_EQ(output("join 7"), "");  // it is there already: nothing is left behind
  EXPECT_THAT(edit_server.operations(), testing::Contains(v1::OP_DESCRIBE_SESSION));
  EXPECT_THROW(output("join"), InvalidInput) << "there was no session before this one";
}

TEST_F(EditorTest, WritesFiles) {
  const std::string folder = test::scratchDirectory().string();
  output("save " + folder + "/session.json; export csv " + folder + "/pose.csv");
  EXPECT_EQ(readFile(folder + "/session.json"), "the session");
  EXPECT_EQ(readFile(folder + "/pose.csv"), "csv of 7");
  EXPECT_THROW(output("save /no/such/folder/session.json"), InvalidInput);
  try {
    output("export glb /no/such/folder/hand.glb");
    FAIL() << "a file was written where there is no folder";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("export '/no/such/folder/hand.glb'"));
  }
}

TEST_F(EditorTest, AFileThatNoRequestCarriesIsRefusedWithItsSize) {
  const std::filesystem::path file = test::scratchDirectory() / "large.json";
  std::ofstream(file) << "{}";
  std::filesystem::resize_file(file, 17U << 20U);
  for (const char* command : {"load ", "replay "}) {
    try {
      output(command + file.string());
      FAIL() << "17 MiB were sent";
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("large.json"), HasSubstr("17.0 MiB"),
                                      HasSubstr("at most 16 MiB")));
    }
  }
  EXPECT_THAT(edit_server.operations(), Not(testing::Contains(v1::OP_LOAD_SESSION)));
}

TEST_F(EditorTest, AReplayThatDiffersFails) {
  const std::string file = (test::scratchDirectory() / "log.json").string();
  std::ofstream(file) << "{}";
  EXPECT_EQ(output("replay " + file), "3 entries played; it ends the same\n");
  edit_server.same = false;
  try {
    output("replay " + file);
    FAIL() << "a difference was taken for success";
  } catch (const CommandFailed& failed) {
    EXPECT_EQ(failed.exitCode(), 1);
    EXPECT_THAT(failed.what(), HasSubstr("entry 2 differs"));
  }
}

TEST_F(EditorTest, ShowsWhatASessionIsMadeOf) {
  EXPECT_THROW(output("show"), InvalidInput);  // nothing is solved yet
  output("solve");
  EXPECT_THAT(output("show"), AllOf(HasSubstr("thumb"), HasSubstr("3.00")));
  EXPECT_THAT(output("show joints"),
              AllOf(testing::ContainsRegex("bend .* -28.65 +28.65 +deg +-57.3 to 114.6"),
                    testing::ContainsRegex("slide .* -500 +500 +mm +0 to 100")));
  EXPECT_THAT(output("show settings"), HasSubstr("slsqp, 8 starts"));
  EXPECT_THAT(output("show session"), HasSubstr("plate_2"));
  EXPECT_EQ(output("show snapshots"), "before\n");
  EXPECT_THAT(output("show history"), HasSubstr("* revision 0"));
}

TEST_F(EditorTest, KnowsAllNamesForCompletion) {
  using testing::ElementsAre;
  const Names names = editor.session().allNames();
  EXPECT_THAT(names.patches, ElementsAre("thumb", "index"));
  EXPECT_THAT(names.joints, ElementsAre("bend", "slide"));
  EXPECT_THAT(names.points, testing::Contains("index_tip"));
  EXPECT_THAT(names.hands, ElementsAre("a_hand_with_a_long_name", "claw"));
  EXPECT_THAT(names.sessions, ElementsAre("7"));
  EXPECT_THAT(names.snapshots, ElementsAre("before"));
}

TEST(Differences, StandBelowTheNamesOfWhatDiffers) {
  v1::Difference difference;
  difference.what("joint bend");
  difference.a("0.1 rad");
  difference.b("0.25 rad");
  v1::CompareReply reply;
  reply.differences().push_back(difference);
  EXPECT_EQ(tellDifferences(reply, "start", "wide", {}).text,
            "                  start         wide\n"
            "joint bend  5.72958 deg  14.3239 deg\n");
  EXPECT_THAT(tellDifferences(reply, "start", "", {}).text, HasSubstr("start          now\n"));
  EXPECT_EQ(tellDifferences({}, "start", "", {}).text, "no difference\n");
  EXPECT_EQ(tellDifferences(reply, "start", "wide", {}).data["differences"][0]["a"], "0.1 rad");
}

TEST(Differences, OfJointsThatSlideAreInMillimetres) {
  v1::HandDescription hand;
  hand.joints().resize(2);
  hand.joints()[0].name("rail");
  hand.joints()[0].kind(v1::JOINT_PRISMATIC);
  hand.joints()[1].name("rail 2");
  v1::CompareReply reply;
  for (const char* what : {"joint rail", "joint rail upper", "joint rail 2 lower"}) {
    reply.differences().emplace_back().what(what);
    reply.differences().back().a("0.02 rad");
    reply.differences().back().b("inf rad");
  }
  const std::string text = tellDifferences(reply, "start", "wide", hand).text;
  EXPECT_THAT(text, testing::ContainsRegex("joint rail +20 mm +inf mm\n"));
  EXPECT_THAT(text, testing::ContainsRegex("joint rail upper +20 mm +inf mm\n"));
  EXPECT_THAT(text, testing::ContainsRegex("joint rail 2 lower +1.14592 deg +inf deg\n"));
}

TEST(EditorInJson, PrintsOneObjectALine) {
  const test::TestDomain domain;
  const Network network{domain.number(), "lo"};
  test::FakeEditServer edit_server(network);
  Interruption interruption;
  Client server(interactiveClient(network, Absence::kFail, interruption));
  ProgressLine progress;
  const Sink sink(Sink::Form::kJson, progress);
  Editor editor(server, interruption, sink, edit_server.state());
  testing::internal::CaptureStdout();
  EXPECT_THROW(editor.run("lock bend; show joints; lock bent; solve"), InvalidInput);
  std::istringstream lines(testing::internal::GetCapturedStdout());
  std::vector<nlohmann::json> objects;
  for (std::string line; std::getline(lines, line);)
    objects.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_EQ(objects[0]["command"], "lock bend");
  EXPECT_EQ(objects[0]["ok"], true);
  EXPECT_EQ(objects[0]["revision"], 1);
  EXPECT_EQ(objects[0]["solution"]["worst"]["patch"], "index");
  EXPECT_EQ(objects[1]["joints"][0]["name"], "bend");
  EXPECT_EQ(objects[2]["ok"], false);
  EXPECT_EQ(objects[2]["exit_code"], 2);
}

}  // namespace
}  // namespace handgraft::client::editor
