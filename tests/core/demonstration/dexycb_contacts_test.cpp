// Contacts of posed human hands, against maps that others computed from the same poses. Their d
// is the distance to points scattered over the hand's skin, on either side of it; ours is that
// to the surface itself, and contact is 1 inside. So ours, without its inside, lies above
// theirs everywhere, by as much as their points are apart.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/contact/segmentation.h"
#include "core/demonstration/posed_hand_contacts.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/floating_base.h"
#include "core/hand/hand_location.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::demonstration {
namespace {

using contact::ContactMap;

struct Recorded {
  const char* object;
  int grasp;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const Recorded& recorded, std::ostream* out) {
  *out << recorded.object << "_grasp" << recorded.grasp;
}

class DexYcbContactsTest : public ::testing::TestWithParam<Recorded> {
 protected:
  void SetUp() override {
    HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb");
    given = io::readContactMap(
        test::sharedData(std::string("contacts/dexycb/") + GetParam().object + "_grasp" +
                         std::to_string(GetParam().grasp) + "_contact.ply"));
  }

  static nlohmann::json grasps() {
    std::ifstream stream(test::sharedData("contacts/dexycb/dexycb_grasps.json"));
    return nlohmann::json::parse(stream);
  }

  static Pose objectPose(const nlohmann::json& grasp) {
    const auto o = grasp.at("object_pose_xyz_qwxyz").get<std::vector<double>>();
    Pose X_WO = Pose::Identity();
    X_WO.linear() = Eigen::Quaterniond(o[3], o[4], o[5], o[6]).normalized().toRotationMatrix();
    X_WO.translation() << o[0], o[1], o[2];
    return X_WO;
  }

  /// The hand's joints in the recorded grasp.
  static contact::HandJoints jointsInObject() {
    const nlohmann::json grasp =
        grasps().at("grasps").at(GetParam().object).at(GetParam().grasp);
    const auto places = grasp.at("joints21").get<std::vector<std::vector<double>>>();
    const Pose X_OW = objectPose(grasp).inverse();
    contact::HandJoints joints;
    for (std::size_t i = 0; i < places.size(); ++i) {
      // MANO's order, the thumb last, turned into ours, the thumb first.
      const std::size_t at = i == 0 ? 0 : i > 16 ? i - 16 : i + 4;
      joints.p_O.col(static_cast<Eigen::Index>(at)) =
          X_OW * Eigen::Vector3d(places[i][0], places[i][1], places[i][2]);
    }
    return joints;
  }

  struct RecordedHand {
    hand::HandModel model;
    hand::HandPose pose;
    Pose X_WO;
  };

  static RecordedHand recordedHand() {
    const io::UrdfFile file =
        io::readUrdf(test::sharedData("hands/mano_mean/mano_mean_fixed.urdf"));
    const nlohmann::json data = grasps();
    const auto names = data.at("qpos_joint_names").get<std::vector<std::string>>();
    const auto& grasp = data.at("grasps").at(GetParam().object).at(GetParam().grasp);
    const auto values = grasp.at("qpos").get<std::vector<double>>();
    const auto values_for = [&](const hand::HandModel& model) {
      Eigen::VectorXd q(model.dofCount());
      for (int i = 0; i < q.size(); ++i) {
        const auto found = std::find(names.begin(), names.end(), model.dofJoint(i).name);
        q[i] = values.at(static_cast<std::size_t>(found - names.begin()));
      }
      return q;
    };
    const Pose X_WH = hand::carriedPose(*file.floating_base, values_for(*file.floating_base));
    return {file.model, {X_WH, values_for(file.model)}, objectPose(grasp)};
  }

  /// The surfaces of that hand.
  static std::vector<contact::PosedSurface> handInObject() {
    const RecordedHand recorded = recordedHand();
    return posedSurfaces(recorded.model, recorded.pose, recorded.X_WO);
  }

