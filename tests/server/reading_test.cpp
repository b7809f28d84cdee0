// From files to models: options and units.

#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/sites_file.h"
#include "server/reading/read_model.h"
#include "server/reading/units.h"

#include "tests/server/files_to_read.h"
#include "tests/support/wrapping.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

using files::ballPly;
using files::clampRequest;
using files::contactsOf;
using files::faultOf;
using files::mapRequest;
using files::objectOf;
using files::requestFor;
using files::written;

TEST(Hands, WithoutASurfaceAreRefused) {
  const std::string bare = "<robot name=\"bare\"><link name=\"palm\"/></robot>";
  EXPECT_EQ(faultOf(requestFor(ReadKind::kHand, written("bare.urdf", bare))),
            "hand 'bare': none of its links has a surface");
}

// === Units

TEST(Units, AsksWhereMetresMakeNoSense) {
  EXPECT_EQ(objectScale(0.152, "", "cup"), 1.0);
  EXPECT_EQ(objectScale(2.9, "", "cup"), 1.0);
  for (const auto& [size, unit] : {std::pair(152.0, "--units mm"),
                                   {61.0, "--units mm"},
                                   {15.2, "--units cm"},
                                   {3.5, "--units cm"},
                                   {6.0, "--units in"},
                                   {1500.0, "--units mm"}}) {
    try {
      objectScale(size, "", "object 'cup'");
      FAIL() << size;
    } catch (const UnitsInDoubt& doubt) {
      EXPECT_THAT(doubt.what(), AllOf(HasSubstr("object 'cup'"), HasSubstr(unit))) << size;
    }
  }
  try {
    objectScale(152.0, "", "object 'cup'");
  } catch (const UnitsInDoubt& doubt) {
    EXPECT_STREQ(doubt.what(),
                 "object 'cup': 152 m across as metres; as millimetres 152 mm: say --units mm");
  }
  try {
    objectScale(5.0, "", "object 'cup'");
    FAIL() << "5 m are no cup";
  } catch (const UnitsInDoubt& doubt) {
    EXPECT_STREQ(doubt.what(),
                 "object 'cup': 5 m across as metres; as centimetres 50 mm, as inches 127 mm: "
                 "say --units cm or --units in");
  }
}

