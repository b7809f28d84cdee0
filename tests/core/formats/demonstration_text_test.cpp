#include "core/formats/demonstration_text.h"

#include <cmath>
#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/demonstration_arrays.h"

namespace handgraft::formats {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Two frames of 21 joints, the i-th number of which is i, then 100 + i; the object stands
/// still.
json jointsOverTime() {
  json frames = json::array();
  for (const int first : {0, 100}) {
    json places = json::array();
    for (int i = first; i < first + 63; i += 3)
      places.push_back({i, i + 1, i + 2});
    frames.push_back(places);
  }
  return {{"format", kDemonstrationFormat},
          {"time_s", {0.0, 0.5}},
          {"joints_W_m", frames},
          {"object_pose", {{1, 2, 3, 1, 0, 0, 0}}}};
}

std::string faultOf(const json& root) {
  try {
    (void)parseDemonstration(root.dump());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(DemonstrationText, ReadsJointsInTheOrderOfTheFile) {
  const Demonstration read = parseDemonstration(jointsOverTime().dump());
  EXPECT_FALSE(read.is_left);
  EXPECT_FALSE(read.is_mano);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[1].time_s, 0.5);
  for (std::size_t i = 0; i < 63; ++i) {
    EXPECT_EQ(read.frames[0].values[i], static_cast<double>(i));
    EXPECT_EQ(read.frames[1].values[i], static_cast<double>(100 + i));
  }
  for (const DemonstrationFrame& frame : read.frames)
    EXPECT_THAT(frame.object_pose, ElementsAre(1, 2, 3, 1, 0, 0, 0));
}

TEST(DemonstrationText, ReadsManosPoseBeforeItsTranslation) {
  json root = jointsOverTime();
  root.erase("joints_W_m");
  root["side"] = "left";
  root["mano_pose_rad"] = {std::vector<double>(48, 0.25), std::vector<double>(48, 0.5)};
  root["mano_translation_m"] = {{1, 2, 3}, {4, 5, 6}};
  const Demonstration read = parseDemonstration(root.dump());
  EXPECT_TRUE(read.is_left);
  EXPECT_TRUE(read.is_mano);
  ASSERT_EQ(read.frames[1].values.size(), 51u);
  EXPECT_EQ(read.frames[1].values[47], 0.5);
  EXPECT_EQ(read.frames[1].values[48], 4.0);
}

TEST(DemonstrationText, NamesTheFieldAndTheFrame) {
  const auto with = [](const char* field, const json& value) {
    json root = jointsOverTime();
    root[field] = value;
    return faultOf(root);
  };
  EXPECT_EQ(faultOf(jointsOverTime()), "none");
  EXPECT_THAT(with("format", "handgraft-grasp/1"), HasSubstr("'format'"));
  EXPECT_THAT(with("sides", "left"), HasSubstr("'sides' is unknown"));
  EXPECT_THAT(with("side", "top"), HasSubstr("right or left"));
  EXPECT_THAT(with("time_s", json::array()), HasSubstr("no frames"));
  EXPECT_THAT(with("time_s", {0.0, 0.0}),
              AllOf(HasSubstr("frame 1"), HasSubstr("does not lie behind")));
  EXPECT_THAT(with("time_s", {0.0, 1.0, 2.0}), HasSubstr("fewer than 'time_s'"));
  EXPECT_THAT(with("time_s", {0.0}), HasSubstr("more than 'time_s', which has 1"));
  EXPECT_THAT(with("object_pose", {{1, 2, 3}}), HasSubstr("a list of 7 numbers"));
  EXPECT_THAT(with("object_pose", {{1, 2, 3, 1, 0, 0, "x"}}), HasSubstr("no finite number"));
  json both = jointsOverTime();
  both["mano_pose_rad"] = json::array();
  EXPECT_THAT(faultOf(both), HasSubstr("one of the fields"));
  json short_of_a_joint = jointsOverTime();
  short_of_a_joint["joints_W_m"][1].erase(0);
  EXPECT_THAT(faultOf(short_of_a_joint), AllOf(HasSubstr("frame 1"), HasSubstr("21 places")));
  EXPECT_THROW((void)parseDemonstration("{"), InvalidInput);
}

TEST(DemonstrationText, FramesThatTheTrackerLostAreLeftOut) {
  json root = jointsOverTime();
  root["joints_W_m"][1][8][2] = nullptr;
  const Demonstration read = parseDemonstration(root.dump());
  EXPECT_EQ(read.frames.size(), 1u);
  EXPECT_THAT(read.notes,
              ElementsAre(HasSubstr("left out 1 of 2 frames, which have null or NaN "
                                    "in place of a number: at 0.500 s")));
  root["joints_W_m"][1] = nullptr;
  EXPECT_EQ(parseDemonstration(root.dump()).frames.size(), 1u);
  root["joints_W_m"][0] = nullptr;
  EXPECT_THAT(faultOf(root), HasSubstr("each of the 2 frames"));
  root["joints_W_m"] = jointsOverTime()["joints_W_m"];
  root["time_s"][1] = nullptr;
  EXPECT_THAT(faultOf(root), HasSubstr("field 'time_s', frame 1"));
}

TEST(DemonstrationText, ReadsNanAsPythonWritesIt) {
  json root = jointsOverTime();
  root["object"] = "NaN \\ \"NaN";
  std::string text = root.dump();
  const std::size_t at = text.find("100");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 3, "NaN");
  const Demonstration read = parseDemonstration(text);
  EXPECT_EQ(read.object, "NaN \\ \"NaN");
  EXPECT_EQ(read.frames.size(), 1u);
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("NaN")));
}

