#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/editor/command_table.h"

#include "tests/support/shared_data.h"
#include "tests/support/terminal.h"
#include "tests/system/service.h"
#include "tests/system/shared_skins.h"

namespace handgraft::test {
namespace {

namespace fs = std::filesystem;
namespace editor = client::editor;
using testing::HasSubstr;

const std::vector<std::string> scenarios = {"patches", "joints",  "poses",
                                            "search",  "history", "files"};

fs::path scenario(const std::string& name) {
  return sourceDirectory() / "tests" / "system" / "scenarios" / (name + ".hg");
}

std::vector<std::string> linesOf(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);)
    lines.push_back(line);
  EXPECT_FALSE(lines.empty()) << path;
  return lines;
}

// A scenario's first line says how it is started.
std::vector<std::string> argumentsOf(const fs::path& path) {
  constexpr std::string_view kStart = "# handgraft ";
  const std::string first = linesOf(path).at(0);
  EXPECT_EQ(first.rfind(kStart, 0), 0U) << first;
  return editor::commandsOf(first.substr(kStart.size())).at(0);
}

TEST(Scenarios, AreTheFilesThatThereAre) {
  std::set<std::string> found;
  for (const auto& entry : fs::directory_iterator(scenario("patches").parent_path()))
    found.insert(entry.path().stem().string());
  EXPECT_EQ(found, std::set<std::string>(scenarios.begin(), scenarios.end()));
}

TEST(Scenarios, ShowEveryCommand) {
  std::set<std::string_view> shown;
  for (const std::string& name : scenarios) {
    // Whatever is written counts as a name: which names there are is the server's to say.
    std::vector<editor::Words> commands;
    editor::Names names;
    for (const std::string& line : linesOf(scenario(name))) {
      for (const editor::Words& words : editor::commandsOf(line)) {
        commands.push_back(words);
        names.patches.insert(names.patches.end(), words.begin(), words.end());
      }
    }
    names.joints = names.sites = names.points = names.patches;
    for (const editor::Words& words : commands)
      shown.insert(editor::parse(words, names).command->pattern);
  }
  for (const editor::Command& command : editor::commandTable()) {
    // One has no end, no file knows the id that a session will have, and these grasps are no
    // motions (motion_test.cpp).
    const bool is_left_out = command.pattern == "watch" || command.pattern == "join SESSION" ||
                             command.pattern.rfind("at ", 0) == 0 ||
                             command.pattern == "show times" ||
                             command.pattern.rfind("take back ", 0) == 0;
    EXPECT_EQ(shown.count(command.pattern), is_left_out ? 0U : 1U) << command.pattern;
  }
}

class Scenario : public testing::TestWithParam<std::string> {
 protected:
  Scenario() {
    fs::create_directories(folder);
    std::ofstream(folder / "more.hg") << "show session\n";
    fs::current_path(folder);  // where the programs write
  }

  ~Scenario() override { fs::current_path(before); }

  const fs::path before = fs::current_path();
  const fs::path folder = scratchDirectory() / ("scenario_" + GetParam());
  const SharedSkins skins;
  Service service;
};

TEST_P(Scenario, Runs) {
  std::vector<std::string> arguments = argumentsOf(scenario(GetParam()));
  arguments.insert(arguments.end(), {"--script", scenario(GetParam()).string()});
  const Finished finished = service.client(arguments);
  EXPECT_EQ(finished.exit_code, 0) << finished.err << finished.out;
}

TEST_P(Scenario, TellsProgramsAnObjectALine) {
  std::vector<std::string> arguments = argumentsOf(scenario(GetParam()));
  arguments.insert(arguments.end(), {"--script", scenario(GetParam()).string(), "--json"});
  const Finished finished = service.client(arguments);
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  std::istringstream lines(finished.out);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
    ASSERT_TRUE(object.is_object()) << line;
    EXPECT_TRUE(object.value("ok", true)) << line;
  }
  EXPECT_GT(count, 5U);
}

INSTANTIATE_TEST_SUITE_P(All, Scenario, testing::ValuesIn(scenarios), [](const auto& named) {
  return named.param;
});

TEST(Editor, FailsWithTheLineOfAScript) {
  const SharedSkins skins;
  const Service service;
  const fs::path script = scratchDirectory() / "wrong.hg";
  std::ofstream(script) << "weight palm 0.5\nlimit no_such_joint upper 1\nweight palm 1\n";
  const Finished finished =
      service.client({"edit", "--hand", "barrett8", "--object", "lemon", "--contacts",
                      "lemon_6", "--script", script.string()});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("wrong.hg:2: limit: 'no_such_joint' is no joint"));
  EXPECT_EQ(finished.out.find("> weight palm 1"), std::string::npos);
}

