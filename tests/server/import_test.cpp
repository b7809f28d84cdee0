// What clients are told of imported models, and contacts made of a hand's pose.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/io/contact_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "server/admission/service.h"
#include "server/messages/descriptions.h"
#include "server/reading/read_model.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ImportTest : public testing::Test {
 protected:
  ImportTest() { service.start(); }

  void loadSmallGrasp() {
    for (const v1::RequestBody& body : test::smallGrasp()) {
      const v1::Reply reply = bus.ask(body);
      ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    }
  }

  v1::HandDescription describeHand(const std::string& name, bool with_meshes) {
    const v1::Reply reply = bus.ask(test::describeModel(v1::MODEL_HAND, name, with_meshes));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().model().hand()
                                           : v1::HandDescription();
  }

  v1::ContactsDescription describeContacts(const std::string& name, bool with_meshes) {
    const v1::Reply reply = bus.ask(test::describeModel(v1::MODEL_CONTACTS, name, with_meshes));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().model().contacts()
                                           : v1::ContactsDescription();
  }

  static std::filesystem::path written(const std::string& name, const std::string& text) {
    const auto path = test::scratchDirectory() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
};

// === Hands

TEST_F(ImportTest, DescribesAHandWithoutItsSkin) {
  loadSmallGrasp();
  const v1::HandDescription hand = describeHand("clamp", false);
  EXPECT_FALSE(hand.mirrored());
  ASSERT_EQ(hand.joints().size(), 1u);
  EXPECT_EQ(hand.joints()[0].parent_link(), "palm");
  EXPECT_EQ(hand.joints()[0].child_link(), "jaw");
  EXPECT_FALSE(hand.sites_found());
  EXPECT_EQ(hand.sites().size(), 2u);
  EXPECT_THAT(hand.free_root_joints(), IsEmpty());
  EXPECT_THAT(hand.skin_report(), IsEmpty());
  EXPECT_THAT(hand.X_SL(), IsEmpty());
  EXPECT_THAT(hand.skin_face_links(), IsEmpty());
  EXPECT_EQ(hand.urdf(), test::clamp_urdf);
  const auto model = io::readUrdf(written("clamp.urdf", hand.urdf())).model;
  const auto sites = io::readSites(written("sites.yaml", hand.sites_file()), model);
  ASSERT_EQ(sites.size(), 2u);
  EXPECT_EQ(sites[1].link, "jaw");
  EXPECT_LT((sites[1].p_L - Eigen::Vector3d(0.0075, 0.0, 0.04)).norm(), 1e-8);
}

TEST_F(ImportTest, DescribesTheSkinAndHowItWasMade) {
  loadSmallGrasp();
  const v1::HandDescription hand = describeHand("clamp", true);
  ASSERT_EQ(hand.skin_report().size(), 1u);
  const v1::SkinReport& report = hand.skin_report()[0];
  EXPECT_TRUE(report.valid());
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.pieces(), 1u);
  EXPECT_EQ(report.genus(), 0);
  EXPECT_EQ(3 * report.vertices(), hand.skin_S().vertices_m().size());
  EXPECT_EQ(3 * report.faces(), hand.skin_S().triangles().size());
  EXPECT_EQ(report.faces(), hand.skin_face_links().size());
  EXPECT_EQ(report.from_cache(), report.steps().empty());
  EXPECT_GT(report.projected_share(), 0.9);
  EXPECT_LT(report.shortest_edge_m(), report.mean_edge_m());
  EXPECT_LT(report.mean_edge_m(), report.longest_edge_m());
  EXPECT_GT(report.mean_clearance_m(), 0.0);
  EXPECT_THAT(report.text(), HasSubstr("vertices"));
  // The jaw stands where its joint says, at the skin's reference.
  ASSERT_EQ(hand.X_SL().size(), 2u);
  EXPECT_NEAR(hand.X_SL()[1].p_m()[1], 0.05, 1e-12);
  EXPECT_NEAR(hand.X_SL()[1].p_m()[2], 0.035, 1e-12);
}