TEST(DemonstrationText, TellsGapsInTime) {
  json root = {{"format", kDemonstrationFormat},
               {"joints_W_m", json::array()},
               {"object_pose", {{1, 2, 3, 1, 0, 0, 0}}}};
  for (int k = 0; k < 30; ++k) {
    root["time_s"].push_back(k / 30.0 + (k > 14 ? 0.5 : 0.0));
    root["joints_W_m"].push_back(jointsOverTime()["joints_W_m"][0]);
  }
  EXPECT_THAT(parseDemonstration(root.dump()).notes,
              ElementsAre("0.53 s without frames at 0.47 s"));
}

/// Two frames of a hand of NumPy's.
std::map<std::string, NpzArray> arraysOfAHand() {
  const auto of_zeros = [](std::vector<std::size_t> shape) {
    return NpzArray{"<f8", shape, std::vector<double>(shape[0] * shape[1], 0.0), ""};
  };
  return {{"pose", of_zeros({2, 48})},
          {"trans", of_zeros({2, 3})},
          {"object_pose", of_zeros({2, 7})},
          {"fps", {"<f8", {}, {10.0}, ""}}};
}

TEST(DemonstrationArrays, TellWhatIsNotRead) {
  std::map<std::string, NpzArray> arrays = arraysOfAHand();
  EXPECT_TRUE(demonstrationFrom(arrays).notes.empty());
  arrays["betas"] = {"<f8", {1, 10}, std::vector<double>(10, 0.0), ""};
  EXPECT_THAT(demonstrationFrom(arrays).notes,
              ElementsAre(AllOf(HasSubstr("'betas'"), HasSubstr("mean hand"))));
}

TEST(DemonstrationArrays, FramesWithNanAreLeftOut) {
  std::map<std::string, NpzArray> arrays = arraysOfAHand();
  arrays["trans"].values[4] = std::nan("");
  EXPECT_EQ(demonstrationFrom(arrays).frames.size(), 1u);
}

TEST(DemonstrationArrays, WhatIsInfiniteIsCalledSo) {
  std::map<std::string, NpzArray> arrays = arraysOfAHand();
  arrays["trans"].values[4] = -std::numeric_limits<double>::infinity();
  try {
    (void)demonstrationFrom(arrays);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("'mano_translation_m', frame 1: '-inf' is no finite number"));
  }
}

TEST(DemonstrationArrays, AnObjectsNameThatIsNoTextIsRefused) {
  std::map<std::string, NpzArray> arrays = arraysOfAHand();
  arrays["object"] = {"|O", {}, {}, ""};
  try {
    (void)demonstrationFrom(arrays);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'object' is no single text"), HasSubstr("|O")));
  }
}

}  // namespace
}  // namespace handgraft::formats