TEST(Editor, SaysWhichSessionAScriptLeavesOpenAndHowToEndIt) {
  const SharedSkins skins;
  const Service service;
  const fs::path script = scratchDirectory() / "leaves.hg";
  for (const bool fails : {false, true}) {
    std::ofstream(script) << (fails ? "weight palm 0.5\nlock no_such_joint\n"
                                    : "weight palm 0.5\n");
    const Finished finished =
        service.client({"edit", "--hand", "barrett8", "--object", "lemon", "--contacts",
                        "lemon_6", "--script", script.string()});
    EXPECT_EQ(finished.exit_code, fails ? 2 : 0) << finished.err;
    const auto sessions = service.ask({"sessions"})["sessions"];
    ASSERT_EQ(sessions.size(), 1U);
    const std::string id = std::to_string(sessions[0]["session_id"].get<std::uint64_t>());
    EXPECT_THAT(finished.out, HasSubstr("session " + id + " stays open"));
    EXPECT_THAT(finished.out, HasSubstr("handgraft close " + id + " --domain "));
    EXPECT_EQ(service.client({"close", id}).exit_code, 0);
  }
  std::ofstream(script) << "close\n";
  const Finished closed =
      service.client({"edit", "--hand", "barrett8", "--object", "lemon", "--contacts",
                      "lemon_6", "--script", script.string()});
  EXPECT_EQ(closed.out.find("stays open"), std::string::npos) << closed.out;
}