TEST(Units, TakesWhatIsGivenWithinReason) {
  EXPECT_EQ(objectScale(152.0, "mm", "cup"), 1e-3);
  EXPECT_EQ(objectScale(15.2, "cm", "cup"), 1e-2);
  EXPECT_EQ(objectScale(6.0, "in", "cup"), 0.0254);
  EXPECT_EQ(objectScale(6.0, "m", "cup"), 1.0);
  for (const auto& [size, units] : {std::pair(0.1, "mm"),
                                    {11.0, "m"},
                                    {2e4, "mm"},
                                    {0.0002, ""},
                                    {1e6, ""},
                                    {std::nan(""), ""}}) {
    try {
      objectScale(size, units, "cup");
      FAIL() << size << units;
    } catch (const UnitsInDoubt&) {
      FAIL() << "no other units help: " << size << units;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("1 mm to 10 m")) << size << units;
    }
  }
  EXPECT_THROW(objectScale(1.0, "ft", "cup"), InvalidInput);
  const auto objection = [](double size, const char* units) -> std::string {
    try {
      objectScale(size, units, "cup");
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(objection(0.15, "mm"),
              HasSubstr("permitted are 1 mm to 10 m; say --units m (150 mm)"));
  EXPECT_THAT(objection(2e4, "mm"), EndsWith("permitted are 1 mm to 10 m"));
  EXPECT_THAT(objection(std::nan(""), "mm"), EndsWith("permitted are 1 mm to 10 m"));
}

TEST(Units, TakesAMapToLieOnItsObject) {
  // Of its object's units, of its own, and in metres though others were said.
  EXPECT_EQ(mapScale(152.0, "", "mm", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(152.0, "mm", "", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(0.152, "", "", 0.152, "map").scale, 1.0);
  const MapScale metres = mapScale(0.152, "mm", "mm", 0.152, "map");
  EXPECT_EQ(metres.scale, 1.0);
  EXPECT_THAT(metres.note, HasSubstr("taken as metres"));
  // Touched points alone are less than the object.
  EXPECT_EQ(mapScale(12.0, "", "mm", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(0.012, "", "", 0.152, "map").scale, 1.0);
  EXPECT_THROW((void)mapScale(152.0, "", "", 0.152, "map"), UnitsInDoubt);
  // Units are said of both files; the object's are metres, the map's are not.
  const MapScale others = mapScale(152.0, "m", "", 0.152, "map");
  EXPECT_EQ(others.scale, 1e-3);
  EXPECT_NE(others.note.find("millimetres"), std::string::npos) << others.note;
  EXPECT_EQ(mapScale(6.0, "m", "", 0.152, "map").scale, 0.0254);
  EXPECT_EQ(mapScale(3000.0, "m", "", 0.152, "map").scale, 1.0) << "fits in none";
}

TEST(ReadModel, ScalesObjectsAndClouds) {
  HANDGRAFT_NEEDS_CGAL();
  for (const bool points_alone : {false, true}) {
    const auto metres =
        requestFor(ReadKind::kObject, written("m.ply", ballPly(0.04, 1.0, points_alone)));
    auto others =
        requestFor(ReadKind::kObject, written("mm.ply", ballPly(0.04, 1000.0, points_alone)));
    EXPECT_THROW((void)readModel(others, Progress()), UnitsInDoubt);
    others.units = "mm";
    const io::MeshFile a = objectOf(metres);
    const io::MeshFile b = objectOf(others);
    ASSERT_EQ(a.mesh.vertexCount(), b.mesh.vertexCount());
    EXPECT_LT((a.mesh.vertices() - b.mesh.vertices()).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((a.cloud_O - b.cloud_O).size() == 0
                  ? 0.0
                  : (a.cloud_O - b.cloud_O).cwiseAbs().maxCoeff(),
              1e-12);
    EXPECT_EQ(a.notes, b.notes);
  }
}

TEST(ReadModel, ScalesMapsWithTheirObjects) {
  HANDGRAFT_NEEDS_CGAL();
  auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1000.0)));
  object.units = "mm";
  const auto in_metres = requestFor(ReadKind::kObject, written("o_m.ply", ballPly(0.04, 1.0)));
  const ReadContacts truth = contactsOf(mapRequest(in_metres.files.begin()->second, in_metres));
  for (const bool points_alone : {false, true}) {
    for (const double scale : {1.0, 1000.0}) {
      const ReadContacts read = contactsOf(
          mapRequest(written("map.ply", ballPly(0.04, scale, points_alone)), object));
      ASSERT_EQ(read.set.patches.size(), 1u) << scale;
      ASSERT_TRUE(read.map.has_value());
      EXPECT_NEAR(read.map->mesh_O.diagonal(), truth.map->mesh_O.diagonal(), 1e-3);
      EXPECT_EQ(read.threshold, 0.4);
      const auto object_mesh = objectOf(object).mesh;
      EXPECT_LT((positionOf(object_mesh, read.set.patches[0].root) -
                 positionOf(object_mesh, truth.set.patches[0].root))
                    .norm(),
                0.005)
          << scale;
    }
  }
}

TEST(ReadModel, NamesAMeshOfAHandThatIsNotInMetres) {
  std::string urdf = test::clamp_urdf;
  const std::string box = "<box size=\"0.02 0.06 0.06\"/>";
  urdf.replace(urdf.find(box), box.size(), "<mesh filename=\"meshes/palm.ply\"/>");
  ReadRequest request = requestFor(ReadKind::kHand, written("large.urdf", urdf));
  request.files["meshes/palm.ply"] = written("palm.ply", ballPly(0.04, 1000.0));
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'meshes/palm.ply'"), HasSubstr("138.6 m"),
                                      HasSubstr("scale=\"0.001 0.001 0.001\""),
                                      HasSubstr("load the hand with --units mm")));
  request.units = "mm";
  const auto read = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_NEAR(read.model.links()[0].visuals[0].mesh_L.diagonal(), 0.1386, 1e-4);
  EXPECT_NEAR(read.model.links()[1].visuals[0].mesh_L.diagonal(), 0.065, 1e-4) << "a box";
}

// === Hands

TEST(ReadModel, NotesASliderWhoseLimitsMustBeMillimetres) {
  const auto notes_of = [](const std::string& upper) {
    std::string text = test::clamp_urdf;
    text.replace(text.find("type=\"revolute\""), 15, "type=\"prismatic\"");
    text.replace(text.find("upper=\"1.2\""), 11, "upper=\"" + upper + "\"");
    return std::get<ReadHand>(
               readModel(requestFor(ReadKind::kHand, written("jaw.urdf", text)), Progress()))
        .notes;
  };
  EXPECT_THAT(notes_of("30"), Contains(AllOf(HasSubstr("'hinge'"), HasSubstr("-0.5 to 30 m"),
                                             HasSubstr("metres, not millimetres"))));
  EXPECT_THAT(notes_of("0.03"), Not(Contains(HasSubstr("millimetres"))));
}