  ContactMap given;
};

std::set<std::string> fingersOf(const contact::ContactSet& set) {
  std::set<std::string> fingers;
  for (const contact::Patch& patch : set.patches) {
    const auto place = hand::placeNamed(patch.name);
    fingers.insert(place ? place->digit : patch.name);
  }
  return fingers;
}

/// The cosine between a tangent and the finger's bone that is nearest in direction, as seen in
/// the surface: a patch at a joint may follow the bone before or behind it.
double likenessToABone(const contact::HandJoints& joints,
                       const std::string& finger,
                       const Eigen::Vector3d& direction_O,
                       const Eigen::Vector3d& n_O) {
  const auto* part =
      std::find(std::begin(contact::kHandParts), std::end(contact::kHandParts), finger);
  const auto base = 1 + 4 * (part - std::begin(contact::kHandParts));
  double best = -1.0;
  for (int bone = 0; bone < 3; ++bone) {
    const Eigen::Vector3d d = joints.p_O.col(base + bone) - joints.p_O.col(base + bone + 1);
    best = std::max(best, (d - d.dot(n_O) * n_O).normalized().dot(direction_O));
  }
  return best;
}

TEST_P(DexYcbContactsTest, AgreeWithTheGivenMap) {
  const std::vector<contact::PosedSurface> hand_O = this->handInObject();
  const ContactMap map = contact::contactsFromPose(given.mesh_O, hand_O, {.softness_m = 0.0});
  std::vector<geometry::TriangleMesh> parts_O;
  for (const contact::PosedSurface& part : hand_O)
    parts_O.push_back(part.mesh_O);
  const geometry::SurfaceLocator surface(geometry::merged(parts_O));
  const auto finger = [](const ContactMap& m, int v) {
    return contact::fingerOfSegment(
        m.segment_names[static_cast<std::size_t>(m.label[static_cast<std::size_t>(v)])]);
  };

  double least_above = 1.0;
  double most_above = 0.0;
  double sum_above = 0.0;
  int compared = 0;
  int other_finger = 0;
  for (int v = 0; v < given.mesh_O.vertexCount(); ++v) {  // refined ones come behind
    if (given.value[v] <= 0.0 && map.value[v] <= 0.0) continue;
    ++compared;
    const double distance = surface.nearest(given.mesh_O.vertex(v)).distance;
    const double both_sides = std::max(0.0, 1.0 - distance / 0.010);
    EXPECT_NEAR(map.value[v], map.value[v] == 1.0 ? 1.0 : both_sides, 1e-9);
    const double above = both_sides - given.value[v];
    least_above = std::min(least_above, above);
    most_above = std::max(most_above, above);
    sum_above += above;
    if (given.value[v] > 0.0 && finger(given, v) != finger(map, v)) ++other_finger;
  }
  RecordProperty("mean_above", std::to_string(sum_above / compared));
  RecordProperty("most_above", std::to_string(most_above));
  EXPECT_GT(compared, 300);
  EXPECT_GT(least_above, -2e-4);  // their fourth digit
  EXPECT_LT(most_above, 0.25);
  EXPECT_LT(sum_above / compared, 0.03);
  EXPECT_LE(other_finger, 0.01 * compared);
}

TEST_P(DexYcbContactsTest, TouchWithTheSameFingersOnTheCoarseObject) {
  const io::MeshFile object =
      io::readMesh(test::sharedData(std::string("objects/ycb/") + GetParam().object + ".obj"));
  const ContactMap map = contact::contactsFromPose(object.mesh, handInObject());
  EXPECT_EQ(fingersOf(contact::segment(map, {})), fingersOf(contact::segment(given, {})));
}

TEST_P(DexYcbContactsTest, GiveAContactSetWithTheSameFingersAndTheJointsDirections) {
  const RecordedHand recorded = recordedHand();
  const io::MeshFile object =
      io::readMesh(test::sharedData(std::string("objects/ycb/") + GetParam().object + ".obj"));
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(recorded.model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(recorded.model, {}, Progress()));
  const PosedContacts found =
      contactsOfPosedHand(hand, recorded.pose, object.mesh, recorded.X_WO, {}, {}, Progress());
  EXPECT_EQ(fingersOf(found.set), fingersOf(contact::segment(given, {})));
  const contact::HandJoints joints = jointsInObject();
  for (const contact::Patch& patch : found.set.patches) {
    EXPECT_NO_THROW(contact::validate(object.mesh, patch));
    ASSERT_TRUE(patch.place.has_value()) << patch.name;
    ASSERT_TRUE(patch.direction_O.has_value()) << patch.name;
    if (patch.place->digit == hand::kPalmPart) continue;
    EXPECT_GT(likenessToABone(joints, patch.place->digit, *patch.direction_O,
                              normalOf(object.mesh, patch.root)),
              0.0)
        << patch.name;
  }
}

TEST_P(DexYcbContactsTest, GetTheirFingersFromTheJointsWhereLabelsAreMissing) {
  ContactMap bare = given;
  bare.label.clear();
  bare.segment_names.clear();
  contact::SegmentationOptions options;
  options.joints_O = jointsInObject();
  const contact::ContactSet by_joints = contact::segment(bare, options);
  const contact::ContactSet by_labels = contact::segment(given, {});
  EXPECT_EQ(fingersOf(by_joints), fingersOf(by_labels));
  for (const contact::Patch& patch : by_joints.patches) {
    for (const contact::Patch& labelled : by_labels.patches) {
      if (labelled.name != patch.name) continue;
      const double apart =
          (positionOf(given.mesh_O, patch.root) - positionOf(given.mesh_O, labelled.root))
              .norm();
      EXPECT_LT(apart, 0.010) << patch.name;  // where joints and links part a finger differs
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grasps,
                         DexYcbContactsTest,
                         ::testing::Values(Recorded{"003_cracker_box", 0},
                                           Recorded{"006_mustard_bottle", 0},
                                           Recorded{"006_mustard_bottle", 3},
                                           Recorded{"025_mug", 0}));

}  // namespace
}  // namespace handgraft::demonstration
