#include "client/editor/command_table.h"

#include <fstream>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/client/editor/small_context.h"
#include "tests/support/shared_data.h"

namespace handgraft::client::editor {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Parsed parsed(const std::string& line) {
  return parse(commandsOf(line).at(0), test::smallNames());
}

std::string objectionTo(const std::string& line) {
  try {
    parsed(line);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(CommandTable, EveryRowIsReadAsItself) {
  for (const Command& command : commandTable()) {
    // A command from its own pattern: each kind by an example.
    const Pattern pattern = patternOf(command.pattern);
    const auto example = [](const Slot& slot) -> std::string {
      switch (slot.kind) {
        case Kind::kLiteral:
          return slot.literal;
        case Kind::kPatch:
          return "thumb";
        case Kind::kJoint:
          return "bend";
        case Kind::kSite:
        case Kind::kPoint:
          return "palm";
        case Kind::kSide:
          return "object";
        case Kind::kFormat:
          return "json";
        case Kind::kTopic:
          return "joints";
        case Kind::kSolver:
          return "lm";
        case Kind::kNormalForm:
          return "sum";
        case Kind::kCommand:
          return "solve";
        case Kind::kHand:
        case Kind::kObject:
        case Kind::kName:
        case Kind::kSnapshot:
        case Kind::kFile:
          return "some_name";
        default:
          return "1";
      }
    };
    Words words;
    for (const Slot& slot : pattern.slots)
      words.push_back(example(slot));
    for (const OptionSlot& option : pattern.options) {
      words.push_back(option.name);
      for (const Slot& slot : option.value)
        words.push_back(example(slot));
    }
    const Parsed result = parse(words, test::smallNames());
    EXPECT_EQ(result.command, &command) << command.pattern;
    EXPECT_EQ(result.match.options.size(), pattern.options.size()) << command.pattern;
    EXPECT_EQ(command.action == Action::kEdit, command.make != nullptr) << command.pattern;
    EXPECT_FALSE(command.help.empty()) << command.pattern;
  }
}

TEST(CommandTable, KeepsCommandsOfOneNameTogether) {
  std::set<std::string> seen;
  for (const std::string& name : commandNames())
    EXPECT_TRUE(seen.insert(name).second) << name;
}

TEST(CommandTable, ReadsValuesWithTheirUnits) {
  const Parsed turned = parsed("dir thumb +15deg");
  EXPECT_NEAR(turned.match.values.at(1).number, 0.26179938779914941, 1e-15);
  const Parsed dragged = parsed("drag index_tip to 20mm -3cm 0.1");
  EXPECT_EQ(dragged.match.values.at(1).number, 0.02);
  EXPECT_EQ(dragged.match.values.at(2).number, -0.03);
  EXPECT_EQ(dragged.match.values.at(3).number, 0.1);
  const Parsed solved = parsed("solve --starts 64 --paper");
  EXPECT_EQ(solved.match.options.at("--starts").count, 64U);
  EXPECT_EQ(solved.match.options.count("--paper"), 1U);
}

TEST(CommandTable, NamesTheWordThatIsWrongAndWhatIsPermitted) {
  EXPECT_THAT(objectionTo("lokc bend"),
              AllOf(HasSubstr("'lokc'"), HasSubstr("did you mean lock")));
  EXPECT_THAT(objectionTo("frobnicate"), AllOf(HasSubstr("frobnicate"), HasSubstr("help")));
  EXPECT_THAT(objectionTo("frobnicate"), Not(HasSubstr("did you mean")));
  EXPECT_THAT(objectionTo("lock bent"),
              AllOf(HasSubstr("'bent' is no joint"), HasSubstr("bend, slide")));
  EXPECT_THAT(objectionTo("limit bend_2 upper 0.5"),
              HasSubstr("'bend_2' follows joint 'bend' and cannot be moved by itself"));
  EXPECT_THAT(objectionTo("weight pinkie 1"),
              AllOf(HasSubstr("'pinkie' is no patch"), HasSubstr("thumb, index")));
  EXPECT_THAT(objectionTo("limit bend uper 0.6"),
              AllOf(HasSubstr("'uper'"), HasSubstr("lower, upper, range, reset")));
  EXPECT_THAT(objectionTo("limit bend"), HasSubstr("lower, upper, range, reset"));
  EXPECT_THAT(objectionTo("limit bend upper"), HasSubstr("VALUE"));
  EXPECT_THAT(objectionTo("limit bend upper 0.6x"), HasSubstr("'0.6x' is no joint value"));
  EXPECT_THAT(objectionTo("dir thumb 20mm"), HasSubstr("'20mm'"));
  EXPECT_THAT(objectionTo("weights 1 2"), HasSubstr("NUMBER"));
  EXPECT_THAT(objectionTo("weights 1 2 3 4"), AllOf(HasSubstr("'4'"), HasSubstr("nothing")));
  EXPECT_THAT(objectionTo("weights 1 2 3 deg"),
              AllOf(HasSubstr("'deg'"), HasSubstr("write 3deg")));
  EXPECT_THAT(objectionTo("solve --solvr lm"),
              AllOf(HasSubstr("'--solvr'"), HasSubstr("--solver")));
  EXPECT_THAT(objectionTo("solve --paper --paper"), HasSubstr("--paper"));
  EXPECT_THAT(objectionTo("undo -1"), HasSubstr("'-1' is no whole number"));
  EXPECT_THAT(objectionTo("save ''"), HasSubstr("empty"));
  EXPECT_THAT(objectionTo("weight thumb nan"), HasSubstr("'nan'"));
}

TEST(CommandTable, LeavesModelsToTheServerAndKnowsFormats) {
  EXPECT_EQ(objectionTo("hand somebodys"), "");
  EXPECT_THAT(objectionTo("export stl a.stl"), HasSubstr("there are json, csv, obj, glb"));
  EXPECT_THAT(helpFor({"export"}, {}), HasSubstr("FORMAT: json, csv, obj, glb"));
  EXPECT_EQ(objectionTo("restore later"), "");
}

TEST(Completion, OffersCommandsNamesAndWords) {
  const Names names = test::smallNames();
  EXPECT_THAT(completions({}, "un", names), ElementsAre("undo", "unlock"));
  EXPECT_THAT(completions({"limit"}, "", names), ElementsAre("bend", "slide"));
  EXPECT_THAT(completions({"limit", "bend"}, "", names),
              ElementsAre("lower", "range", "reset", "upper"));
  EXPECT_THAT(completions({"root"}, "t", names), ElementsAre("thumb"));
  EXPECT_THAT(completions({"root", "thumb", "hand"}, "", names),
              ElementsAre("at", "face", "pick"));
  EXPECT_THAT(completions({"root", "thumb", "object"}, "", names), ElementsAre("at", "face"));
  EXPECT_THAT(completions({"drag"}, "index", names), ElementsAre("index", "index_tip"));
  EXPECT_THAT(completions({"hand"}, "", names), ElementsAre("allegro16", "barrett8"));
  EXPECT_THAT(completions({"join"}, "1", names), ElementsAre("12"));
  EXPECT_THAT(completions({"restore"}, "", names), ElementsAre("before"));
  EXPECT_THAT(completions({"help"}, "sol", names), ElementsAre("solve", "solver"));
  EXPECT_THAT(completions({"solve", "--paper"}, "--s", names),
              ElementsAre("--seed", "--solver", "--starts"));
  EXPECT_THAT(completions({"solve", "--solver"}, "l", names), ElementsAre("lbfgs", "lm"));
  EXPECT_THAT(completions({"limit", "bent"}, "", names), IsEmpty());
  EXPECT_THAT(completions({"undo", "2"}, "", names), IsEmpty());
}

TEST(Completion, OffersFiles) {
  const std::filesystem::path folder = test::scratchDirectory() / "completion";
  std::filesystem::create_directories(folder / "shelf");
  std::ofstream(folder / "session.json") << "{}";
  std::ofstream(folder / ".hidden") << "";
  const std::string begin = folder.string() + "/";
  EXPECT_THAT(completions({"load"}, begin, {}),
              ElementsAre(begin + "session.json", begin + "shelf/"));
  EXPECT_THAT(completions({"load"}, begin + "se", {}), ElementsAre(begin + "session.json"));
  EXPECT_THAT(completions({"load"}, "/no/such/folder/", {}), IsEmpty());
}

TEST(Help, TellsWhatMayFollow) {
  const std::string all = helpFor({}, {});
  for (const Command& command : commandTable())
    EXPECT_THAT(all, HasSubstr(std::string(command.pattern))) << command.pattern;
  const std::string limits = helpFor({"limit", "bend"}, test::smallNames());
  EXPECT_THAT(limits,
              AllOf(HasSubstr("limit JOINT upper VALUE"), Not(HasSubstr("lock JOINT"))));
}

// The page's table is this one.
TEST(Help, StandsInItsPage) {
  std::ifstream file(test::sourceDirectory() / "client" / "editor" / "COMMANDS.md");
  std::ostringstream text;
  text << file.rdbuf();
  for (const Command& command : commandTable()) {
    EXPECT_THAT(text.str(),
                HasSubstr(fmt::format("| `{}` | {} |", command.pattern, command.help)));
  }
}

}  // namespace
}  // namespace handgraft::client::editor
