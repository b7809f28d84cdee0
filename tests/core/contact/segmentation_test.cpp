#include "core/contact/segmentation.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::positionOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::ThrowsMessage;

constexpr double kStep = 0.001;

/// A plate of 100 x 100 mm without contact.
ContactMap emptyMap() {
  ContactMap map;
  map.mesh_O = test::makePlate(100, 100, kStep);
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  return map;
}

/// Full contact, with an optional label, within `radius` of (x, y), all in metres.
void touchDisk(ContactMap& map, double x, double y, double radius, int label = -1) {
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    if ((map.mesh_O.vertex(v) - Eigen::Vector3d(x, y, 0)).norm() > radius) continue;
    map.value[v] = 1.0;
    if (label < 0) continue;
    map.label.resize(static_cast<std::size_t>(map.mesh_O.vertexCount()), -1);
    map.label[v] = label;
  }
}

std::vector<std::string> namesOf(const ContactSet& set) {
  std::vector<std::string> names;
  for (const Patch& patch : set.patches)
    names.push_back(patch.name);
  return names;
}

TEST(Segment, FindsADiskOnAPlane) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.01, 0.02, 0.012);
  const ContactSet set = segment(map, {});

  ASSERT_THAT(namesOf(set), ElementsAre("c1"));
  const Patch& patch = set.patches[0];
  validate(map.mesh_O, patch);
  EXPECT_FALSE(patch.direction_O.has_value());
  const Eigen::Vector3d centre(0.01, 0.02, 0.0);
  EXPECT_LT((positionOf(map.mesh_O, patch.root) - centre).norm(), 2 * kStep);
  ASSERT_EQ(patch.interpolation_boundary.size(), 25u);
  for (const auto& point : patch.interpolation_boundary) {
    const double r = (positionOf(map.mesh_O, point) - centre).norm();
    EXPECT_GT(r, 0.012 - 1.5 * kStep);
    EXPECT_LE(r, 0.012);
  }
}

TEST(Segment, NumbersAnonymousPatchesByFallingArea) {
  ContactMap map = emptyMap();
  touchDisk(map, -0.03, 0.0, 0.006);
  touchDisk(map, 0.02, 0.0, 0.012);
  touchDisk(map, -0.03, 0.03, 0.009);
  const ContactSet set = segment(map, {});
  ASSERT_THAT(namesOf(set), ElementsAre("c1", "c2", "c3"));
  EXPECT_GT(positionOf(map.mesh_O, set.patches[0].root).x(), 0.0);
  EXPECT_GT(positionOf(map.mesh_O, set.patches[1].root).y(), 0.02);
}

TEST(Segment, TellsOfARegionThatNoSingleFingerTouches) {
  ContactMap map = emptyMap();
  touchDisk(map, -0.03, 0.0, 0.012);
  EXPECT_THAT(segment(map, {}).notes, testing::IsEmpty()) << "450 mm2";
  touchDisk(map, 0.02, 0.0, 0.018);
  EXPECT_THAT(segment(map, {}).notes,
              ElementsAre(testing::AllOf(HasSubstr("'c1' covers"), HasSubstr("joints"))));
}

TEST(Segment, SuspectsAMapThatHasMostOfTheObjectTouched) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.01, 0.02, 0.012);
  const ContactSet painted = segment(map, {});
  EXPECT_THAT(painted.notes, Not(Contains(HasSubstr("which no hand does"))));
  map.value = 1.0 - map.value.array();
  const ContactSet inverted = segment(map, {});
  EXPECT_THAT(inverted.notes, Contains(HasSubstr("'c1' covers 9")));
  EXPECT_THAT(inverted.notes, Contains(HasSubstr("which no hand does")));
}

TEST(Segment, EndsAPatchWhereContactFallsBelowAShareOfItsTop) {
  // Contact falls evenly from 1 in the middle to 0 at 30 mm.
  ContactMap map = emptyMap();
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v)
    map.value[v] = std::max(0.0, 1.0 - map.mesh_O.vertex(v).norm() / 0.030);
  SegmentationOptions options;
  const auto reach_of = [&] {
    double reach = 0.0;
    const Patch patch = segment(map, options).patches.at(0);
    for (const auto& point : patch.interpolation_boundary)
      reach = std::max(reach, positionOf(map.mesh_O, point).norm());
    return reach;
  };
  options.outline_share = 0.0;
  EXPECT_NEAR(reach_of(), 0.018, 1.5 * kStep);
  options.outline_share = 0.75;  // of the 0.866 that 5 % of the 18 mm disk exceed
  EXPECT_NEAR(reach_of(), 0.0105, 1.5 * kStep);
  map.value *= 0.7;  // fainter contact is no smaller, once it counts
  EXPECT_GT(reach_of(), 0.007);
  options.outline_share = 1.0;
  EXPECT_THAT(
      [&] {
        segment(map, options);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("outline is 1")));
}

