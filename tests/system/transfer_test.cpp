// How patches lie on the hand, through all programs: what is lost, what would be better, and
// that an edit of one patch leaves the others alone.

#include <fstream>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

using nlohmann::json;

// === A patch too near a corner of a box
// Behind a box's corner three right angles meet where a flat patch has four: a quarter of the
// directions has no place there. Nearer to the middle of the face all have.

constexpr const char* kSlab = R"(<robot name="slab">
  <link name="slab"><visual><geometry><box size="0.1 0.1 0.02"/></geometry></visual></link>
  <link name="peg"><visual><geometry><box size="0.01 0.01 0.01"/></geometry></visual></link>
  <joint name="hinge" type="revolute"><parent link="slab"/><child link="peg"/>
    <origin xyz="0 0 -0.02"/><axis xyz="0 1 0"/>
    <limit lower="-0.1" upper="0.1" effort="1" velocity="2"/></joint>
</robot>)";

constexpr const char* kSites = R"(format: handgraft-sites/1
sites:
  - {name: palm, link: slab, point_m: [0.044, 0.044, 0.01], normal: [0, 0, 1], direction: [-1, 0, 0]}
)";

// A flat table of `side` x `side` vertices, 3 mm apart, looking to +z, as OBJ.
std::string tableObj(int side) {
  std::string text;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i)
      text += fmt::format("v {} {} 0\n", 0.003 * (i - side / 2), 0.003 * (j - side / 2));
  }
  for (int j = 0; j + 1 < side; ++j) {
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i + 1;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 1, a + side + 1, a, a + side + 1,
                          a + side);
    }
  }
  return text;
}

// One patch in the table's middle: a square of 2 `reach` steps.
std::string squareContacts(int side, int reach) {
  const int middle = side / 2;
  const auto vertex = [&](int i, int j) {
    return (middle + j) * side + middle + i;
  };
  json boundary = json::array();
  for (int k = -reach; k < reach; ++k)
    boundary.push_back(vertex(k, -reach));
  for (int k = -reach; k < reach; ++k)
    boundary.push_back(vertex(reach, k));
  for (int k = reach; k > -reach; --k)
    boundary.push_back(vertex(k, reach));
  for (int k = reach; k > -reach; --k)
    boundary.push_back(vertex(-reach, k));
  const json patch = {{"name", "palm"},
                      {"root", {{"vertex", vertex(0, 0)}}},
                      {"direction", {1, 0, 0}},
                      {"boundary", boundary}};
  return json{{"format", "handgraft-contacts/1"}, {"name", "square"}, {"patches", {patch}}}
      .dump();
}

class PatchNearACorner : public testing::Test {
 protected:
  PatchNearACorner() {
    constexpr int kSide = 27;
    write("slab.urdf", kSlab);
    write("sites.yaml", kSites);
    write("table.obj", tableObj(kSide));
    write("square.json", squareContacts(kSide, 4));
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }

