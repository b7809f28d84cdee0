#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "core/base/error.h"

namespace handgraft::client {
namespace {

using testing::HasSubstr;

std::variant<Invocation, Printout> parse(const std::vector<std::string>& words) {
  std::vector<const char*> argv = {"handgraft"};
  for (const std::string& word : words)
    argv.push_back(word.c_str());
  return parseCommandLine(static_cast<int>(argv.size()), argv.data());
}

template <class Options>
Options options(const std::vector<std::string>& words) {
  return std::get<Options>(std::get<Invocation>(parse(words)).command);
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

TEST(ImportOptions, ReadHowAHandIsToBeRead) {
  const auto inspect = options<InspectOptions>(
      {"hand",    "inspect", "--package", "my_pkg=/tmp", "my.urdf",    "--mirror",
       "--srdf",  "my.srdf", "--rest",    "fist",        "--surfaces", "collisions",
       "--alpha", "4",       "--offset",  "0.5",         "--edge",     "2",
       "--units", "mm",      "--png",     "a.png",       "--sites",    "s.yaml"});
  EXPECT_EQ(inspect.hand, "my.urdf");
  EXPECT_EQ(inspect.units, "mm");
  EXPECT_EQ(inspect.png, "a.png");
  EXPECT_EQ(inspect.sites, "s.yaml");
  EXPECT_EQ(inspect.reading.srdf, "my.srdf");
  EXPECT_EQ(inspect.reading.packages.at("my_pkg"), "/tmp");
  const v1::HandOptions& hand = inspect.reading.options;
  EXPECT_TRUE(hand.mirrored());
  EXPECT_EQ(hand.rest_pose(), "fist");
  EXPECT_EQ(hand.skin().surfaces(), "collisions");
  EXPECT_DOUBLE_EQ(hand.skin().alpha_m(), 0.004);
  EXPECT_DOUBLE_EQ(hand.skin().offset_m(), 0.0005);
  EXPECT_DOUBLE_EQ(hand.skin().edge_m(), 0.002);
}

TEST(ImportOptions, LeaveTheDefaultsToTheServer) {
  const auto skin = options<SkinOptions>({"skin", "human20", "--out", "skin.ply"});
  EXPECT_EQ(skin.hand, "human20");
  EXPECT_EQ(skin.out, "skin.ply");
  EXPECT_EQ(skin.reading.options, v1::HandOptions());
  const auto import =
      options<ImportOptions>({"contacts", "import", "m.ply", "--object", "box"});
  EXPECT_EQ(import.reading.options, v1::ContactOptions());
  EXPECT_TRUE(import.out.empty());
}

TEST(ImportOptions, ReadHowAContactMapIsToBeRead) {
  const auto import = options<ImportOptions>(
      {"contacts", "import",      "m.glb",    "--object", "bulb.ply", "--value",
       "heat",     "--label",     "finger",   "--colors", "jet",      "--picture",
       "m.png",    "--joints",    "j.json",   "--hand",   "right",    "--threshold",
       "0.3",      "--low-share", "0.5",      "--smooth", "2",        "--min-area",
       "50",       "--points",    "30",       "--units",  "cm",       "--name",
       "bulb_1",   "--out",       "set.json", "--png",    "a.png",    "--outline",
       "0.6"});
  EXPECT_EQ(import.map, "m.glb");
  EXPECT_EQ(import.object, "bulb.ply");
  EXPECT_EQ(import.reading.picture, "m.png");
  EXPECT_EQ(import.reading.joints, "j.json");
  EXPECT_EQ(import.units, "cm");
  EXPECT_EQ(import.name, "bulb_1");
  EXPECT_EQ(import.out, "set.json");
  const v1::ContactOptions& map = import.reading.options;
  EXPECT_EQ(map.value_property(), "heat");
  EXPECT_EQ(map.label_property(), "finger");
  EXPECT_EQ(map.color_scale(), "jet");
  EXPECT_EQ(map.joints_hand().front(), 1);
  EXPECT_EQ(map.threshold().front(), 0.3);
  EXPECT_EQ(map.low_share().front(), 0.5);
  EXPECT_EQ(map.outline_share().front(), 0.6);
  EXPECT_EQ(map.smoothing_steps(), 2U);
  EXPECT_DOUBLE_EQ(map.minimum_area_m2().front(), 5e-5);
  EXPECT_EQ(map.interpolation_count(), 30U);
  EXPECT_FALSE(map.otsu());
  EXPECT_TRUE(
      options<ImportOptions>({"contacts", "import", "m.ply", "--object", "box", "--otsu"})
          .reading.options.otsu());
}

TEST(ImportOptions, ReadAPose) {
  const auto pose = options<PoseContactsOptions>(
      {"contacts", "from-pose", "--hand",  "my.urdf", "--pose",      "grasp.json",
       "--object", "box",       "--reach", "5",       "--threshold", "0.5",
       "--mirror", "--place",   "0",       "0",       "0.1",         "1",
       "0",        "0",         "0",       "--out",   "set.json"});
  EXPECT_EQ(pose.hand, "my.urdf");
  EXPECT_EQ(pose.pose, "grasp.json");
  EXPECT_EQ(pose.object, "box");
  EXPECT_EQ(pose.reach_mm, 5.0);
  EXPECT_EQ(pose.contacts.threshold().front(), 0.5);
  EXPECT_TRUE(pose.reading.options.mirrored());
  ASSERT_TRUE(pose.place.has_value());
  EXPECT_EQ((*pose.place)[2], 0.1);
}

TEST(ImportOptions, AreTakenByLoadAndGraspToo) {
  const auto load = options<LoadOptions>(
      {"load", "hand", "my.urdf", "--mirror", "--units", "in", "--package", "a=/tmp"});
  EXPECT_TRUE(load.hand_reading.options.mirrored());
  EXPECT_EQ(load.units, "in");
  EXPECT_EQ(load.hand_reading.packages.count("a"), 1U);
  const auto map = options<LoadOptions>(
      {"load", "contacts", "m.ply", "--joints", "j.json", "--joints-hand", "left"});
  EXPECT_EQ(map.contact_reading.options.joints_hand().front(), 0);
  const auto grasp =
      options<GraspOptions>({"grasp", "--hand", "my.urdf", "--object", "b.obj", "--contacts",
                             "m.ply", "--mirror", "--otsu", "--units", "mm"});
  EXPECT_EQ(grasp.hand, "my.urdf");
  EXPECT_TRUE(grasp.hand_reading.options.mirrored());
  EXPECT_TRUE(grasp.contact_reading.options.otsu());
  EXPECT_EQ(grasp.units, "mm");
}

TEST(ImportOptions, AreRefusedWhereNothingIsRead) {
  EXPECT_THAT(
      objectionTo({"hand", "inspect", "human20", "--mirror"}),
      HasSubstr("--mirror: hand human20 has been read already; it is for files: give the "
                "hand's URDF, as HAND.urdf"));
  EXPECT_THAT(objectionTo({"skin", "human20", "--out", "s.ply", "--alpha", "3"}),
              HasSubstr("human20"));
  EXPECT_THAT(objectionTo({"grasp", "--hand", "a.urdf", "--object", "b", "--contacts", "c",
                           "--threshold", "0.5"}),
              HasSubstr("--threshold"));
  EXPECT_THAT(objectionTo({"grasp", "--hand", "a.urdf", "--object", "b", "--contacts", "c",
                           "--units", "mm"}),
              HasSubstr("--units"));
  EXPECT_THAT(objectionTo({"load", "object", "b.obj", "--mirror"}), HasSubstr("--mirror"));
  EXPECT_THAT(objectionTo({"load", "hand", "b.urdf", "--otsu"}), HasSubstr("--otsu"));
}

TEST(ImportOptions, SayWhatIsWrongWithThem) {
  const auto import = [](std::vector<std::string> more) {
    std::vector<std::string> words = {"contacts", "import", "m.ply", "--object", "box"};
    words.insert(words.end(), more.begin(), more.end());
    return objectionTo(words);
  };
  EXPECT_THAT(import({"--threshold", "nan"}), HasSubstr("--threshold"));
  EXPECT_THAT(import({"--threshold", "0.5", "--otsu"}), HasSubstr("--otsu"));
  EXPECT_THAT(import({"--low-share", "0"}), HasSubstr("above 0"));
  EXPECT_THAT(import({"--smooth", "1001"}), HasSubstr("0 to 1000"));
  EXPECT_THAT(import({"--smooth", "-1"}), HasSubstr("-1"));
  EXPECT_THAT(import({"--points", "2"}), HasSubstr("3 to 10000"));
  EXPECT_THAT(import({"--points", "0"}), HasSubstr("3 to 10000"));
  EXPECT_THAT(import({"--min-area", "-1"}), HasSubstr("--min-area"));
  EXPECT_THAT(import({"--picture", "a.png"}), HasSubstr("--colors"));
  EXPECT_THAT(import({"--hand", "right"}), HasSubstr("--joints"));
  EXPECT_THAT(import({"--joints", "j.json", "--hand", "2"}), HasSubstr("left, right"));
  EXPECT_THAT(import({"--units", "furlong"}), HasSubstr("furlong"));
  EXPECT_THAT(import({"--out", ""}), HasSubstr("--out"));
  EXPECT_THAT(import({"--name", "a/b"}), HasSubstr("a/b"));
  EXPECT_THAT(objectionTo({"skin", "a.urdf"}), HasSubstr("--out"));
  EXPECT_THAT(objectionTo({"skin", "a.urdf", "--out", "s.ply", "--alpha", "0.4"}),
              HasSubstr("0.5 to 50"));
  EXPECT_THAT(objectionTo({"skin", "a.urdf", "--out", "s.ply", "--surfaces", "inner"}),
              HasSubstr("inner"));
  EXPECT_THAT(objectionTo({"contacts", "from-pose", "--hand", "a", "--pose", "b", "--object",
                           "c", "--reach", "0"}),
              HasSubstr("0.1 to 100"));
  EXPECT_THAT(objectionTo({"contacts"}), HasSubstr("import, from-pose"));
  EXPECT_THAT(objectionTo({"hand"}), HasSubstr("inspect"));
}

}  // namespace
}  // namespace handgraft::client