TEST(Segment, DropsSpecksWithANote) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.012);
  touchDisk(map, 0.03, 0.03, 0.0015);
  const ContactSet set = segment(map, {});
  EXPECT_THAT(namesOf(set), ElementsAre("c1"));
  EXPECT_THAT(set.notes, ElementsAre(HasSubstr("specks below 20 mm2 dropped: 1")));
}

TEST(Segment, GivesEachSegmentOfAFingerItsPatch) {
  ContactMap map = emptyMap();
  map.segment_names = {"link_ff_dd_z", "link_ff_md_z", "link_th_dd_z"};
  touchDisk(map, 0.0, 0.0, 0.008, 0);
  touchDisk(map, 0.014, 0.0, 0.008, 1);
  touchDisk(map, -0.03, 0.0, 0.008, 2);
  touchDisk(map, -0.03, 0.03, 0.005, 2);
  const ContactSet set = segment(map, {});
  EXPECT_THAT(namesOf(set),
              ElementsAre("thumb_distal", "thumb_distal_2", "index_middle", "index_distal"));
  EXPECT_GT(positionOf(map.mesh_O, set.patches[1].root).y(), 0.02);  // the smaller one
  EXPECT_THAT(set.notes, IsEmpty());
}

TEST(Segment, GivesTheBorderOfASegmentToItsNeighbour) {
  ContactMap map = emptyMap();
  map.segment_names = {"index_distal", "index_middle"};
  touchDisk(map, 0.0, 0.0, 0.012, 0);
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v)
    if (map.label[static_cast<std::size_t>(v)] == 0 && map.mesh_O.vertex(v).x() > 0.0085)
      map.label[static_cast<std::size_t>(v)] = 1;
  const ContactSet set = segment(map, {});
  EXPECT_THAT(namesOf(set), ElementsAre("index_distal"));
  EXPECT_NEAR(positionOf(map.mesh_O, set.patches[0].root).x(), 0.0, 2 * kStep);
}

TEST(Segment, GroupsLabelsOfOneFingerWithoutSegments) {
  ContactMap map = emptyMap();
  map.segment_names = {"index_L1", "index_L2", "thumb_L2"};
  touchDisk(map, 0.0, 0.0, 0.008, 0);
  touchDisk(map, 0.008, 0.0, 0.008, 1);
  touchDisk(map, -0.03, 0.0, 0.008, 2);
  const ContactSet set = segment(map, {});
  ASSERT_THAT(namesOf(set), ElementsAre("thumb", "index"));
  EXPECT_NEAR(positionOf(map.mesh_O, set.patches[1].root).x(), 0.004, 2 * kStep);
  EXPECT_THAT(set.notes, IsEmpty());
}

TEST(Segment, SeparatesFingersThatTouchEachOther) {
  ContactMap map = emptyMap();
  map.segment_names = {"index", "middle"};
  touchDisk(map, 0.0, 0.0, 0.01, 0);
  touchDisk(map, 0.016, 0.0, 0.01, 1);
  EXPECT_THAT(namesOf(segment(map, {})), ElementsAre("index", "middle"));
}

TEST(Segment, KeepsThePlaceWithMostContactOfAFinger) {
  ContactMap map = emptyMap();
  map.segment_names = {"index"};
  touchDisk(map, 0.02, 0.0, 0.01, 0);
  touchDisk(map, -0.02, 0.0, 0.006, 0);
  const ContactSet set = segment(map, {});
  ASSERT_THAT(namesOf(set), ElementsAre("index"));
  EXPECT_GT(positionOf(map.mesh_O, set.patches[0].root).x(), 0.0);
  EXPECT_THAT(set.notes, ElementsAre(HasSubstr("'index' touches in 2 places")));
}

TEST(Segment, GrowsAFingerThatCoversNoFaceOfACoarseMesh) {
  ContactMap map;
  map.mesh_O = test::makePlate(10, 10, 0.01);
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  map.label.assign(static_cast<std::size_t>(map.mesh_O.vertexCount()), -1);
  map.segment_names = {"thumb"};
  map.value[60] = 1.0;
  map.label[60] = 0;
  const ContactSet set = segment(map, {});
  ASSERT_THAT(namesOf(set), ElementsAre("thumb"));
  EXPECT_EQ(geometry::vertexAt(map.mesh_O, set.patches[0].root), 60);
  EXPECT_THAT(set.notes, ElementsAre(HasSubstr("grown")));
}

TEST(Segment, LeavesOutSegmentsThatAreNoFinger) {
  ContactMap map = emptyMap();
  map.segment_names = {"forearm", "palm"};
  touchDisk(map, 0.02, 0.0, 0.01, 0);
  touchDisk(map, -0.02, 0.0, 0.01, 1);
  const ContactSet set = segment(map, {});
  EXPECT_THAT(namesOf(set), ElementsAre("palm"));
  EXPECT_THAT(set.notes, ElementsAre(HasSubstr("'forearm' names no finger")));
}

