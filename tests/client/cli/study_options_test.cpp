// What `sweep` and `hand vary` take, and how they say what is wrong with it.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "client/cli/study/study_files.h"
#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::variant<Invocation, Printout> parse(const std::vector<std::string>& words) {
  std::vector<const char*> argv = {"handgraft"};
  for (const std::string& word : words)
    argv.push_back(word.c_str());
  return parseCommandLine(static_cast<int>(argv.size()), argv.data());
}

SweepOptions sweepWith(const std::vector<std::string>& more) {
  std::vector<std::string> words = {"sweep", "--hand", "human20", "--contacts-dir", "sets"};
  words.insert(words.end(), more.begin(), more.end());
  return std::get<SweepOptions>(std::get<Invocation>(parse(words)).command);
}

template <class Call>
std::string objectionTo(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "";
}

std::string objectionTo(const char* axis) {
  return objectionTo([&] {
    (void)axisFrom(axis);
  });
}

TEST(StudyAxis, RunsFromOneEndToTheOther) {
  const StudyAxis axis = axisFrom("thumb_mcp.upper=0.5:1.6:12");
  EXPECT_EQ(axis.name, "thumb_mcp.upper");
  EXPECT_EQ(axis.axis.property(), v1::PROPERTY_UPPER);
  EXPECT_EQ(axis.axis.target(), "thumb_mcp");
  ASSERT_EQ(axis.axis.values().size(), 12u);
  EXPECT_EQ(axis.axis.values().front(), 0.5);
  EXPECT_EQ(axis.axis.values().back(), 1.6);
  EXPECT_NEAR(axis.axis.values()[1] - axis.axis.values()[0], 0.1, 1e-12);
  EXPECT_THAT(axisFrom("thumb_mcp.upper=-1e308:1e308:3").axis.values(),
              ElementsAre(-1e308, 0.0, 1e308));  // further apart than the largest number
}

TEST(StudyAxis, TakesListsAndNamesWithDots) {
  const StudyAxis axis = axisFrom("link_1.0.length=1.2,0.9,1");
  EXPECT_EQ(axis.axis.property(), v1::PROPERTY_LENGTH);
  EXPECT_EQ(axis.axis.target(), "link_1.0");
  EXPECT_THAT(axis.axis.values(), ElementsAre(1.2, 0.9, 1.0));
  EXPECT_EQ(axisFrom("joint_3.0.range=0.5").axis.target(), "joint_3.0");
}

TEST(StudyAxis, TheHandsSizeHasNoTarget) {
  EXPECT_EQ(axisFrom("hand.size=0.8:1.2:3").axis.target(), "");
  EXPECT_EQ(axisFrom("palm.size=1.1").axis.target(), "palm");
}

TEST(StudyAxis, TakesDegrees) {
  const StudyAxis axis = axisFrom("thumb.lower=-90deg:45deg:4");
  EXPECT_TRUE(axis.in_degrees);
  EXPECT_NEAR(axis.axis.values()[0], -1.5707963267948966, 1e-12);
  EXPECT_NEAR(axis.shown(axis.axis.values()[3]), 45.0, 1e-12);
  EXPECT_NEAR(changeFrom("thumb.upper=180deg").value(), 3.141592653589793, 1e-12);
  const StudyAxis from_nought = axisFrom("thumb.upper=0:45deg:4");
  EXPECT_TRUE(from_nought.in_degrees);
  EXPECT_NEAR(from_nought.axis.values()[3], 0.7853981633974483, 1e-12);
  EXPECT_TRUE(axisFrom("thumb.upper=0,45deg").in_degrees);
}

