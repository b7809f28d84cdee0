#include "core/io/srdf_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"
#include "tests/support/small_hand.h"

namespace handgraft::io {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

SrdfFile read(const std::string& body) {
  const std::filesystem::path path = test::scratchDirectory() / "hand.srdf";
  std::ofstream(path) << "<robot name='hand'>" << body << "</robot>";
  return readSrdf(path, *test::makeSmallHand().model);
}

std::string faultOf(const std::string& body) {
  try {
    (void)read(body);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no fault";
}

TEST(SrdfFile, ReadsNamedPosesInTheOrderOfTheFile) {
  const SrdfFile file = read(
      "<group name='fingers'><joint name='thumb_1'/></group>"
      "<group_state name='pinch' group='fingers'><joint name='index_1' value='0.7'/>"
      "<joint name='thumb_1' value='-0.25'/></group_state>"
      "<group_state name='open' group='fingers'/>");
  const auto model = test::makeSmallHand().model;
  ASSERT_EQ(file.poses.size(), 2U);
  EXPECT_EQ(file.poses[0].name, "pinch");
  Eigen::VectorXd pinch = model->restPose();
  pinch[model->dofIndex("index_1")] = 0.7;
  pinch[model->dofIndex("thumb_1")] = -0.25;
  EXPECT_EQ(file.poses[0].q, pinch);
  EXPECT_EQ(file.poses[1].name, "open");
  EXPECT_EQ(file.poses[1].q, model->restPose());
  EXPECT_TRUE(file.notes.empty());
}

TEST(SrdfFile, TellsStatesOfOneNameApartByTheirGroup) {
  const SrdfFile file = read(
      "<group_state name='open' group='left'/>"
      "<group_state name='open' group='right'/>"
      "<group_state name='shut' group='right'/>");
  ASSERT_EQ(file.poses.size(), 3U);
  EXPECT_EQ(file.poses[0].name, "left/open");
  EXPECT_EQ(file.poses[1].name, "right/open");
  EXPECT_EQ(file.poses[2].name, "shut");
}

TEST(SrdfFile, NotesWhatTheHandDoesNotHaveAndWhatItCannotReach) {
  const SrdfFile file = read(
      "<group_state name='s' group='g'><joint name='elbow' value='1'/>"
      "<joint name='thumb_1' value='9'/></group_state>");
  const auto model = test::makeSmallHand().model;
  const int thumb = model->dofIndex("thumb_1");
  EXPECT_EQ(file.poses[0].q[thumb], model->upper()[thumb]);
  EXPECT_THAT(file.notes, ElementsAre(AllOf(HasSubstr("'thumb_1'"), HasSubstr("limit 1.5")),
                                      HasSubstr("elbow")));
}

TEST(SrdfFile, SaysThatItHasNoPose) {
  const SrdfFile file = read("<group name=\"g\"/>");
  EXPECT_TRUE(file.poses.empty());
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes.front(), "the SRDF has no group_state, so no named pose");
}

TEST(SrdfFile, NamesWhatIsWrong) {
  EXPECT_THAT(faultOf("<group_state group='g'/>"), HasSubstr("no name"));
  for (const char* value : {"", "nan", "1 2", "inf", "x"}) {
    EXPECT_THAT(faultOf(std::string("<group_state name='s' group='g'>"
                                    "<joint name='thumb_1' value='") +
                        value + "'/></group_state>"),
                AllOf(HasSubstr("hand.srdf"), HasSubstr("'s'"), HasSubstr("'thumb_1'")))
        << value;
  }
  EXPECT_THAT(faultOf("<group_state"), HasSubstr("not well-formed"));
  const std::filesystem::path path = test::scratchDirectory() / "other.srdf";
  std::ofstream(path) << "<world/>";
  EXPECT_THROW((void)readSrdf(path, *test::makeSmallHand().model), InvalidInput);
  EXPECT_THROW((void)readSrdf("/gone.srdf", *test::makeSmallHand().model), InvalidInput);
}

}  // namespace
}  // namespace handgraft::io