TEST(Segment, TakesNamelessLabelsApart) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.01, 3);
  touchDisk(map, 0.012, 0.0, 0.006, 5);
  EXPECT_THAT(namesOf(segment(map, {})), ElementsAre("c1", "c2"));
}

TEST(Segment, TellsContactOnAnotherScale) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.012);
  EXPECT_THAT(segment(map, {}).notes, testing::IsEmpty());
  map.value *= 255.0;
  EXPECT_THAT(segment(map, {}).notes,
              ElementsAre(testing::AllOf(HasSubstr("up to 255"), HasSubstr("threshold 0.4"),
                                         HasSubstr("a threshold of 102"))));
  SegmentationOptions options;
  options.threshold = 102.0;
  EXPECT_THAT(segment(map, options).notes, testing::IsEmpty());
}

TEST(Segment, TellsContactBelowZero) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.012);
  const ContactSet plain = segment(map, {});
  map.value[0] = -5.0;
  map.value[1] = -1e-15;
  const ContactSet set = segment(map, {});
  EXPECT_THAT(set.notes, ElementsAre(HasSubstr("1 of ")));
  EXPECT_THAT(set.notes.front(), HasSubstr("down to -5; it counts as none"));
  ASSERT_EQ(set.patches.size(), plain.patches.size());
  EXPECT_EQ(positionOf(map.mesh_O, set.patches.front().root),
            positionOf(map.mesh_O, plain.patches.front().root));
}

/// Two peaks of 1, 30 mm apart, with 0.5 between them.
ContactMap twoPeaks() {
  ContactMap map = emptyMap();
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    const Eigen::Vector3d p = map.mesh_O.vertex(v);
    const double r = std::min((p - Eigen::Vector3d(0.015, 0, 0)).norm(),
                              (p + Eigen::Vector3d(0.0151, 0, 0)).norm());
    map.value[v] = std::max(p.norm() < 0.012 ? 0.5 : 0.0, 1.0 - r / 0.02);
  }
  return map;
}

TEST(Segment, MakesPatchesOfBothPartsThatAnOutlineLeaves) {
  ContactMap map = twoPeaks();
  touchDisk(map, 0.0, 0.04, 0.004);
  const ContactSet set = segment(map, {});
  ASSERT_THAT(namesOf(set), ElementsAre("c1", "c2", "c3"));
  EXPECT_GT(positionOf(map.mesh_O, set.patches[1].root).y(), 0.03) << "keeps its name";
  EXPECT_NEAR(std::abs(positionOf(map.mesh_O, set.patches[0].root).x() -
                       positionOf(map.mesh_O, set.patches[2].root).x()),
              0.030, 0.003);
}

TEST(Segment, TellsWhatAFingersOutlineLeavesOut) {
  ContactMap map = twoPeaks();
  map.segment_names = {"index_distal"};
  map.label.assign(static_cast<std::size_t>(map.mesh_O.vertexCount()), 0);
  const ContactSet set = segment(map, {});
  EXPECT_THAT(namesOf(set), ElementsAre("index_distal"));
  EXPECT_THAT(set.notes, testing::Contains(HasSubstr("outline falls into 2 parts")));
}

TEST(Segment, SaysWhyNothingIsLeftOfWhatIsAboveTheThreshold) {
  const auto reason = [](const ContactMap& map) {
    try {
      segment(map, {});
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("patches");
  };
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.0015);
  EXPECT_THAT(reason(map),
              testing::AllOf(HasSubstr("largest contact is 1, above the threshold"),
                             HasSubstr("least area of a patch is 20 mm2")));
  map.value.setZero();
  map.value[5050] = 1.0;
  EXPECT_THAT(reason(map), HasSubstr("no face of the mesh is above it at all three corners"));
}

TEST(Segment, SaysWhatThereWasWhenNothingIsLeft) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.002);
  EXPECT_THAT(
      [&] {
        segment(map, {});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("leaves no patch")));
  map.value *= 0.3;
  EXPECT_THAT(
      [&] {
        segment(map, {});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("largest contact is 0.3")));
}

TEST(Segment, DoesNotDependOnThePlaceOfTheObject) {
  ContactMap map = emptyMap();
  touchDisk(map, 0.0, 0.0, 0.01);
  touchDisk(map, 0.01, 0.01, 0.007);
  const ContactSet here = segment(map, {});
  Eigen::Affine3d X = Eigen::Affine3d::Identity();
  X.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()));
  X.pretranslate(Eigen::Vector3d(0.3, -0.2, 0.1));
  const auto mesh_O = map.mesh_O;
  map.mesh_O = geometry::transformed(mesh_O, X);
  const ContactSet there = segment(map, {});
  ASSERT_EQ(here.patches.size(), there.patches.size());
  EXPECT_EQ(here.patches[0].boundary, there.patches[0].boundary);
}

}  // namespace
}  // namespace handgraft::contact