TEST(StudyAxis, NamesWhatIsWrong) {
  for (const char* form :
       {"", "thumb.upper", "thumb=1:2:3", ".upper=1", "thumb.upper=1:2", "thumb.upper=1:2:3:4"})
    EXPECT_THAT(objectionTo(form), HasSubstr("FROM:TO:COUNT")) << form;
  try {
    changeFrom("foo");
    ADD_FAILURE() << "'foo' was taken for a change";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("it must be NAME.PROPERTY=VALUE"),
                                    testing::Not(HasSubstr("FROM"))));
  }
  EXPECT_THAT(objectionTo([&] {
                (void)changeFrom("thumb.upper=0:45deg");
              }),
              HasSubstr("one hand has one value"));
  EXPECT_THAT(objectionTo("thumb.colour=1"),
              AllOf(HasSubstr("'colour'"), HasSubstr("lower, upper")));
  EXPECT_THAT(objectionTo("thumb.upper=1,x"), HasSubstr("'x' is no number"));
  EXPECT_THAT(objectionTo("thumb.upper=1,"), HasSubstr("'' is no number"));
  EXPECT_THAT(objectionTo("thumb.upper=nan"), HasSubstr("'nan' is no number"));
  EXPECT_THAT(objectionTo("thumb.upper=0:1:1"), HasSubstr("COUNT '1' must be 2 to 10000"));
  EXPECT_THAT(objectionTo("thumb.upper=0:1:2.5"), HasSubstr("COUNT '2.5'"));
  EXPECT_THAT(objectionTo("thumb.upper=0:1:99999999999"), HasSubstr("COUNT"));
  EXPECT_THAT(objectionTo("thumb.upper=30:90deg:7"), HasSubstr("different units"));
  EXPECT_THAT(objectionTo("jaw.upper=0:30mm:7"),
              AllOf(HasSubstr("'30mm'"), HasSubstr("in metres"), HasSubstr("write 0.03")));
  EXPECT_THAT(objectionTo("thumb.upper=30,90deg"), HasSubstr("degrees"));
  EXPECT_THAT(objectionTo("palm.size=30deg"), HasSubstr("no unit"));
}

TEST(StudyOptions, ReadASweep) {
  const SweepOptions sweep =
      sweepWith({"--vary", "thumb_mcp.upper=0.5:1.6:12", "--vary", "hand.size=0.9,1.1",
                 "--object", "lemon", "--starts", "8", "--weights", "1", "2", "3", "--out",
                 "table.csv", "--png", "plot.png"});
  EXPECT_EQ(sweep.hand, "human20");
  EXPECT_EQ(sweep.folders.contacts, "sets");
  EXPECT_EQ(sweep.folders.object, "lemon");
  EXPECT_EQ(sweep.axes.size(), 2u);
  EXPECT_EQ(sweep.starts, 8u);
  EXPECT_EQ((*sweep.weights)[2], 3.0);
  EXPECT_EQ(sweep.out, "table.csv");
  EXPECT_EQ(sweep.png, "plot.png");
}

TEST(StudyOptions, NameWhatIsWrongWithASweep) {
  const auto objection = [](const std::vector<std::string>& more) {
    return objectionTo([&] {
      (void)sweepWith(more);
    });
  };
  EXPECT_THAT(objection({}), HasSubstr("--vary"));
  EXPECT_THAT(objection({"--vary", "thumb"}), HasSubstr("'thumb'"));
  EXPECT_THAT(objection({"--vary", "a.upper=1", "--vary", "a.upper=2"}),
              HasSubstr("a.upper is varied already"));
  EXPECT_THAT(objection({"--vary", "a.upper=1", "--vary", "b.upper=1", "--vary", "c.upper=1",
                         "--png", "p.png"}),
              AllOf(HasSubstr("--png p.png"), HasSubstr("one property or two")));
  EXPECT_THAT(objection({"--vary", "a.upper=1", "--object", "lemon", "--object-dir", "x"}),
              AllOf(HasSubstr("--object lemon"), HasSubstr("--object-dir x")));
  EXPECT_THAT(objection({"--vary", "a.upper=1", "--mirror"}), HasSubstr("--mirror"));
}

TEST(StudyOptions, ReadAVariant) {
  const auto vary = std::get<VaryOptions>(
      std::get<Invocation>(
          parse({"hand", "vary", "human20", "--set", "thumb_mcp.upper=1.2", "--set",
                 "index_distal.length=1.1", "--name", "my_variant", "--urdf", "v.urdf"}))
          .command);
  EXPECT_EQ(vary.hand, "human20");
  EXPECT_EQ(vary.name, "my_variant");
  EXPECT_EQ(vary.urdf, "v.urdf");
  ASSERT_EQ(vary.changes.size(), 2u);
  EXPECT_EQ(vary.changes[0].value(), 1.2);
  EXPECT_EQ(vary.changes[1].property(), v1::PROPERTY_LENGTH);
  EXPECT_THAT(objectionTo([] {
                (void)parse({"hand", "vary", "human20", "--set", "thumb_mcp.upper=1:2:3",
                             "--name", "v"});
              }),
              HasSubstr("'1:2:3' is no number"));
}

// === Folders

class StudyFilesTest : public testing::Test {
 protected:
  StudyFilesTest() {
    static int count = 0;
    folder = test::scratchDirectory() / ("study" + std::to_string(count++));
    fs::create_directories(folder / "objects");
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }

  fs::path folder;
};

