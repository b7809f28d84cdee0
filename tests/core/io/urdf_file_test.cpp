#include "core/io/urdf_file.h"

#include <fstream>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/kinematics.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::filesystem::path written(const std::string& body) {
  const std::filesystem::path path = test::scratchDirectory() / "hand.urdf";
  std::ofstream(path) << "<robot name='hand'>" << body << "</robot>";
  return path;
}

std::string faultOf(const std::string& body) {
  try {
    (void)readUrdf(written(body));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no fault";
}

constexpr const char* kLinks = "<link name='a'/><link name='b'/>";

std::string joint(const std::string& type, const std::string& inside) {
  return "<joint name='j' type='" + type + "'><parent link='a'/><child link='b'/>" + inside +
         "</joint>";
}

TEST(UrdfFile, ReadsOriginAxisAndLimits) {
  const UrdfFile file = readUrdf(
      written(kLinks + joint("revolute",
                             "<origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>"
                             "<axis xyz='0 0 2'/><limit lower='-1' upper='2' velocity='3' "
                             "effort='1'/>")));
  const hand::Joint& j = file.model.dofJoint(0);
  EXPECT_TRUE(j.X_PJ.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE((j.X_PJ.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(j.axis_J.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(j.lower, -1.0);
  EXPECT_EQ(j.upper, 2.0);
  EXPECT_EQ(j.velocity_limit, 3.0);
  EXPECT_TRUE(file.notes.empty());
}

TEST(UrdfFile, NotesLimitsThatFollowersNarrow) {
  const auto notesWith = [](const std::string& followers_upper) {
    return readUrdf(written("<link name='a'/><link name='b'/><link name='c'/>" +
                            joint("revolute",
                                  "<limit lower='0' upper='1.5' velocity='1' effort='1'/>") +
                            "<joint name='k' type='revolute'><parent link='b'/>"
                            "<child link='c'/><mimic joint='j' multiplier='2'/>"
                            "<limit lower='0' velocity='1' effort='1' upper='" +
                            followers_upper + "'/></joint>"))
        .notes;
  };
  EXPECT_THAT(notesWith("2.0"),
              ElementsAre(AllOf(HasSubstr("'j'"), HasSubstr("from 0 to 1 rad instead of 0 to "
                                                            "1.5"))));
  EXPECT_THAT(notesWith("3.0"), IsEmpty());
}

TEST(UrdfFile, NotesMissingLimits) {
  const UrdfFile file = readUrdf(written(kLinks + joint("revolute", "")));
  EXPECT_DOUBLE_EQ(file.model.upper()[0], std::numbers::pi);
  ASSERT_FALSE(file.notes.empty());
  EXPECT_THAT(file.notes[0], AllOf(HasSubstr("'j'"), HasSubstr("no limit")));
}

TEST(UrdfFile, NotesLimitsThatMustBeDegrees) {
  const UrdfFile file = readUrdf(
      written(kLinks + joint("revolute",
                             R"(<limit lower="-90" upper="180" effort="1" velocity="1"/>)")));
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_THAT(file.notes[0],
              AllOf(HasSubstr("'j'"), HasSubstr("-90 to 180 rad"), HasSubstr("degrees")));
  EXPECT_EQ(file.model.upper()[0], 180.0) << "told, not changed";
  const UrdfFile slide = readUrdf(written(
      kLinks + joint("prismatic", R"(<limit lower="0" upper="20" effort="1" velocity="1"/>)")));
  EXPECT_TRUE(slide.notes.empty());
}

TEST(UrdfFile, LeavesContinuousJointsUnlimited) {
  const UrdfFile file = readUrdf(written(kLinks + joint("continuous", "")));
  EXPECT_TRUE(std::isinf(file.model.upper()[0]));
}

TEST(UrdfFile, ReadsPrimitivesInTheirPlace) {
  const UrdfFile file = readUrdf(
      written("<link name='a'><collision><origin xyz='1 0 0'/><geometry><box size='2 2 2'/>"
              "</geometry></collision><collision><geometry><sphere radius='0'/></geometry>"
              "</collision></link>"));
  const auto& shapes = file.model.links()[0].surface();
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_NEAR(shapes[0].mesh_L.vertices().row(0).minCoeff(), 0.0, 1e-12);
  EXPECT_NEAR(shapes[0].mesh_L.vertices().row(0).maxCoeff(), 2.0, 1e-12);
  EXPECT_EQ(file.notes.size(), 1U);  // the sphere without volume
}

TEST(UrdfFile, KeepsMirroredMeshesOutward) {
  std::ofstream(test::scratchDirectory() / "tetra.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const UrdfFile file = readUrdf(written(
      "<link name='a'><visual><geometry><mesh filename='tetra.obj' scale='-1 1 1'/></geometry>"
      "</visual></link>"));
  const geometry::TriangleMesh& mesh = file.model.links()[0].surface()[0].mesh_L;
  double volume = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f)
    volume += mesh.vertex(mesh.face(f)[0])
                  .dot(mesh.vertex(mesh.face(f)[1]).cross(mesh.vertex(mesh.face(f)[2]))) /
              6.0;
  EXPECT_NEAR(volume, 1.0 / 6.0, 1e-9);
  EXPECT_NEAR(mesh.vertices().row(0).minCoeff(), -1.0, 1e-9);
}

TEST(UrdfFile, NamesWhatIsWrongOnOneLine) {
  const auto fault = [](const std::string& body) {
    const std::string text = faultOf(body);
    EXPECT_THAT(text, AllOf(HasSubstr("hand.urdf"), Not(HasSubstr("\n"))));
    return text;
  };
  EXPECT_THAT(fault("<link name='a'>"), HasSubstr("not well-formed"));
  EXPECT_THAT(fault(""), HasSubstr("no links"));
  EXPECT_THAT(fault("<link/>"), HasSubstr("no name"));
  EXPECT_THAT(fault(kLinks + joint("spherical", "")),
              AllOf(HasSubstr("'j'"), HasSubstr("spherical"), HasSubstr("planar")));
  EXPECT_THAT(fault(kLinks + joint("planar", "<axis xyz='0 0'/>")),
              AllOf(HasSubstr("'j'"), HasSubstr("'0 0'")));
  EXPECT_THAT(fault(kLinks + joint("planar", "<axis xyz='0 0 0'/>")), HasSubstr("direction"));
  EXPECT_THAT(fault(kLinks + joint("floating", "<mimic joint='k'/>")), HasSubstr("mimic"));
  EXPECT_THAT(fault("<xacro:include filename='palm.xacro'/>"), HasSubstr("xacro FILE"));
  EXPECT_THAT(fault("<link name='a'/>" + joint("fixed", "")), HasSubstr("'b'"));
  EXPECT_THAT(fault(kLinks + joint("fixed", "") +
                    "<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint>"),
              AllOf(HasSubstr("'j'"), HasSubstr("'k'"), HasSubstr("loop")));
  EXPECT_THAT(fault("<link name='a'><visual><geometry><mesh filename='gone.stl'/></geometry>"
                    "</visual></link>"),
              AllOf(HasSubstr("'a'"), HasSubstr("gone.stl")));
  EXPECT_THAT(fault(kLinks + joint("revolute", "<axis xyz='0 0 x'/>")), HasSubstr("urdfdom"));
  EXPECT_THAT(fault(kLinks + joint("revolute", "<limit velocity='2 rad' effort='1'/>")),
              AllOf(HasSubstr("'j'"), HasSubstr("velocity '2 rad' is no number")));
  EXPECT_THAT(fault(kLinks + joint("revolute", "<axis xyz='0 0 0'/>")), HasSubstr("'j'"));
  EXPECT_THAT(fault("<link name='a'><visual><geometry><box size='1 1 -1'/></geometry></visual>"
                    "</link>"),
              HasSubstr("box"));
  EXPECT_THROW((void)readUrdf("/nowhere/hand.urdf"), InvalidInput);
}

TEST(UrdfFile, RefusesShapesThatUrdfdomWouldLeaveOut) {
  const std::string box = "<geometry><box size='1 1 1'/></geometry>";
  for (const std::string& shape :
       {std::string("<geometry><sphere radius='nan'/></geometry>"),
        std::string("<geometry><sphere/></geometry>"),
        std::string("<geometry><cylinder radius='1' length='1e999'/></geometry>"),
        std::string("<geometry><box size='1 1'/></geometry>"),
        std::string("<geometry><box size='1 1 inf'/></geometry>"),
        std::string("<geometry><mesh filename='m.stl' scale='1 x 1'/></geometry>"),
        std::string("<geometry><cone radius='1'/></geometry>"), std::string("<geometry/>"),
        "<origin xyz='nan 0 0'/>" + box, "<origin rpy='0 0'/>" + box}) {
    for (const std::string kind : {"visual", "collision"}) {
      const std::string whole = "<link name='palm'><visual>" + box + "</visual><" + kind + ">" +
                                shape + "</" + kind + "></link>";
      EXPECT_THAT(faultOf(whole),
                  AllOf(HasSubstr("hand.urdf"), HasSubstr("palm"), Not(HasSubstr("\n"))))
          << whole;
    }
  }
}

TEST(UrdfFile, SaysWhatToWriteInsteadOfACapsule) {
  const std::string text =
      R"(<link name="tip"><collision><geometry>)"
      R"(<capsule radius="0.01" length="0.03"/></geometry></collision></link>)";
  try {
    readUrdf(written(text));
    FAIL() << "it was taken";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("link 'tip'"), HasSubstr("URDF 1.0"),
                                    HasSubstr("a cylinder"), HasSubstr("a sphere")));
  }
}

TEST(UrdfFile, TakesAPlanarJointAsTwoSlidersAndATurn) {
  const UrdfFile file = readUrdf(
      written("<link name='a'><visual><geometry><sphere radius='1'/></geometry></visual></link>"
              "<link name='b'/>" +
              joint("planar", "<origin xyz='1 0 0' rpy='0 0 0'/><axis xyz='0 3 4'/>")));
  EXPECT_THAT(file.model.dofNames(), ::testing::ElementsAre("j_x", "j_y", "j_yaw"));
  EXPECT_THAT(file.notes,
              ::testing::ElementsAre(AllOf(HasSubstr("planar"), HasSubstr("j_yaw"))));
  const Eigen::Vector3d n(0.0, 0.6, 0.8);
  const hand::LinkPoses X =
      hand::forwardKinematics(file.model, {Pose::Identity(), Eigen::Vector3d(0.3, -0.4, 1.1)});
  const Pose& X_AB = X[static_cast<std::size_t>(file.model.linkIndex("b"))];
  // It slides by 0.5 in the plane across the axis, and turns about the axis alone.
  const Eigen::Vector3d moved = X_AB.translation() - Eigen::Vector3d::UnitX();
  EXPECT_NEAR(moved.dot(n), 0.0, 1e-15);
  EXPECT_NEAR(moved.norm(), 0.5, 1e-15);
  EXPECT_TRUE(X_AB.linear().isApprox(Eigen::AngleAxisd(1.1, n).toRotationMatrix(), 1e-14));
}

TEST(UrdfFile, TakesAFloatingRootAsTheHandsOwn) {
  const UrdfFile file = readUrdf(
      written("<link name='a'/>"
              "<link name='b'><visual><geometry><sphere radius='1'/></geometry></visual></link>"
              "<link name='c'/>" +
              joint("floating", "") +
              "<joint name='k' type='continuous'><parent link='b'/><child link='c'/></joint>"));
  EXPECT_THAT(file.model.dofNames(), ::testing::ElementsAre("k"));
  ASSERT_TRUE(file.floating_base.has_value());
  EXPECT_EQ(file.floating_base->dofCount(), 6);
  EXPECT_THAT(file.notes.back(), AllOf(HasSubstr("floating base"), HasSubstr("j_roll")));
  // Between two links with surfaces it is a joint of the hand.
  const UrdfFile inner = readUrdf(written(
      "<link name='a'><visual><geometry><sphere radius='1'/></geometry></visual></link>"
      "<link name='b'><visual><geometry><sphere radius='1'/></geometry></visual></link>" +
      joint("floating", "")));
  EXPECT_EQ(inner.model.dofCount(), 6);
  EXPECT_FALSE(inner.floating_base.has_value());
}

TEST(UrdfFile, ReadsEveryRealHand) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  const PackageMap packages = {
      {"mia_hand_description",
       test::sharedData("hands/mia_hand_right/mia_hand_description").string()}};
  int count = 0;
  for (const char* folder : {"hands", "problems"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(test::sharedData(folder))) {
      if (entry.path().extension() != ".urdf") continue;
      EXPECT_GT(readUrdfKinematics(entry.path()).linkCount(), 1) << entry.path();
      EXPECT_NO_THROW((void)readUrdf(entry.path(), packages)) << entry.path();
      ++count;
    }
  }
  EXPECT_GE(count, 7);  // those that were there when this was written
}

TEST(UrdfFile, PrintsNothingItself) {
  ::testing::internal::CaptureStderr();
  (void)faultOf(kLinks + joint("revolute", "<axis xyz='0 0 x'/>"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(UrdfFile, SurvivesEntityBombsAndDeepNesting) {
  const std::filesystem::path path = test::scratchDirectory() / "bomb.urdf";
  std::ofstream(path) << "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]>"
                         "<robot name='&b;'><link name='a'/></robot>";
  try {
    EXPECT_LT(readUrdf(path).model.name().size(), 100U);
  } catch (const InvalidInput&) {
    SUCCEED();
  }
  std::string deep;
  for (int i = 0; i < 100'000; ++i)
    deep += "<x>";
  EXPECT_THAT(faultOf(deep), HasSubstr("not well-formed"));
}

TEST(UrdfFile, ReadsKinematicsWithoutMeshes) {
  const hand::HandModel model = readUrdfKinematics(
      written("<link name='a'><visual><geometry><mesh filename='gone.stl'/></geometry></visual>"
              "</link>"));
  EXPECT_EQ(model.linkCount(), 1);
}

}  // namespace
}  // namespace handgraft::io