TEST(Editor, KnowsThePoseOfASessionThatItJoins) {
  const SharedSkins skins;
  const Service service;
  const auto first = service.ask(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6", "--keep"});
  const std::string id = std::to_string(first["session_id"].get<std::uint64_t>());
  const fs::path picture = scratchDirectory() / "joined.png";
  for (const std::string& command : {std::string("show"), std::string("show minima"),
                                     "png " + picture.string(), std::string("prior here")}) {
    const fs::path script = scratchDirectory() / "first.hg";
    std::ofstream(script) << command << "\n";
    const Finished finished = service.client({"edit", id, "--script", script.string()});
    EXPECT_EQ(finished.exit_code, 0) << command << ": " << finished.err;
  }
}

TEST(Editor, ShowSaysThatTheLastSolveFailed) {
  const SharedSkins skins;
  const Service service;
  const fs::path script = scratchDirectory() / "failing.hg";
  const auto first = service.ask(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6", "--keep"});
  // The first digits do.
  const std::string id = std::to_string(first["session_id"].get<std::uint64_t>()).substr(0, 4);
  const auto show = [&](const std::string& commands) {
    std::ofstream(script) << commands;
    return service.client({"edit", id, "--script", script.string()});
  };
  ASSERT_EQ(show("disable palm\ndisable thumb\ndisable index\n").exit_code, 0);
  EXPECT_EQ(show("disable ring\n").exit_code, 1);
  const Finished shown = show("show\n");
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("revision 4 was not solved: "));
  EXPECT_THAT(shown.out, HasSubstr("; the figures are of revision 3"));
}

TEST(Editor, TwoOnOneSessionSeeEachOthersEdits) {
  const SharedSkins skins;
  Service service;
  const auto first = service.ask(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6", "--keep"});
  const std::string id = std::to_string(first["session_id"].get<std::uint64_t>());
  Terminal a(program("handgraft"), {"edit", id, "--domain", std::to_string(service.domain())},
             {{"XDG_STATE_HOME", (scratchDirectory() / "state_a").string()}});
  ASSERT_TRUE(a.waitFor("barrett8 0> ")) << a.text();
  const fs::path script = scratchDirectory() / "other.hg";
  std::ofstream(script) << "weight palm 0.5\n";
  EXPECT_EQ(service.client({"edit", id, "--script", script.string()}).exit_code, 0);
  EXPECT_TRUE(a.waitFor("revision 1, by client ")) << a.text();
  a.type("weight palm 1\r");
  EXPECT_TRUE(a.waitFor("revision 2: objective")) << a.text();
}

// A person at a terminal: completion, help, history, Ctrl-C during a solve.
class Typing : public testing::Test {
 protected:
  Typing() { EXPECT_TRUE(terminal.waitFor("human20 0> ")) << terminal.text(); }

  void expect(const std::string& text) {
    EXPECT_TRUE(terminal.waitFor(text)) << "waited for '" << text << "' in:\n"
                                        << terminal.text();
  }

  /// Of the one session there is.
  [[nodiscard]] std::string session() const {
    const auto sessions = service.ask({"sessions"})["sessions"];
    return std::to_string(sessions.at(0)["session_id"].get<std::uint64_t>());
  }

  const SharedSkins skins;
  Service service;
  fs::path state = scratchDirectory() / "state";
  Terminal terminal{program("handgraft"),
                    {"edit", "--hand", "human20", "--object", "lemon", "--contacts", "lemon_6",
                     "--domain", std::to_string(service.domain())},
                    {{"XDG_STATE_HOME", state.string()}}};
};

TEST_F(Typing, TabCompletesAndAQuestionMarkExplains) {
  terminal.type("lim\t");
  expect("limit ");
  terminal.type("thumb_m\t");
  expect("thumb_mcp_flex ");
  terminal.type("?");
  expect("limit JOINT upper VALUE");
  terminal.type("up\t0.6\r");
  expect("revision 1: objective");
  expect("human20 1> ");
  terminal.type("hand \t\t");
  expect("allegro16");
  expect("human20");
}

TEST_F(Typing, ArrowsBringLinesBackAlsoOfEarlierEditors) {
  terminal.type("weight palm 0.5\r");
  expect("human20 1> ");
  terminal.type("\x1b[A");
  expect("weight palm 0.5");
  terminal.type("\r");
  expect("human20 2> ");
  terminal.type("\x04");
  expect("stays open");
  EXPECT_EQ(terminal.wait(), 0);

  Terminal later(program("handgraft"),
                 {"edit", session(), "--domain", std::to_string(service.domain())},
                 {{"XDG_STATE_HOME", state.string()}});
  ASSERT_TRUE(later.waitFor("human20 2> ")) << later.text();
  later.type("\x1b[A");
  EXPECT_TRUE(later.waitFor("weight palm 0.5")) << later.text();
}

TEST_F(Typing, CtrlCCancelsASolveAndKeepsTheSession) {
  terminal.type("solve --solver all --starts 10000 --max-evaluations 100000\r");
  expect("solve ");
  expect("%");  // it is under way
  terminal.type("\x03");
  expect("cancelled");
  expect("human20 0> ");
  terminal.type("weight palm 0.5\r");
  expect("revision 1: objective");
  terminal.type("half a li\x03");
  expect("^C");
  expect("human20 1> ");
  terminal.type("quit\r");
  const std::string id = session();
  expect("session " + id + " stays open");
  EXPECT_EQ(terminal.wait(), 0);
  EXPECT_EQ(service.client({"close", id}).exit_code, 0);
}

TEST_F(Typing, CtrlCStopsTheSolveThatFollowsAnEdit) {
  terminal.type("solver all --starts 10000 --max-evaluations 100000\r");
  // Under way until it is stopped: nothing better is told before the last stage.
  std::this_thread::sleep_for(std::chrono::seconds(2));
  terminal.type("\x03");
  expect("stopped: revision 1 stands");
  expect("human20 1> ");
  terminal.type("undo\r");
  expect("revision 2: objective");
  expect("human20 2> ");
}

TEST_F(Typing, OutlivesItsServerAndGoesOnWithAnother) {
  const fs::path file = scratchDirectory() / "kept.json";
  const std::string id = session();
  terminal.type("weight palm 0.5; save " + file.string() + "\r");
  expect("wrote ");
  expect("human20 1> ");
  service.server().send(SIGKILL);
  expect("the server stopped answering");
  terminal.type("undo\r");
  expect("stopped answering");
  expect("human20 1> ");
  const std::unique_ptr<Process> another = service.start("handgraft-server", {});
  expect("a server answers again");
  expect("session " + id + " has ended with its server");
  terminal.type("undo\r");
  expect("session " + id + " has ended with its server; load opens a saved one");
  terminal.type("load " + file.string() + "\r");
  expect(", revision 1; the session " + id + " before has ended with its server");
  terminal.type("undo\r");
  expect("revision 2: objective");
  expect("human20 2> ");  // what is typed between two prompts is the terminal's
  terminal.type("\x04");
  expect("stays open");
  EXPECT_EQ(terminal.wait(), 0);
}

TEST_F(Typing, CtrlCEndsAnEditThatASilentServerDoesNotAnswer) {
  terminal.type("weight palm 0.5\r");
  expect("human20 1> ");
  service.server().send(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // other threads go on a moment
  terminal.type("weight palm 1\r");
  std::this_thread::sleep_for(std::chrono::seconds(3));
  terminal.type("\x03");
  expect("whether the edit was applied is not known");
  service.server().send(SIGCONT);
  // The server had it all the same, and says so.
  expect("revision 2, by you");
}

TEST_F(Typing, GoesOnAfterAPauseOfItsServer) {
  const std::string id = session();
  terminal.type("weight palm 0.5\r");
  expect("human20 1> ");
  service.server().send(SIGSTOP);
  expect("the server stopped answering");  // after 3 s of silence
  std::this_thread::sleep_for(std::chrono::seconds(2));
  service.server().send(SIGCONT);
  expect("a server answers again");
  terminal.type("weight palm 1\r");
  expect("revision 2: objective");
  terminal.type("quit\r");
  expect("session " + id + " stays open: handgraft edit " + id + " --domain " +
         std::to_string(service.domain()));
  EXPECT_EQ(terminal.wait(), 0);
}

TEST_F(Typing, LeavesThoughTheServerIsSilent) {
  service.server().send(SIGSTOP);
  expect("the server stopped answering");
  terminal.type("quit\r");
  expect("the server does not answer");
  expect("handgraft edit ");
  EXPECT_EQ(terminal.wait(), 0);
}

TEST_F(Typing, ALineThatIsLongerThanTheTerminalIsRead) {
  std::string line = "weight palm 0.5";
  while (line.size() < 250)
    line += "; weight palm 0.5";
  terminal.type(line +
                "; snapshot gr\xc3\xb6\xc3\x9f"
                "er\r");
  expect("letters");  // a snapshot's name is plain; the whole line came across
  terminal.type("quit\r");
  EXPECT_EQ(terminal.wait(), 0);
}

}  // namespace
}  // namespace handgraft::test