TEST_F(ImportTest, TellsSitesOnceTheyAreFound) {
  bus.ask(test::putFile(1, "bare.urdf", test::clamp_urdf));
  ASSERT_EQ(bus.ask(test::loadModel(1, v1::MODEL_HAND, "bare", "bare.urdf")).error(),
            v1::ERROR_NONE);
  const v1::HandDescription before = describeHand("bare", false);
  EXPECT_TRUE(before.sites_found());
  EXPECT_THAT(before.sites(), IsEmpty());
  EXPECT_EQ(before.sites_file(), "");
  const v1::HandDescription skinned = describeHand("bare", true);
  const v1::HandDescription after = describeHand("bare", false);
  EXPECT_TRUE(after.sites_found());
  EXPECT_FALSE(after.sites().empty());
  EXPECT_EQ(after.sites(), skinned.sites());
  EXPECT_THAT(after.sites_file(), HasSubstr("handgraft-sites/1"));
}

TEST_F(ImportTest, TellsWhatNamedADigit) {
  loadSmallGrasp();
  bus.ask(test::putFile(1, "bare.urdf", test::clamp_urdf));
  bus.ask(test::loadModel(1, v1::MODEL_HAND, "bare", "bare.urdf"));
  std::string named = test::clamp_urdf;
  for (std::size_t at = 0; (at = named.find("jaw", at)) != std::string::npos; at += 5)
    named.replace(at, 3, "index");
  bus.ask(test::putFile(2, "named.urdf", named));
  bus.ask(test::loadModel(2, v1::MODEL_HAND, "named", "named.urdf"));
  for (const auto& [hand, by_file] :
       {std::pair("clamp", true), std::pair("bare", false), std::pair("named", true)}) {
    const v1::HandDescription told = describeHand(hand, true);
    ASSERT_EQ(told.digits().size(), 1u) << hand;
    EXPECT_EQ(told.digits()[0].named_by_file(), by_file) << hand;
  }
}

TEST_F(ImportTest, NamesASegmentByALinkThatOneSees) {
  std::string framed = test::clamp_urdf;
  framed.insert(framed.find("</robot>"),
                "<link name=\"jaw_frame\"/><joint name=\"mount\" type=\"fixed\">"
                "<parent link=\"jaw\"/><child link=\"jaw_frame\"/>"
                "<origin xyz=\"0 0 0.05\" rpy=\"1 0 0\"/></joint>");
  bus.ask(test::putFile(1, "framed.urdf", framed));
  bus.ask(test::loadModel(1, v1::MODEL_HAND, "framed", "framed.urdf"));
  const v1::HandDescription told = describeHand("framed", true);
  ASSERT_EQ(told.digits().size(), 1u);
  ASSERT_FALSE(told.digits()[0].segments().empty());
  EXPECT_EQ(told.digits()[0].segments().back().link(), "jaw");
}

TEST_F(ImportTest, DescribesAMirroredHandByAUrdfOfItsOwn) {
  // The hinge off the mirror, so that the other hand is another one.
  std::string urdf = test::clamp_urdf;
  const std::string origin = "xyz=\"0 0.05 0.035\"";
  urdf.replace(urdf.find(origin), origin.size(), "xyz=\"0.02 0.05 0.035\" rpy=\"0.1 0.2 0.3\"");
  ReadRequest request;
  request.kind = ReadKind::kHand;
  request.name = "left";
  request.main_uri = "clamp.urdf";
  request.files["clamp.urdf"] = written("clamp.urdf", urdf);
  request.hand.mirrored = true;
  const StoredHand stored = storedHand(
      "left", Origin(), std::get<ReadHand>(readModel(request, Progress())), request.hand);
  const v1::HandDescription hand = describe(stored, std::nullopt);
  EXPECT_TRUE(hand.mirrored());
  EXPECT_THAT(hand.notes(), testing::Contains(HasSubstr("mirrored")));

  const auto jaw_of = [](const std::string& text) {
    const auto model = io::readUrdfKinematics(written("mirrored.urdf", text));
    return hand::forwardKinematics(model, {Pose::Identity(), Eigen::VectorXd::Constant(1, 0.7)})
        .back();
  };
  const Eigen::Matrix4d S = Eigen::Vector4d(-1.0, 1.0, 1.0, 1.0).asDiagonal();
  EXPECT_LT((jaw_of(hand.urdf()).matrix() - S * jaw_of(urdf).matrix() * S).norm(), 1e-12);
}

