#include "client/cli/command_line.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::variant<Invocation, Printout> parse(std::vector<std::string> words) {
  std::vector<const char*> argv = {"handgraft"};
  for (const std::string& word : words)
    argv.push_back(word.c_str());
  return parseCommandLine(static_cast<int>(argv.size()), argv.data());
}

Invocation invocation(const std::vector<std::string>& words) {
  return std::get<Invocation>(parse(words));
}

std::vector<std::string> grasp(const std::vector<std::string>& more) {
  std::vector<std::string> words = {"grasp", "--hand",     "human20", "--object",
                                    "lemon", "--contacts", "lemon_6"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string objectionTo(const std::vector<std::string>& words) {
  try {
    parse(words);
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "";
}

TEST(CommandLine, MeetsOnLoopbackUnlessTold) {
  const Invocation plain = invocation({"doctor"});
  EXPECT_EQ(plain.common.network.domain, 0);
  EXPECT_EQ(plain.common.network.interface, "lo");
  EXPECT_FALSE(plain.common.json);
  EXPECT_TRUE(std::holds_alternative<DoctorOptions>(plain.command));
}

TEST(CommandLine, TakesCommonOptionsBeforeAndBehindTheCommand) {
  for (const auto& words : {std::vector<std::string>{"--domain", "7", "--json", "models"},
                            {"models", "--domain", "7", "--json"},
                            {"models", "show", "hand", "human20", "--json", "--domain=7"}}) {
    const Invocation told = invocation(words);
    EXPECT_EQ(told.common.network.domain, 7);
    EXPECT_TRUE(told.common.json);
    EXPECT_TRUE(std::holds_alternative<ModelsOptions>(told.command));
  }
}

TEST(CommandLine, ReadsAGrasp) {
  const Invocation told = invocation(
      grasp({"--place",   "-0.1",     "0",     "1e-2",     "0",     "-1",     "0",
             "0",         "--solver", "slsqp", "--starts", "8",     "--seed", "3",
             "--weights", "1e4",      "1",     "0",        "--out", "a.json", "--keep"}));
  const auto& options = std::get<GraspOptions>(told.command);
  EXPECT_EQ(options.hand, "human20");
  ASSERT_TRUE(options.place.has_value());
  EXPECT_EQ((*options.place)[0], -0.1);
  EXPECT_EQ((*options.place)[4], -1.0);
  ASSERT_TRUE(options.weights.has_value());
  EXPECT_EQ((*options.weights)[0], 1e4);
  EXPECT_EQ(options.solver, "slsqp");
  EXPECT_EQ(options.starts, 8U);
  EXPECT_EQ(options.seed, 3U);
  EXPECT_EQ(options.out, "a.json");
  EXPECT_TRUE(options.png.empty());
  EXPECT_TRUE(options.keep);
}

TEST(CommandLine, ReadsHowThePoseIsSearched) {
  const auto options = std::get<GraspOptions>(
      invocation(grasp({"--solver", "all", "--max-evaluations", "250", "--normal-form", "sum",
                        "--touch-only", "--choose", "3"}))
          .command);
  EXPECT_EQ(options.solver, "all");
  EXPECT_EQ(options.max_evaluations, 250U);
  EXPECT_EQ(options.normal_form, v1::NORMAL_SUM);
  EXPECT_TRUE(options.touch_only);
  EXPECT_EQ(options.choose, 3U);
  EXPECT_FALSE(options.paper);
  const auto paper = std::get<GraspOptions>(invocation(grasp({"--paper"})).command);
  EXPECT_TRUE(paper.paper);
  EXPECT_EQ(paper.normal_form, v1::NORMAL_COSINE);
  EXPECT_EQ(paper.choose, 0U);
}

TEST(CommandLine, NamesWhatNoSolveTakesBeforeAServerIsAsked) {
  EXPECT_THAT(objectionTo(grasp({"--solver", "magic"})),
              AllOf(HasSubstr("'magic'"), HasSubstr("lm mma")));
  EXPECT_THAT(objectionTo(grasp({"--solver", ""})), HasSubstr("--solver: '' is no solver"));
  EXPECT_THAT(objectionTo({"sweep", "--hand", "h", "--contacts-dir", ".", "--vary",
                           "a.upper=1,2", "--solver", "magic"}),
              HasSubstr("'magic' is no solver"));
  EXPECT_THAT(
      objectionTo(grasp({"--seed", "18446744073709551615"})),
      HasSubstr("--seed: '18446744073709551615' is no whole number from 0 to 2^32 - 1"));
  EXPECT_THAT(objectionTo(grasp({"--starts", "10001"})), HasSubstr("0 to 10000"));
  EXPECT_THAT(objectionTo(grasp({"--max-evaluations", "100001"})), HasSubstr("0 to 100000"));
  EXPECT_THAT(objectionTo(grasp({"--normal-form", "sine"})), HasSubstr("cosine or sum"));
  EXPECT_THAT(objectionTo(grasp({"--paper", "--solver", "slsqp"})), HasSubstr("'slsqp'"));
  EXPECT_THAT(objectionTo(grasp({"--paper", "--starts", "4"})), HasSubstr("--starts 4"));
  EXPECT_THAT(objectionTo(grasp({"--paper", "--choose", "2"})), HasSubstr("--choose 2"));
  EXPECT_THAT(objectionTo(grasp({"--choose", "0"})), HasSubstr("1 to 8"));
  EXPECT_THAT(objectionTo(grasp({"--choose", "9"})), HasSubstr("1 to 8"));
}

TEST(CommandLine, ReadsHowPatchesAreLaidOut) {
  const Invocation told = invocation(grasp({"--log-map", "exact", "--interior", "3"}));
  EXPECT_EQ(std::get<GraspOptions>(told.command).log_map, "exact");
  EXPECT_EQ(std::get<GraspOptions>(told.command).interior_rings, 3U);
  EXPECT_THAT(objectionTo(grasp({"--interior", "-1"})), HasSubstr("--interior: '-1'"));
}

TEST(CommandLine, ReadsTransferAndSuggest) {
  EXPECT_EQ(std::get<TransferOptions>(invocation({"transfer", "42"}).command).session_id, 42U);
  const Invocation told = invocation(
      {"suggest", "42", "palm", "--reach", "12.5", "--count", "3", "--apply", "2", "--json"});
  const auto& options = std::get<SuggestOptions>(told.command);
  EXPECT_TRUE(told.common.json);
  EXPECT_EQ(options.session_id, 42U);
  EXPECT_EQ(options.patch, "palm");
  EXPECT_EQ(options.reach_mm, 12.5);
  EXPECT_EQ(options.count, 3U);
  EXPECT_EQ(options.apply, 2U);
  EXPECT_EQ(std::get<SuggestOptions>(invocation({"suggest", "1", "a"}).command).reach_mm, 0.0);
}

TEST(CommandLine, RefusesSuggestionsOutOfRange) {
  for (const char* reach : {"0", "-1", "100.5", "nan", "inf"}) {
    EXPECT_THAT(objectionTo({"suggest", "1", "palm", "--reach", reach}),
                HasSubstr("0.1 to 100"))
        << reach;
  }
  EXPECT_THAT(objectionTo({"suggest", "1", "palm", "--count", "0"}), HasSubstr("1 to 100"));
  EXPECT_THAT(objectionTo({"suggest", "1", "palm", "--count", "101"}),
              HasSubstr("--count 101"));
  EXPECT_THAT(objectionTo({"suggest", "1", "palm", "--apply", "0"}), HasSubstr("from 1"));
  EXPECT_THAT(objectionTo({"suggest", "1", "palm", "--apply", "-1"}),
              HasSubstr("--apply: '-1'"));
  EXPECT_THAT(objectionTo({"suggest", "1"}), HasSubstr("patch"));
  EXPECT_THAT(objectionTo({"transfer"}), HasSubstr("session"));
  EXPECT_THAT(objectionTo({"transfer", "-1"}), HasSubstr("-1"));
}

TEST(CommandLine, LeavesTheWeightsAndThePlaceToTheServer) {
  const Invocation told = invocation(grasp({}));
  EXPECT_FALSE(std::get<GraspOptions>(told.command).place.has_value());
  EXPECT_FALSE(std::get<GraspOptions>(told.command).weights.has_value());
}

TEST(CommandLine, ReadsAnEditor) {
  const auto of = [](const std::vector<std::string>& words) {
    return std::get<EditOptions>(invocation(words).command);
  };
  EXPECT_EQ(of({"edit", "7", "--script", "a.hg"}).session_id, 7U);
  EXPECT_EQ(of({"edit", "7", "--script", "a.hg"}).script, "a.hg");
  const EditOptions opened = of({"edit", "--hand", "human20", "--object", "lemon", "--contacts",
                                 "lemon_6", "--solver", "slsqp"});
  EXPECT_EQ(opened.session_id, 0U);
  EXPECT_EQ(opened.grasp.hand, "human20");
  EXPECT_EQ(opened.grasp.solver, "slsqp");
  EXPECT_THAT(objectionTo({"edit"}), HasSubstr("session"));
  EXPECT_THAT(objectionTo({"edit", "0"}), HasSubstr("edit 0"));
  EXPECT_THAT(objectionTo({"edit", "--hand", "human20"}), HasSubstr("--object"));
  EXPECT_THAT(objectionTo({"edit", "7", "--hand", "human20"}), HasSubstr("another session"));
  EXPECT_THAT(objectionTo({"edit", "7", "--solver", "lm"}), HasSubstr("--solver"));
  EXPECT_THAT(objectionTo({"edit", "7", "--mirror"}), HasSubstr("--mirror"));
  EXPECT_THAT(objectionTo({"skin", "human20", "--out", "my", "skin.ply"}),
              HasSubstr("--out takes one word, 'my'; 'skin.ply' is one too many, a name with "
                        "blanks needs quotes"));
}

TEST(CommandLine, ReadsWhatToView) {
  const auto of = [](const std::vector<std::string>& words) {
    return std::get<ViewOptions>(invocation(words).command);
  };
  EXPECT_EQ(of({"view", "7"}).session_id, 7U);
  EXPECT_EQ(of({"view", "grasp.session.json"}).file, "grasp.session.json");
  EXPECT_EQ(of({"view"}).session_id, 0U);
  EXPECT_EQ(of({"view"}).address, "127.0.0.1");
  EXPECT_TRUE(of({"view"}).open_browser);
  const ViewOptions opened = of({"view", "--hand", "human20", "--object", "lemon", "--contacts",
                                 "lemon_6", "--port", "8080", "--read-only", "--no-browser"});
  EXPECT_EQ(opened.grasp.hand, "human20");
  EXPECT_EQ(opened.port, 8080);
  EXPECT_TRUE(opened.read_only);
  EXPECT_FALSE(opened.open_browser);
  EXPECT_THAT(objectionTo({"view", "0"}), HasSubstr("view 0"));
  EXPECT_THAT(objectionTo({"view", "7", "--hand", "human20"}), HasSubstr("another session"));
  EXPECT_THAT(objectionTo({"view", "--hand", "human20"}), HasSubstr("--object"));
  EXPECT_THAT(objectionTo({"view", "--port", "65536"}), HasSubstr("--port"));
}

TEST(CommandLine, ReadsExportsAndSessionFiles) {
  const auto exported = std::get<ExportOptions>(
      invocation({"export", "7", "--format", "glb", "--out", "a"}).command);
  EXPECT_EQ(exported.session_id, 7U);
  EXPECT_EQ(exported.format, "glb");
  EXPECT_EQ(exported.out, "a");
  const auto saved =
      std::get<SaveOptions>(invocation({"session", "save", "7", "s.json"}).command);
  EXPECT_EQ(saved.session_id, 7U);
  EXPECT_EQ(saved.path, "s.json");
  const auto replayed = std::get<ReplayOptions>(
      invocation({"session", "replay", "s.json", "--out", "t.json", "--domain", "3"}).command);
  EXPECT_EQ(replayed.path, "s.json");
  EXPECT_EQ(replayed.out, "t.json");
  EXPECT_EQ(std::get<OpenFileOptions>(invocation({"session", "load", "s.json"}).command).path,
            "s.json");
  EXPECT_THAT(objectionTo({"session"}), HasSubstr("save, load, replay"));
  EXPECT_THAT(objectionTo({"export", "7"}), HasSubstr("--format"));
  EXPECT_THAT(
      objectionTo({"export", "7", "--format", "GLB", "--out", "a"}),
      HasSubstr("'GLB': there are json, csv, obj, glb, isaac_grasp, problem, npz, mjcf, "
                "ros_trajectory, html"));
}

TEST(CommandLine, NamesTheOptionThatIsWrong) {
  EXPECT_THAT(objectionTo({}), HasSubstr("subcommand"));
  EXPECT_THAT(objectionTo({"dance"}), HasSubstr("dance"));
  EXPECT_THAT(objectionTo({"doctor", "--frob"}), HasSubstr("--frob"));
  EXPECT_THAT(objectionTo({"doctor", "--domain", "101"}), HasSubstr("0-100"));
  EXPECT_THAT(objectionTo({"doctor", "--domain", "many"}), HasSubstr("--domain"));
  EXPECT_THAT(objectionTo({"doctor", "--interface", "no such"}), HasSubstr("no such"));
  EXPECT_THAT(objectionTo({"grasp", "--hand", "human20", "--object", "box"}),
              HasSubstr("--contacts"));
  EXPECT_THAT(objectionTo(grasp({"--place", "0", "0", "0", "nan", "0", "0", "0"})),
              HasSubstr("--place"));
  EXPECT_THAT(objectionTo(grasp({"--place", "0", "0", "0"})), HasSubstr("--place"));
  EXPECT_THAT(objectionTo(grasp({"--weights", "1", "-1", "1"})), HasSubstr("--weights"));
  EXPECT_THAT(objectionTo(grasp({"--weights", "1", "inf", "1"})), HasSubstr("--weights"));
  EXPECT_THAT(objectionTo(grasp({"--seed", "-1"})), HasSubstr("--seed"));
  EXPECT_THAT(objectionTo(grasp({"--starts", "1.5"})), HasSubstr("--starts"));
  EXPECT_THAT(objectionTo(grasp({"--package", "lonely"})), HasSubstr("NAME=DIR"));
  EXPECT_THAT(objectionTo(grasp({"--package", "a=/no/such/folder"})), HasSubstr("no folder"));
  EXPECT_THAT(objectionTo({"grasp", "--hand", "bad name", "--object", "o", "--contacts", "c"}),
              HasSubstr("bad name"));
  EXPECT_THAT(objectionTo({"watch", "first"}), HasSubstr("first"));
  EXPECT_THAT(objectionTo({"models", "show", "glove", "x"}), HasSubstr("glove"));
  EXPECT_THAT(objectionTo({"load", "hand", "x.urdf", "--object", "box"}),
              HasSubstr("--object"));
  EXPECT_THAT(objectionTo({"load", "hand", "x.urdf", "--name", "-x/"}), HasSubstr("--name"));
}

TEST(CommandLine, RefusesCountsThatAreNoneAndEmptyNames) {
  EXPECT_THAT(objectionTo({"watch", "-1"}), HasSubstr("-1"));
  EXPECT_THAT(objectionTo({"watch", "7", "--count", "-1"}), HasSubstr("--count: '-1'"));
  EXPECT_THAT(objectionTo({"watch", "7", "--count=-1"}), HasSubstr("--count: '-1'"));
  EXPECT_THAT(objectionTo({"watch", "99999999999999999999"}),
              HasSubstr("99999999999999999999"));
  EXPECT_THAT(objectionTo({"close", "-1"}), HasSubstr("-1"));
  EXPECT_THAT(objectionTo(grasp({"--starts", "-2"})), HasSubstr("--starts: '-2'"));
  EXPECT_THAT(objectionTo(grasp({"--seed", "-3"})), HasSubstr("--seed: '-3'"));
  EXPECT_THAT(objectionTo(grasp({"--seed", "4294967296"})), HasSubstr("--seed"));
  EXPECT_THAT(objectionTo(grasp({"--weights", "0", "0", "0"})), HasSubstr("--weights 0 0 0"));
  EXPECT_EQ(objectionTo(grasp({"--weights", "0", "0", "1"})), "");
  for (const char* option : {"--out", "--png", "--problem"}) {
    EXPECT_THAT(objectionTo(grasp({option, ""})), HasSubstr(option));
  }
}

TEST(CommandLine, RefusesPicturesWhoseNamesSayThatTheyAreNoPng) {
  EXPECT_THAT(objectionTo(grasp({"--png", "grasp.jpg"})),
              AllOf(HasSubstr("--png"), HasSubstr("'grasp.jpg'"), HasSubstr(".png")));
  EXPECT_THAT(objectionTo({"bridge", "plot", "run.csv", "--out", "run.svg"}),
              HasSubstr(".png"));
  for (const char* name : {"a.png", "a.PNG", "/dev/stdout"})
    EXPECT_EQ(objectionTo(grasp({"--png", name})), "") << name;
}

TEST(CommandLine, ReadsWhatToCloseAndUnload) {
  EXPECT_EQ(std::get<CloseOptions>(invocation({"close", "42"}).command).session_id, 42U);
  const Invocation unload = invocation({"unload", "object", "bowl", "--json"});
  EXPECT_TRUE(unload.common.json);
  EXPECT_EQ(std::get<UnloadOptions>(unload.command).kind, v1::MODEL_OBJECT);
  EXPECT_EQ(std::get<UnloadOptions>(unload.command).name, "bowl");
  EXPECT_THAT(objectionTo({"unload", "glove", "x"}), HasSubstr("glove"));
  EXPECT_THAT(objectionTo({"unload", "hand", "a/b"}), HasSubstr("a/b"));
  EXPECT_THAT(objectionTo({"close"}), HasSubstr("session"));
}

TEST(CommandLine, PrintsHelpAndVersionInsteadOfRunning) {
  EXPECT_THAT(std::get<Printout>(parse({"--version"})).text, HasSubstr("handgraft "));
  EXPECT_THAT(std::get<Printout>(parse({"grasp", "--help"})).text, HasSubstr("--contacts"));
}

}  // namespace
}  // namespace handgraft::client
