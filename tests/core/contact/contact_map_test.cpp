#include "core/contact/contact_map.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

ContactMap plateMap() {
  ContactMap map;
  map.mesh_O = test::makePlate(2, 2, 0.01);
  map.value = Eigen::VectorXd::Zero(9);
  return map;
}

TEST(FingerOfSegment, KnowsFullNamesWithNumbersSidesAndCase) {
  EXPECT_EQ(fingerOfSegment("Thumb_distal"), "thumb");
  EXPECT_EQ(fingerOfSegment("right_pinky2"), "little");
  EXPECT_EQ(fingerOfSegment("rightIndex1"), "index");
  EXPECT_EQ(fingerOfSegment("hand middle tip"), "middle");
  EXPECT_EQ(fingerOfSegment("RING"), "ring");
  EXPECT_EQ(fingerOfSegment("palmar"), "palm");
}

TEST(FingerOfSegment, KnowsTheTokensOfLinkNames) {
  EXPECT_EQ(fingerOfSegment("link_th_dd_z"), "thumb");
  EXPECT_EQ(fingerOfSegment("link_ff_pm_z"), "index");
  EXPECT_EQ(fingerOfSegment("link_mf_md_z"), "middle");
  EXPECT_EQ(fingerOfSegment("rf2"), "ring");
  EXPECT_EQ(fingerOfSegment("LF"), "little");
  EXPECT_EQ(fingerOfSegment("link_palm_rz"), "palm");
  EXPECT_EQ(fingerOfSegment("mid1"), "middle");
}

TEST(FingerOfSegment, IsEmptyWhereTheNameSaysNothing) {
  for (const char* name : {"", "wrist", "spring", "bearing_3", "offset", "4th_link",
                           "link_12.0", "forearm", "\xff\xfe"}) {
    EXPECT_EQ(fingerOfSegment(name), "") << name;
  }
}

TEST(ContactMap, RefusesAValueThatIsNotFinite) {
  ContactMap map = plateMap();
  map.value[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(
      [&] {
        validate(map);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("vertex 4 is nan")));
}

TEST(ContactMap, RefusesALabelWithoutName) {
  ContactMap map = plateMap();
  map.segment_names = {"thumb", "index"};
  map.label.assign(9, -1);
  map.label[7] = 2;
  EXPECT_THAT(
      [&] {
        validate(map);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("vertex 7 is 2; permitted are -1 to 1")));
}

TEST(ContactMap, RefusesMissingValuesAndLabels) {
  ContactMap map = plateMap();
  map.value.resize(8);
  EXPECT_THROW(validate(map), InvalidInput);
  map = plateMap();
  map.label.assign(3, 0);
  EXPECT_THROW(validate(map), InvalidInput);
}

TEST(ContactMap, TakesPartsAtTheirWordBeforeNames) {
  ContactMap map = plateMap();
  map.segment_names = {"thumb", "link_3.0", "forearm"};
  EXPECT_EQ(partOfLabel(map, 0), "thumb");
  EXPECT_EQ(partOfLabel(map, 1), "");
  map.segment_parts = {"f1", "index", ""};
  EXPECT_EQ(partOfLabel(map, 0), "f1");
  EXPECT_EQ(partOfLabel(map, 1), "index");
  for (const int nobody : {-1, 2, 3})
    EXPECT_EQ(partOfLabel(map, nobody), "") << nobody;
  map.segment_parts.pop_back();
  EXPECT_THAT(
      [&] {
        validate(map);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("2 parts for 3 segments")));
}

}  // namespace
}  // namespace handgraft::contact
