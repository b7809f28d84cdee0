// A hand that was posed for a contact set touches with that set's fingers, where it says.
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/demonstration/posed_hand_contacts.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "core/session/session.h"

#include "tests/support/shared_data.h"

namespace handgraft::demonstration {
namespace {

std::filesystem::path library() {
  return test::sourceDirectory() / "server" / "models";
}

const hand::Hand& humanHand() {
  static const hand::Hand built_in_hand = [] {
    const auto folder = library() / "hands" / "human20";
    hand::Hand hand;
    hand.model =
        std::make_shared<const hand::HandModel>(io::readUrdf(folder / "human20.urdf").model);
    hand.skin = std::make_shared<const hand::Skin>(
        hand::SkinCache::fromEnvironment().get(*hand.model, {}, Progress()));
    hand.sites = io::readSites(folder / "sites.yaml", *hand.model);
    return hand;
  }();
  return built_in_hand;
}

struct Grasp {
  const char* object;
  const char* set;
};

class BuiltInPoseContacts : public testing::TestWithParam<Grasp> {};

TEST_P(BuiltInPoseContacts, GiveBackTheFingersThatThePoseWasSolvedFor) {
  const io::MeshFile object =
      io::readMesh(library() / "objects" / (std::string(GetParam().object) + ".obj"));
  const contact::ContactSet asked = io::readContactSet(
      library() / "contacts" / (std::string(GetParam().set) + ".json"), object);
  session::Session session(humanHand(),
                           std::make_shared<const geometry::TriangleMesh>(object.mesh), asked,
                           Pose::Identity(), optimize::Weights());
  // Fingers without a patch stay away from the object: at rest, not in their posture beside it.
  session::PriorSharesEdit at_rest;
  at_rest.shares.posture = 0.0;
  session.apply(at_rest);
  const hand::HandPose pose = session.optimize(optimize::SolveOptions(), Progress()).pose;

  const PosedContacts found =
      contactsOfPosedHand(humanHand(), pose, object.mesh, Pose::Identity(), {}, {}, Progress());
  std::set<std::string> fingers;
  for (const contact::Patch& patch : found.set.patches) {
    ASSERT_TRUE(patch.place.has_value()) << patch.name;
    fingers.insert(patch.place->digit);
    for (const contact::Patch& original : asked.patches) {
      if (patch.name != original.name && patch.name != original.name + "_distal") continue;
      const double apart =
          (positionOf(object.mesh, patch.root) - positionOf(object.mesh, original.root)).norm();
      // Fingers touch a ring that they pass through all around.
      EXPECT_LT(apart, 0.025) << patch.name;
      ASSERT_TRUE(patch.direction_O.has_value()) << patch.name;
      EXPECT_GT(patch.direction_O->dot(*original.direction_O), 0.6) << patch.name;
    }
  }
  std::set<std::string> expected;
  for (const contact::Patch& patch : asked.patches)
    expected.insert(patch.name);
  EXPECT_EQ(fingers, expected);
}

/// Carried onto the same hand, a posed grasp is found again: nobody chose a finger, a place or
/// a direction by hand.
TEST_P(BuiltInPoseContacts, AreReachedAgainByTheHandThatMadeThem) {
  const auto object = std::make_shared<const geometry::TriangleMesh>(
      io::readMesh(library() / "objects" / (std::string(GetParam().object) + ".obj")).mesh);
  const contact::ContactSet asked = io::readContactSet(
      library() / "contacts" / (std::string(GetParam().set) + ".json"),
      io::readMesh(library() / "objects" / (std::string(GetParam().object) + ".obj")));
  session::Session first(humanHand(), object, asked, Pose::Identity(), optimize::Weights());
  const hand::HandPose pose = first.optimize(optimize::SolveOptions(), Progress()).pose;
  PosedContacts own =
      contactsOfPosedHand(humanHand(), pose, *object, Pose::Identity(), {}, {}, Progress());
  own.set.name = "own";

  session::Session again(humanHand(), object, own.set, Pose::Identity(), optimize::Weights());
  for (const session::SessionPatch& patch : again.patches())
    EXPECT_TRUE(patch.placement.has_value()) << patch.patch.name << ": " << patch.dropped;
  const session::Solution found = again.solve(again.document().solving, {}, Progress());
  double sum = 0.0;
  for (const optimize::PatchFit& fit : found.report.patches)
    sum += fit.mean_mm;
  EXPECT_LT(sum / static_cast<double>(found.report.patches.size()), 3.5);
}

INSTANTIATE_TEST_SUITE_P(Library,
                         BuiltInPoseContacts,
                         testing::Values(Grasp{"scissors", "scissors_3"},
                                         Grasp{"wine_glass", "wine_glass_4"},
                                         Grasp{"box", "box_5"},
                                         Grasp{"lemon", "lemon_6"}),
                         [](const auto& grasp) {
                           return std::string(grasp.param.set);
                         });

}  // namespace
}  // namespace handgraft::demonstration