TEST(ReadModel, TakesAnObjectForAsLargeAsNearlyAllOfIt) {
  // A ball, and a speck of a broken scan 4 m from it, which asks for no units.
  std::string text = "v 4 4 4\nv 4.001 4 4\nv 4 4.001 4\nf 1 2 3\n";
  const geometry::TriangleMesh ball = geometry::makeSphere(0.05, 3);
  for (int v = 0; v < ball.vertexCount(); ++v)
    text +=
        fmt::format("v {} {} {}\n", ball.vertex(v).x(), ball.vertex(v).y(), ball.vertex(v).z());
  for (int f = 0; f < ball.faceCount(); ++f)
    text += fmt::format("f {} {} {}\n", ball.face(f)[0] + 4, ball.face(f)[1] + 4,
                        ball.face(f)[2] + 4);
  const ReadRequest request = requestFor(ReadKind::kObject, written("ball.obj", text));
  EXPECT_EQ(objectOf(request).mesh.vertexCount(), ball.vertexCount() + 3);
}

TEST(ReadModel, RestsAHandInANamedPoseAndMirrorsIt) {
  ReadRequest request = clampRequest();
  request.hand.srdf_uri = "clamp.srdf";
  request.hand.rest_pose = "shut";
  const auto right = std::get<ReadHand>(readModel(request, Progress()));
  ASSERT_EQ(right.poses.size(), 2u);
  EXPECT_EQ(right.model.restPose()[0], 1.1);
  EXPECT_EQ(right.model.zeroPose()[0], 0.0);

  request.hand.mirrored = true;
  const auto left = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ(left.model.restPose()[0], 1.1);
  const Eigen::Vector3d S(-1.0, 1.0, 1.0);
  EXPECT_TRUE(
      left.model.joints()[0].axis_J.isApprox(-S.cwiseProduct(right.model.joints()[0].axis_J)));
}

TEST(ReadModel, MirrorsSitesUnlessTheyAreOfTheMirroredHand) {
  ReadRequest request = clampRequest();
  request.hand.mirrored = true;
  const auto left = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*left.sites)[0].p_L, Eigen::Vector3d(-0.01, 0, 0));
  EXPECT_EQ((*left.sites)[0].n_L, Eigen::Vector3d(-1, 0, 0));
  // What is written of the mirrored hand, as a file to edit, is read as it stands.
  request.files["sites.yaml"] = written("left.yaml", io::sitesText(*left.sites, true));
  const auto again = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*again.sites)[0].p_L, Eigen::Vector3d(-0.01, 0, 0));
  request.hand.mirrored = false;
  const auto right = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*right.sites)[0].p_L, Eigen::Vector3d(0.01, 0, 0));
}

TEST(ReadModel, ListsThePosesThereAre) {
  ReadRequest request = clampRequest();
  request.hand.srdf_uri = "clamp.srdf";
  request.hand.rest_pose = "wide";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'wide'"), HasSubstr("'open', 'shut'")));
  request.hand.srdf_uri = "other.srdf";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'other.srdf'"), HasSubstr("not uploaded")));
}

// === Contact maps

TEST(ReadModel, HonoursHowAMapIsToBeSplit) {
  const auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1.0)));
  ReadRequest request = mapRequest(object.files.begin()->second, object);
  request.contacts.segmentation.threshold = 2.0;
  EXPECT_THAT(faultOf(request), HasSubstr("no patch"));
  request.contacts.segmentation.rule = contact::ThresholdRule::kOtsu;
  EXPECT_THAT(faultOf(request), Not("no error"));  // one value alone parts nothing
  request.contacts.segmentation = {};
  request.contacts.segmentation.threshold = 0.25;
  request.contacts.segmentation.interpolation_count = 12;
  const ReadContacts read = contactsOf(request);
  EXPECT_EQ(read.threshold, 0.25);
  EXPECT_EQ(read.set.patches[0].interpolation_boundary.size(), 12u);
  EXPECT_EQ(read.set.name, request.name);
  request.contacts.source.value_property = "heat";
  EXPECT_THAT(faultOf(request), HasSubstr("'heat'"));
  request.contacts.picture_uri = "x.png";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'x.png'"), HasSubstr("not uploaded")));
}

TEST(ReadModel, TellsThatASetHasNoUseForJoints) {
  const fs::path models = test::sourceDirectory() / "server/models";
  ReadRequest request = mapRequest(models / "contacts/lemon_6.json",
                                   requestFor(ReadKind::kObject, models / "objects/lemon.obj"));
  const auto told = Contains(AllOf(HasSubstr("joints/mine.json"), HasSubstr("not used")));
  EXPECT_THAT(contactsOf(request).set.notes, Not(told));
  request.contacts.joints_uri = "joints/mine.json";
  EXPECT_THAT(contactsOf(request).set.notes, told);
}

TEST(ReadModel, SaysWhichObjectASetLiesOn) {
  const auto request = requestFor(
      ReadKind::kObjectName, test::sourceDirectory() / "server/models/contacts/lemon_6.json");
  EXPECT_EQ(std::get<ObjectName>(readModel(request, Progress())).name, "lemon");
}

}  // namespace
}  // namespace handgraft::server
