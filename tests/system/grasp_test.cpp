// The main job through all programs: built-in hands, and the real ones where their data is at
// hand.

#include <fstream>
#include <ostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/service.h"
#include "tests/system/shared_skins.h"

namespace handgraft::test {
namespace {

using nlohmann::json;

json patchNamed(const json& grasp, const std::string& name) {
  for (const json& patch : grasp.at("patches")) {
    if (patch.at("name") == name) return patch;
  }
  ADD_FAILURE() << "no patch " << name;
  return {};
}

double worstMean(const json& grasp) {
  double worst = 0.0;
  for (const json& patch : grasp.at("patches")) {
    if (patch.at("placed")) worst = std::max(worst, patch.at("mean_mm").get<double>());
  }
  return worst;
}

std::string contentsOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Doctor, FindsTheServer) {
  const Service service;
  const json report = service.ask({"doctor"});
  EXPECT_EQ(report.at("domain"), service.domain());
  EXPECT_FALSE(report.at("server").is_null());
  EXPECT_EQ(report.at("models").size(), 13u) << "four hands and objects, five contact sets";
}

TEST(Grasp, HumanHandReachesEveryPatchOfTheLemon) {
  const Service service;
  const auto picture = scratchDirectory() / "lemon.png";
  const json grasp = service.ask({"grasp", "--hand", "human20", "--object", "lemon",
                                  "--contacts", "lemon_6", "--png", picture.string()});
  EXPECT_EQ(grasp.at("patches").size(), 6u);
  for (const json& patch : grasp.at("patches")) {
    EXPECT_TRUE(patch.at("placed")) << patch;
    EXPECT_LT(patch.at("mean_mm"), 6.0) << patch.at("name");
    // A fingertip's outline wraps round the finger: its normals spread, but must still oppose.
    EXPECT_LT(patch.at("normal_deg"), 75.0) << patch.at("name");
  }
  EXPECT_EQ(grasp.at("joints").size(), 20u);
  EXPECT_EQ(contentsOf(picture).substr(1, 3), "PNG");
}

TEST(Grasp, DropsThePatchesThatTheHandHasNoFingerFor) {
  const SharedSkins skins;
  const Service service;
  const json grasp = service.ask(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6"});
  EXPECT_FALSE(patchNamed(grasp, "little").at("placed"));
  EXPECT_THAT(patchNamed(grasp, "little").at("reason").get<std::string>(),
              testing::HasSubstr("little"));
  EXPECT_TRUE(patchNamed(grasp, "thumb").at("placed"));
}

TEST(Grasp, FollowsTheObject) {
  const SharedSkins skins;
  const Service service;
  const std::vector<std::string> base = {"grasp", "--hand",     "tendon16", "--object",
                                         "box",   "--contacts", "box_5"};
  std::vector<std::string> placed = base;
  // A quarter turn about z and half a metre along x: the grasp moves with it, rigidly.
  placed.insert(placed.end(), {"--place", "0.5", "0", "0", "0.70710678118654752", "0", "0",
                               "0.70710678118654752"});
  const json here = service.ask(base);
  const json there = service.ask(placed);
  // The prior holds the root near the world's origin by a thousandth: equal up to that.
  EXPECT_NEAR(here.at("terms").at("distance_m2").get<double>(),
              there.at("terms").at("distance_m2").get<double>(), 2e-5);
  EXPECT_NEAR(worstMean(here), worstMean(there), 0.5);
}

TEST(Grasp, IsTheSameTwice) {
  const SharedSkins skins;
  const Service service;
  const std::vector<std::string> arguments = {"grasp", "--hand",     "allegro16", "--object",
                                              "lemon", "--contacts", "lemon_6"};
  const json first = service.ask(arguments);
  const json second = service.ask(arguments);
  EXPECT_EQ(first.at("joints"), second.at("joints"));
  EXPECT_EQ(first.at("X_WH"), second.at("X_WH"));
}

TEST(Grasp, PrintsATableForPeople) {
  const SharedSkins skins;
  const Service service;
  const Finished finished = service.client(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6"});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  for (const char* word : {"thumb", "mm", "deg"}) {
    EXPECT_THAT(finished.out, testing::HasSubstr(word));
  }
}

struct RealHand {
  const char* name;
  const char* urdf;
  std::size_t dofs;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const RealHand& hand, std::ostream* out) {
  *out << hand.name;
}

class RealHands : public testing::TestWithParam<RealHand> {};

TEST_P(RealHands, GraspTheMustardBottleByAScannedContactMap) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  const Service service;
  const json grasp = service.ask(
      {"grasp", "--hand", sharedData(GetParam().urdf).string(), "--object",
       sharedData("objects/ycb/006_mustard_bottle.obj").string(), "--contacts",
       sharedData("contacts/dexycb/006_mustard_bottle_grasp0_contact.ply").string()});
  EXPECT_EQ(grasp.at("joints").size(), GetParam().dofs);
  int placed = 0;
  double distance = 0.0;
  double angle = 0.0;
  for (const json& patch : grasp.at("patches")) {
    if (!patch.at("placed")) continue;
    ++placed;
    distance += patch.at("mean_mm").get<double>();
    angle += patch.at("normal_deg").get<double>();
  }
  EXPECT_GE(placed, 3);
  // Whole-finger patches wrap round robot fingertips; 90 degrees is what random normals give.
  EXPECT_LT(distance / placed, 16.0) << "mm: no grasp";
  EXPECT_LT(angle / placed, 80.0) << "deg: the hand does not face the object";
}

INSTANTIATE_TEST_SUITE_P(
    FromUrdf,
    RealHands,
    testing::Values(
        RealHand{"allegro", "hands/allegro_right/allegro_hand_right.urdf", 16},
        RealHand{"human", "hands/human_hand_graspit20/human_hand_graspit20.urdf", 20},
        RealHand{"barrett", "hands/barrett_bhand/bhand_model.urdf", 8},
        RealHand{"mia", "hands/mia_hand_right/mia_hand_description/urdf/mia_hand.urdf", 4}),
    [](const auto& hand) {
      return std::string(hand.param.name);
    });

}  // namespace
}  // namespace handgraft::test