// === Contacts of a pose

/// The clamp with its palm on the lemon's side: the lemon is 60 mm across, the palm 20 mm
/// thick.
v1::RequestBody clampOnLemon(const std::string& name, double gap_m = -0.0005) {
  v1::Pose X_WO;
  X_WO.p_m({0.01 + 0.0299 + gap_m, 0.0, 0.0});
  X_WO.q_wxyz({1.0, 0.0, 0.0, 0.0});
  v1::PoseContactsRequest request;
  request.name(name);
  request.hand("clamp");
  request.object("fruit");
  request.X_WO().push_back(X_WO);
  v1::RequestBody body;
  body.pose_contacts(request);
  return body;
}

v1::RequestBody withJoint(v1::RequestBody body, const std::string& joint, double value) {
  body.pose_contacts().joints().push_back(joint);
  body.pose_contacts().joint_positions().push_back(value);
  return body;
}

TEST_F(ImportTest, MakesContactsOfAPose) {
  loadSmallGrasp();
  const v1::Reply reply = bus.ask(clampOnLemon("touched"));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  ASSERT_EQ(reply.body().models().models().size(), 1u);
  EXPECT_EQ(reply.body().models().models()[0].text(), "1 patches on fruit: palm");

  const v1::ContactsDescription contacts = describeContacts("touched", true);
  EXPECT_EQ(contacts.object(), "fruit");
  ASSERT_EQ(contacts.patches().size(), 1u);
  const v1::PatchInfo& palm = contacts.patches()[0];
  EXPECT_EQ(palm.point_count(), 25u);
  // Towards the wrist: the palm's site says -z, and the lemon's side is upright there.
  ASSERT_EQ(palm.direction_O().size(), 3u);
  EXPECT_LT(palm.direction_O()[2], -0.99);
  for (std::size_t i = 0; i < palm.outline_O_m().size(); i += 3)
    EXPECT_LT(palm.outline_O_m()[i], 0.0) << "the side that looks to the palm";
  EXPECT_THAT(contacts.notes(), testing::Contains(HasSubstr("hand 'clamp'")));

  ASSERT_EQ(contacts.contact_map().size(), 1u);
  const v1::MapInfo& map = contacts.contact_map()[0];
  EXPECT_EQ(3 * map.value().size(), map.mesh_O().vertices_m().size());
  EXPECT_NEAR(map.threshold(), 0.4, 1e-12);
  EXPECT_THAT(describeContacts("touched", false).contact_map(), IsEmpty());

  EXPECT_EQ(bus.ask(test::openSession("clamp", "fruit", "touched")).error(), v1::ERROR_NONE);
}

TEST_F(ImportTest, TellsASetAsAFileInTheObjectsOwnIndices) {
  loadSmallGrasp();
  ASSERT_EQ(bus.ask(clampOnLemon("touched")).error(), v1::ERROR_NONE);
  const io::MeshFile lemon =
      io::readMesh(test::sourceDirectory() / "server/models/objects/lemon.obj");
  for (const char* name : {"touched", "marks"}) {
    const v1::ContactsDescription contacts = describeContacts(name, false);
    const auto set = io::readContactSet(written("set.json", contacts.file()), lemon);
    ASSERT_EQ(set.patches.size(), contacts.patches().size()) << name;
    for (std::size_t i = 0; i < set.patches.size(); ++i) {
      const contact::Patch& patch = set.patches[i];
      const v1::PatchInfo& told = contacts.patches()[i];
      EXPECT_EQ(patch.name, told.name());
      for (std::size_t k = 0; k < patch.interpolation_boundary.size(); ++k) {
        const Eigen::Vector3d p =
            geometry::positionOf(lemon.mesh, patch.interpolation_boundary[k]);
        const Eigen::Map<const Eigen::Vector3d> q(told.outline_O_m().data() + 3 * k);
        EXPECT_LT((p - q).norm(), 1e-9) << name << " " << patch.name;
      }
    }
  }
}

