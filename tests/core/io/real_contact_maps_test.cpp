// Human contact as measured or computed by others: as many patches as fingers touch, each the
// right finger's.
#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "core/contact/segmentation.h"
#include "core/geometry/surface_point.h"
#include "core/io/contact_file.h"
#include "core/io/contact_map_file.h"
#include "core/io/hand_joints_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using contact::ContactMap;
using contact::ContactSet;
using contact::Patch;
using contact::SegmentationOptions;
using contact::ThresholdRule;
using geometry::TriangleMesh;

const std::string bulb_map = "contacts/contactpose/full28_use_light_bulb";

struct RealMap {
  std::string file;
  std::vector<std::string> fingers;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const RealMap& real, std::ostream* out) {
  *out << real.file;
}

/// The digits and the palm that touch, each once, in their order.
std::vector<std::string> namesOf(const ContactSet& set) {
  std::vector<std::string> names;
  for (const Patch& patch : set.patches) {
    const auto place = hand::placeNamed(patch.name);
    const std::string& name = place ? place->digit : patch.name;
    if (names.empty() || names.back() != name) names.push_back(name);
  }
  return names;
}

/// With the hand's joints where the map itself does not tell fingers.
SegmentationOptions optionsFor(const ContactMap& map) {
  SegmentationOptions options;
  if (map.label.empty())
    options.joints_O = readHandJoints(test::sharedData(bulb_map + ".json"));
  return options;
}

class RealContactMap : public ::testing::TestWithParam<RealMap> {
 protected:
  void SetUp() override {
    HANDGRAFT_NEEDS_SHARED_DATA("contacts");
    map = readContactMap(test::sharedData(GetParam().file + "_contact.ply"));
  }

  ContactMap map;
};

TEST_P(RealContactMap, HasAPatchForEveryFingerThatTouchesByAnySensibleThreshold) {
  SegmentationOptions options = optionsFor(map);
  for (const double threshold : {0.3, 0.4, 0.5}) {
    options.threshold = threshold;
    const ContactSet set = contact::segment(map, options);
    EXPECT_EQ(namesOf(set), GetParam().fingers) << threshold << fmt::format(" {}", set.notes);
  }
  options.rule = ThresholdRule::kOtsu;
  EXPECT_EQ(namesOf(contact::segment(map, options)), GetParam().fingers)
      << "Otsu " << contact::thresholdOf(map, options);
}

TEST_P(RealContactMap, HasThemWithHysteresisAndSmoothing) {
  SegmentationOptions options = optionsFor(map);
  for (const int steps : {0, 3}) {
    options.smoothing_steps = steps;
    options.low_share = 0.6;
    EXPECT_EQ(namesOf(contact::segment(map, options)), GetParam().fingers) << steps;
  }
}

/// Distance from a point to the nearest edge of a loop.
double distanceToLoop(const TriangleMesh& mesh,
                      const std::vector<int>& loop,
                      const Eigen::Vector3d& p) {
  double nearest = 1.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector3d a = mesh.vertex(loop[i]);
    const Eigen::Vector3d d = mesh.vertex(loop[(i + 1) % loop.size()]) - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * d).norm());
  }
  return nearest;
}

TEST_P(RealContactMap, HasAsManyPointsOnEachBoundaryAsAskedFor) {
  SegmentationOptions options = optionsFor(map);
  for (const int count : {20, 25, 30}) {
    options.interpolation_count = count;
    for (const Patch& patch : contact::segment(map, options).patches) {
      ASSERT_EQ(std::ssize(patch.interpolation_boundary), count);
      for (const auto& point : patch.interpolation_boundary) {
        EXPECT_LT(distanceToLoop(map.mesh_O, patch.boundary, positionOf(map.mesh_O, point)),
                  1e-6)
            << patch.name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Maps,
    RealContactMap,
    ::testing::Values(RealMap{"contacts/dexycb/003_cracker_box_grasp0",
                              {"thumb", "index", "middle", "ring", "little"}},
                      RealMap{"contacts/dexycb/006_mustard_bottle_grasp0",
                              {"thumb", "index", "middle", "ring", "little", "palm"}},
                      RealMap{"contacts/dexycb/006_mustard_bottle_grasp3",
                              {"thumb", "index", "middle", "ring", "little"}},
                      RealMap{"contacts/dexycb/025_mug_grasp0", {"thumb", "index", "middle"}},
                      RealMap{bulb_map, {"thumb", "index", "middle", "ring"}}));

// === The light bulb: joints tell the fingers

/// The finger whose joint is nearest, of all 21 places; 0 is the thumb, -1 the wrist.
int fingerOfNearestJoint(const contact::HandJoints& joints, const Eigen::Vector3d& p_O) {
  Eigen::Index nearest = 0;
  (joints.p_O.colwise() - p_O).colwise().squaredNorm().minCoeff(&nearest);
  return nearest == 0 ? -1 : static_cast<int>(nearest - 1) / 4;
}

TEST(LightBulb, GivesEachPatchToTheFingerAroundIt) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const ContactMap map = readContactMap(test::sharedData(bulb_map + "_contact.ply"));
  const SegmentationOptions options = optionsFor(map);
  for (const Patch& patch : contact::segment(map, options).patches) {
    const Eigen::Vector3d root_O = positionOf(map.mesh_O, patch.root);
    const int finger = fingerOfNearestJoint(*options.joints_O, root_O);
    ASSERT_GE(finger, 0);
    ASSERT_TRUE(patch.place.has_value()) << patch.name;
    EXPECT_EQ(patch.place->digit, contact::kHandParts[finger]);
    ASSERT_TRUE(patch.direction_O.has_value()) << patch.name;
    // The finger's base lies that way.
    const Eigen::Vector3d to_base = options.joints_O->p_O.col(1 + 4 * finger) - root_O;
    EXPECT_GT(patch.direction_O->dot(to_base), 0.0) << patch.name;
  }
}

TEST(LightBulb, SplitsTheRegionThatTwoFingersTouch) {
  // Of the four fingers two touch each other: contact hangs together in three regions.
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const ContactMap map = readContactMap(test::sharedData(bulb_map + "_contact.ply"));
  EXPECT_EQ(contact::segment(map, {}).patches.size(), 3u);
  EXPECT_EQ(namesOf(contact::segment(map, optionsFor(map))).size(), 4u);
}

TEST(LightBulb, GivesTheSameFingersFromTheTexture) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  ContactMapSource source;
  source.color_scale = "inferno";
  source.picture = test::sharedData(bulb_map + ".png");
  const auto glb = test::sharedData("contacts/contactpose/light_bulb.glb");
  SegmentationOptions options;
  options.joints_O = readHandJoints(test::sharedData(bulb_map + ".json"));
  const MeshFile object = readMesh(glb);
  const ContactSet painted = readContacts(glb, object, options, source);
  EXPECT_EQ(namesOf(painted), (std::vector<std::string>{"thumb", "index", "middle", "ring"}));

  const ContactMap map = readContactMap(test::sharedData(bulb_map + "_contact.ply"));
  const ContactSet given = contact::segment(map, options);
  for (std::size_t i = 0; i < given.patches.size(); ++i) {
    EXPECT_LT((positionOf(object.mesh, painted.patches[i].root) -
               positionOf(map.mesh_O, given.patches[i].root))
                  .norm(),
              0.004)
        << given.patches[i].name;
  }
}

}  // namespace
}  // namespace handgraft::io