TEST_F(StudyFilesTest, FindTheObjectThatEachSetNames) {
  write("b.json", R"({"object": "cup", "patches": []})");
  write("a.json", R"({"object": "lemon", "patches": []})");
  write("cup.stl", "solid");
  write("notes.json", R"({"some": "thing"})");
  write("map.ply", "ply");
  const FoundGrasps found = findGrasps({folder, "", ""});
  ASSERT_EQ(found.grasps.size(), 2u);
  EXPECT_EQ(found.grasps[0].label, "a");
  EXPECT_EQ(found.grasps[0].object, "lemon") << "the server's";
  EXPECT_EQ(found.grasps[1].object, (folder / "cup.stl").string());
  ASSERT_EQ(found.skipped.size(), 1u);
  EXPECT_EQ(found.skipped[0].path, folder / "notes.json");
  EXPECT_EQ(found.skipped[0].reason, "no contact set and no motion");
}

TEST_F(StudyFilesTest, LeaveOutWhatIsOfAnotherKindOrDamaged) {
  write("a.json", R"({"format": "handgraft-contacts/1", "object": "cup", "patches": []})");
  write("cut.json", R"({"format": "handgraft-contacts/1", "obj)");
  write("grasp.json", R"({"format": "handgraft-grasp/1", "object": "cup", "patches": []})");
  const FoundGrasps found = findGrasps({folder, "", ""});
  ASSERT_EQ(found.grasps.size(), 1u);
  EXPECT_EQ(found.grasps[0].label, "a");
  ASSERT_EQ(found.skipped.size(), 2u);
  EXPECT_EQ(found.skipped[0].path, folder / "cut.json");
  EXPECT_THAT(found.skipped[0].reason, HasSubstr("line 1"));
  EXPECT_EQ(found.skipped[1].path, folder / "grasp.json");
  EXPECT_THAT(found.skipped[1].reason, HasSubstr("handgraft-grasp/1"));
}

TEST_F(StudyFilesTest, TakeMotionsBesideSets) {
  write("a.json", R"({"object": "cup", "patches": []})");
  write("b.json", R"({"format": "handgraft-motion/1", "object": "cup", "tracks": []})");
  write("cup.stl", "solid");
  StudyFolders folders{folder, "", ""};
  folders.motions = {"pull", (folder / "b.json").string()};
  const FoundGrasps found = findGrasps(folders);
  ASSERT_EQ(found.grasps.size(), 4u);
  EXPECT_FALSE(found.grasps[0].isMotion());
  EXPECT_EQ(found.grasps[1].label, "b");
  EXPECT_EQ(found.grasps[1].motion, (folder / "b.json").string());
  EXPECT_EQ(found.grasps[1].object, (folder / "cup.stl").string());
  EXPECT_TRUE(found.grasps[1].contacts.empty());
  EXPECT_EQ(found.grasps[2].motion, "pull");
  EXPECT_EQ(found.grasps[2].object, "") << "the server's motion tells it";
  EXPECT_EQ(found.grasps[3].object, (folder / "cup.stl").string());
}

TEST_F(StudyFilesTest, TakeMapsWhereTheirObjectsAre) {
  write("mug_large_grasp0.ply", "ply");
  write("objects/mug.obj", "v 0 0 0");
  write("objects/mug_large.obj", "v 0 0 0");
  const FoundGrasps found = findGrasps({folder, folder / "objects", ""});
  ASSERT_EQ(found.grasps.size(), 1u);
  EXPECT_EQ(found.grasps[0].object, (folder / "objects/mug_large.obj").string());
  EXPECT_EQ(findGrasps({folder, "", "box"}).grasps[0].object, "box");
}

TEST_F(StudyFilesTest, NameWhatIsMissing) {
  const auto objection = [](const StudyFolders& folders) {
    return objectionTo([&] {
      (void)findGrasps(folders);
    });
  };
  EXPECT_THAT(objection({folder / "nowhere", "", ""}),
              AllOf(HasSubstr("--contacts-dir"), HasSubstr("no such folder")));
  EXPECT_THAT(objection({folder, "", ""}), HasSubstr("no contact set"));
  write("map.ply", "ply");
  EXPECT_THAT(objection({folder, folder / "objects", ""}), HasSubstr("map.ply"));
  fs::remove(folder / "map.ply");
  write("a.json", R"({"patches": []})");
  EXPECT_THAT(objection({folder, "", ""}), AllOf(HasSubstr("a.json"), HasSubstr("--object")));
  StudyFolders motion;
  motion.motions = {(folder / "a.json").string()};
  EXPECT_THAT(objection(motion), AllOf(HasSubstr("--motion"), HasSubstr("no motion")));
}

}  // namespace
}  // namespace handgraft::client