TEST_F(ImportTest, TakesTheSamePoseAgainButNotAnotherUnderItsName) {
  loadSmallGrasp();
  ASSERT_EQ(bus.ask(clampOnLemon("touched")).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(clampOnLemon("touched")).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(clampOnLemon("touched", -0.001)).error(), v1::ERROR_CONFLICT);
  EXPECT_EQ(bus.ask(withJoint(clampOnLemon("touched"), "hinge", 0.1)).error(),
            v1::ERROR_CONFLICT);
  v1::RequestBody farther = clampOnLemon("touched");
  farther.pose_contacts().reach_m(0.012);
  EXPECT_EQ(bus.ask(farther).error(), v1::ERROR_CONFLICT);
  v1::RequestBody weaker = clampOnLemon("touched");
  weaker.pose_contacts().contacts().resize(1);
  weaker.pose_contacts().contacts()[0].threshold().push_back(0.5);
  EXPECT_EQ(bus.ask(weaker).error(), v1::ERROR_CONFLICT);
}

TEST_F(ImportTest, TheRestPoseIsCalledRestUnlessTheHandHasAnotherOfThatName) {
  loadSmallGrasp();
  ASSERT_EQ(bus.ask(clampOnLemon("touched")).error(), v1::ERROR_NONE);
  v1::RequestBody at_rest = clampOnLemon("touched");
  at_rest.pose_contacts().start_pose("rest");
  EXPECT_EQ(bus.ask(at_rest).error(), v1::ERROR_NONE) << "the same pose";

  bus.ask(test::putFile(7, "clamp.urdf", test::clamp_urdf));
  bus.ask(test::putFile(7, "sites.yaml", test::clamp_sites));
  bus.ask(test::putFile(7, "clamp.srdf",
                        "<robot name='clamp'><group_state name='rest' group='g'>"
                        "<joint name='hinge' value='0.9'/></group_state></robot>"));
  v1::RequestBody hand = test::loadModel(7, v1::MODEL_HAND, "own", "clamp.urdf");
  hand.load_model().hand().emplace_back();
  hand.load_model().hand()[0].srdf_uri("clamp.srdf");
  ASSERT_EQ(bus.ask(hand).error(), v1::ERROR_NONE);
  v1::RequestBody own = clampOnLemon("own");
  own.pose_contacts().hand("own");
  ASSERT_EQ(bus.ask(own).error(), v1::ERROR_NONE);
  own.pose_contacts().start_pose("rest");
  EXPECT_EQ(bus.ask(own).error(), v1::ERROR_CONFLICT) << "another pose of its name";
}

TEST_F(ImportTest, SaysHowFarAPosedHandIsThatTouchesNothing) {
  loadSmallGrasp();
  const v1::Reply reply = bus.ask(clampOnLemon("air", 0.05));
  EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(reply.message(), HasSubstr("touches nothing"));
  EXPECT_THAT(reply.message(), HasSubstr("50 mm"));
}

TEST_F(ImportTest, NotesJointsBeyondTheirLimits) {
  loadSmallGrasp();
  ASSERT_EQ(bus.ask(withJoint(clampOnLemon("bent"), "hinge", -0.6)).error(), v1::ERROR_NONE);
  EXPECT_THAT(describeContacts("bent", false).notes(),
              testing::Contains(HasSubstr("joint 'hinge': -0.6 is beyond its limits -0.5 to")));
  ASSERT_EQ(bus.ask(withJoint(clampOnLemon("just"), "hinge", -0.5 - 1e-7)).error(),
            v1::ERROR_NONE);
  EXPECT_THAT(describeContacts("just", false).notes(),
              testing::Not(testing::Contains(HasSubstr("beyond"))));
}