  [[nodiscard]] std::vector<std::string> grasp(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"grasp",
                                          "--hand",
                                          (folder / "slab.urdf").string(),
                                          "--object",
                                          (folder / "table.obj").string(),
                                          "--contacts",
                                          (folder / "square.json").string(),
                                          "--keep"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  [[nodiscard]] std::string keptSession() const {
    return std::to_string(service.ask(grasp({})).at("session_id").get<std::uint64_t>());
  }

  std::filesystem::path folder = scratchDirectory();
  Service service;
};

TEST_F(PatchNearACorner, LosesFewerPointsOnceASuggestionIsAppliedAsItPromised) {
  const std::string session = keptSession();
  const json before = service.ask({"transfer", session}).at("patches").at(0);
  ASSERT_GT(before.at("lost").size(), 0u) << "the corner costs nothing: " << before;

  const json asked = service.ask({"suggest", session, "palm", "--reach", "20"});
  ASSERT_GT(asked.at("suggestions").size(), 0u);
  EXPECT_EQ(asked.at("present"), before) << "asking moved something";
  const json promised = asked.at("suggestions").at(0);
  EXPECT_LT(promised.at("lost_count"), before.at("lost").size());
  EXPECT_GT(promised.at("moved_m"), 0.0);
  EXPECT_LE(promised.at("moved_m"), 0.020 + 1e-9);

  const json applied =
      service.ask({"suggest", session, "palm", "--reach", "20", "--apply", "1"}).at("applied");
  const json after = service.ask({"transfer", session});
  EXPECT_EQ(applied.at("report"), after.at("patches").at(0));
  EXPECT_EQ(applied.at("revision"), after.at("revision"));
  EXPECT_EQ(after.at("patches").at(0).at("root_S"), promised.at("root_S"));
  EXPECT_EQ(after.at("patches").at(0).at("lost").size(), promised.at("lost_count"));
  EXPECT_EQ(after.at("patches").at(0).at("point_count"), promised.at("point_count"));
  EXPECT_EQ(after.at("patches").at(0).at("fidelity"), promised.at("fidelity"));
}

TEST_F(PatchNearACorner, IsToldWithTheCommandThatHelps) {
  const Finished finished = service.client(grasp({}));
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_THAT(finished.out, testing::ContainsRegex("palm lost [0-9]+ of 25 points: "));
  EXPECT_THAT(finished.out, testing::ContainsRegex("handgraft suggest [0-9]+ palm"));
}

TEST_F(PatchNearACorner, HasPointsInsideWhenTheyAreAskedFor) {
  const json grasped = service.ask(grasp({"--log-map", "exact", "--interior", "2"}));
  const std::string session = std::to_string(grasped.at("session_id").get<std::uint64_t>());
  const json transfer = service.ask({"transfer", session});
  EXPECT_EQ(transfer.at("options").at("method"), "exact");
  EXPECT_EQ(transfer.at("options").at("interior_rings"), 2);
  const json patch = transfer.at("patches").at(0);
  EXPECT_EQ(patch.at("method_O"), "exact");
  EXPECT_GT(patch.at("point_count"), patch.at("boundary_count"));
  EXPECT_EQ(patch.at("point_count").get<std::size_t>() + patch.at("lost").size(), 3u * 25);
  EXPECT_EQ(grasped.at("patches").at(0).at("point_count"), patch.at("point_count"));
}

TEST_F(PatchNearACorner, RefusesWhatCannotBeSuggested) {
  const std::string session = keptSession();
  const auto objection_to = [&](const std::vector<std::string>& arguments) {
    const Finished finished = service.client(arguments);
    EXPECT_EQ(finished.exit_code, 2) << finished.out;
    return finished.err;
  };
  EXPECT_THAT(objection_to({"suggest", session, "thumb"}), testing::HasSubstr("'thumb'"));
  EXPECT_THAT(objection_to({"suggest", session, "palm", "--count", "2", "--apply", "3"}),
              testing::HasSubstr("--apply 3: there are"));
  EXPECT_THAT(objection_to({"suggest", "999", "palm"}), testing::HasSubstr("session 999"));
  EXPECT_THAT(objection_to({"transfer", "999"}), testing::HasSubstr("session 999"));
  EXPECT_THAT(objection_to(grasp({"--log-map", "magic"})), testing::HasSubstr("auto"));
  EXPECT_THAT(objection_to(grasp({"--interior", "17"})), testing::HasSubstr("0 to 16"));
  EXPECT_EQ(service.ask({"transfer", session}).at("revision"), 0) << "a refusal counted";
}

// === Edits of one patch

v1::EditBody handRoot(const std::string& patch, const v1::SurfacePoint& root) {
  v1::PatchRootEdit edit;
  edit.patch(patch);
  edit.side(v1::SIDE_HAND);
  edit.root(root);
  v1::EditBody body;
  body.patch_root(edit);
  return body;
}

v1::EditBody turned(const std::string& patch, v1::PatchSide side, double angle_rad) {
  v1::PatchDirectionEdit edit;
  edit.patch(patch);
  edit.side(side);
  edit.angle_rad(angle_rad);
  v1::EditBody body;
  body.patch_direction(edit);
  return body;
}

/// Names of the patches whose reports differ.
std::set<std::string> changed(const v1::TransferReply& before, const v1::TransferReply& after) {
  std::set<std::string> names;
  EXPECT_EQ(before.patches().size(), after.patches().size());
  for (std::size_t i = 0; i < before.patches().size(); ++i) {
    if (!(before.patches()[i] == after.patches()[i])) names.insert(before.patches()[i].name());
  }
  return names;
}

TEST(PatchEdits, ChangeTheReportOfThatPatchAlone) {
  const Service service;
  LiveSession session(service, "human20", "lemon", "lemon_6");
  session.optimize();
  const v1::TransferReply first = session.transfer();
  v1::SurfacePoint root;
  for (const v1::PatchReport& report : first.patches()) {
    if (report.name() == "index") root = report.root_S();
  }
  // Another place in the same face.
  root.barycentric() = {0.2, 0.3, 0.5};

  ASSERT_EQ(session.edit(handRoot("index", root)).error(), v1::ERROR_NONE);
  const v1::TransferReply moved = session.transfer();
  EXPECT_EQ(changed(first, moved), std::set<std::string>{"index"});
  for (const v1::PatchReport& report : moved.patches()) {
    if (report.name() != "index") continue;
    EXPECT_EQ(report.root_S(), root);
  }

  ASSERT_EQ(session.edit(turned("thumb", v1::SIDE_HAND, 0.4)).error(), v1::ERROR_NONE);
  const v1::TransferReply turned_hand = session.transfer();
  EXPECT_EQ(changed(moved, turned_hand), std::set<std::string>{"thumb"});

  // The object's direction turns what is laid out on the hand as well.
  ASSERT_EQ(session.edit(turned("palm", v1::SIDE_OBJECT, -0.4)).error(), v1::ERROR_NONE);
  EXPECT_EQ(changed(turned_hand, session.transfer()), std::set<std::string>{"palm"});
}

TEST(PatchEdits, ThatTurnBothDirectionsByOppositeAnglesLeaveThePlacesAsTheyWere) {
  const Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  const v1::PatchReport before = session.transfer().patches().front();
  // Face to face, a turn to the left on the one side is one to the right on the other.
  session.edit(turned(before.name(), v1::SIDE_OBJECT, 0.7));
  session.edit(turned(before.name(), v1::SIDE_HAND, -0.7));
  const v1::PatchReport after = session.transfer().patches().front();
  EXPECT_EQ(after.point_count(), before.point_count());
  EXPECT_EQ(after.lost(), before.lost());
  EXPECT_NEAR(after.fidelity().distance_mean(), before.fidelity().distance_mean(), 1e-3);
  EXPECT_NEAR(after.fidelity().area_ratio(), before.fidelity().area_ratio(), 1e-3);
}

}  // namespace
}  // namespace handgraft::test