TEST_F(ImportTest, SaysThatAnglesAreRadiansWhereTheyAreMoreThanATurn) {
  loadSmallGrasp();
  ASSERT_EQ(bus.ask(withJoint(clampOnLemon("bent"), "hinge", 40.0)).error(), v1::ERROR_NONE);
  EXPECT_THAT(describeContacts("bent", false).notes(),
              testing::Contains(HasSubstr("radians, not degrees")));
  const v1::Reply air = bus.ask(withJoint(clampOnLemon("air", 0.05), "hinge", 40.0));
  EXPECT_EQ(air.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(air.message(), HasSubstr("touches nothing"));
  EXPECT_THAT(air.message(), HasSubstr("radians, not degrees"));
}

TEST_F(ImportTest, RefusesPosesThatMakeNoSense) {
  loadSmallGrasp();
  const auto expect_refused = [&](const v1::RequestBody& body, const std::string& why) {
    const v1::Reply reply = bus.ask(body);
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << why;
    EXPECT_THAT(reply.message(), HasSubstr(why));
  };
  const v1::RequestBody good = clampOnLemon("touched");
  expect_refused(withJoint(good, "hing", 0.0),
                 "no joint 'hing'; its movable joints are 'hinge'");
  expect_refused(withJoint(good, "hinge", std::nan("")), "joint_positions[0]: nan");
  expect_refused(withJoint(withJoint(good, "hinge", 0.0), "hinge", 0.0), "named twice");
  v1::RequestBody bad = good;
  bad.pose_contacts().joints().emplace_back("hinge");
  expect_refused(bad, "1 joints but 0 values");
  bad = good;
  bad.pose_contacts().start_pose("fist");
  expect_refused(bad, "no pose 'fist'; its poses are: 'rest'");
  bad = good;
  bad.pose_contacts().X_WO()[0].q_wxyz({0.0, 0.0, 0.0, 0.0});
  expect_refused(bad, "X_WO");
  bad = good;
  bad.pose_contacts().X_WO().resize(2, bad.pose_contacts().X_WO()[0]);
  expect_refused(bad, "X_WO: 2 entries");
  for (const double reach : {-0.01, 1e-5, 0.2, std::nan("")}) {
    bad = good;
    bad.pose_contacts().reach_m(reach);
    expect_refused(bad, "reach");
  }
  bad = good;
  bad.pose_contacts().contacts().resize(2);
  expect_refused(bad, "contacts: 2 entries");
  bad = good;
  bad.pose_contacts().name("a b");
  expect_refused(bad, "name 'a b'");
  bad = good;
  bad.pose_contacts().hand("nobody");
  EXPECT_EQ(bus.ask(bad).error(), v1::ERROR_NOT_FOUND);
}

// === A hand whose file places it in the world

const std::string floating_clamp = [] {
  std::string urdf = test::clamp_urdf;
  const std::string end = "</robot>";
  urdf.replace(urdf.find(end), end.size(), R"(<link name="world"/>
  <joint name="base" type="floating"><parent link="world"/><child link="palm"/></joint>
</robot>)");
  return urdf;
}();

TEST_F(ImportTest, TakesTheRootsPoseFromTheFilesOwnJoints) {
  loadSmallGrasp();
  bus.ask(test::putFile(7, "floating.urdf", floating_clamp));
  bus.ask(test::putFile(7, "sites.yaml", test::clamp_sites));
  const v1::Reply loaded =
      bus.ask(test::loadModel(7, v1::MODEL_HAND, "floating", "floating.urdf"));
  ASSERT_EQ(loaded.error(), v1::ERROR_NONE) << loaded.message();
  EXPECT_THAT(describeHand("floating", false).free_root_joints(),
              ElementsAre("base_x", "base_y", "base_z", "base_yaw", "base_pitch", "base_roll"));

  // The same meeting, but the hand comes to the lemon: turned half about z, from the other
  // side.
  v1::RequestBody body = clampOnLemon("brought");
  body.pose_contacts().hand("floating");
  const double distance = body.pose_contacts().X_WO()[0].p_m()[0];
  body.pose_contacts().X_WO().clear();
  body = withJoint(withJoint(body, "base_x", distance), "base_yaw", std::acos(-1.0));
  const v1::Reply reply = bus.ask(body);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const v1::ContactsDescription contacts = describeContacts("brought", false);
  ASSERT_EQ(contacts.patches().size(), 1u);
  for (std::size_t i = 0; i < contacts.patches()[0].outline_O_m().size(); i += 3)
    EXPECT_GT(contacts.patches()[0].outline_O_m()[i], 0.0);

  v1::Pose X_WH;
  X_WH.q_wxyz({1.0, 0.0, 0.0, 0.0});
  body.pose_contacts().name("twice");
  body.pose_contacts().X_WH().push_back(X_WH);
  EXPECT_THAT(bus.ask(body).message(), HasSubstr("given twice"));
}

}  // namespace
}  // namespace handgraft::server
