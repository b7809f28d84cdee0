// Skins and contact sites of hands that others made, and of those that the project ships.
#include <algorithm>
#include <ostream>
#include <regex>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/kinematics.h"
#include "core/hand/mirror.h"
#include "core/hand/skin_report.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/wrapping.h"

namespace handgraft::hand {
namespace {

struct RealHand {
  const char* path;
  bool shared;  ///< among the shared data, else in the project
  int dofs;
  int mimics;
  std::vector<std::string> sites;
  std::vector<std::string> links;  ///< that carry these sites, as the file names them
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const RealHand& hand, std::ostream* out) {
  *out << hand.path;
}

std::filesystem::path pathOf(const RealHand& hand) {
  return hand.shared ? test::sharedData(hand.path) : test::sourceDirectory() / hand.path;
}

const std::vector<std::string> five_fingers{"thumb", "index",  "middle",
                                            "ring",  "little", "palm"};
const std::vector<std::string> four_fingers{"thumb", "index", "middle", "ring", "palm"};
const std::vector<std::string> three_fingers{"thumb", "index", "middle", "palm"};

class RealHands : public ::testing::TestWithParam<RealHand> {};

TEST_P(RealHands, GetAClosedSkinAndTheirSites) {
  HANDGRAFT_NEEDS_CGAL();
  const RealHand& hand = GetParam();
  if (hand.shared) HANDGRAFT_NEEDS_SHARED_DATA(hand.path);
  const HandModel model = io::readUrdf(pathOf(hand)).model;
  EXPECT_EQ(model.dofCount(), hand.dofs);
  EXPECT_EQ(model.mimicCount(), hand.mimics);

  // === The skin: valid, even, and close to the links
  SkinReport report;
  const Skin skin = buildSkin(model, {}, Progress(), &report);
  measure(skin, report);
  SCOPED_TRACE(describe(report));
  const geometry::TriangleMesh& mesh = skin.mesh();
  EXPECT_TRUE(report.isValid());
  EXPECT_EQ(mesh.eulerCharacteristic(), 2);
  EXPECT_GT(report.mean_edge_m, 0.0015);
  EXPECT_LT(report.mean_edge_m, 0.003);
  EXPECT_GT(report.smallest_angle_rad, 0.17);
  EXPECT_LT(report.mean_clearance_m, 0.001);
  // Sheets over a frame's openings are on no link.
  EXPECT_GE(report.projected_share, 0.98);

  // === Each link's area is in one piece: no face stands alone
  int lonely = 0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    bool has_friend = false;
    for (int c = 0; c < 3; ++c) {
      const int other = geometry::TriangleMesh::faceOf(mesh.twin(3 * f + c));
      has_friend |= skin.faceLinks()[static_cast<std::size_t>(f)] ==
                    skin.faceLinks()[static_cast<std::size_t>(other)];
    }
    if (!has_friend) ++lonely;
  }
  EXPECT_LE(lonely, mesh.faceCount() / 5000);

  // === The sites: the names expected, each on the side that closes
  const std::vector<ContactSite> sites = findContactSites(model, skin);
  std::vector<std::string> names;
  for (const ContactSite& site : sites)
    names.push_back(site.name);
  EXPECT_EQ(names, hand.sites);
  std::vector<std::string> links;
  for (const ContactSite& site : sites)
    links.push_back(site.link);
  EXPECT_EQ(links, hand.links);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const Digits digits = findDigits(model, X_SL);
  Eigen::Vector3d closing_sum = Eigen::Vector3d::Zero();
  for (const Digit& digit : digits.digits)
    closing_sum += digit.closing;
  for (const ContactSite& site : sites) {
    const int link = model.linkIndex(site.link);
    const Eigen::Vector3d n_S = skin.directionInSkin(link, site.n_L);
    Eigen::Vector3d closing = closing_sum.normalized();
    for (const Digit& digit : digits.digits)
      if (std::find(digit.tip_links.begin(), digit.tip_links.end(), link) !=
          digit.tip_links.end())
        closing = digit.closing;
    EXPECT_GT(n_S.dot(closing), 0.5) << site.name;
    // On the surface: the skin point of the site comes back to it.
    const geometry::SurfacePoint point = skin.skinPointOf(link, site.p_L);
    const Eigen::Vector3d p_S = X_SL[static_cast<std::size_t>(link)] * site.p_L;
    EXPECT_LT((geometry::positionOf(mesh, point) - p_S).norm(), 0.004) << site.name;
  }
}

/// Which way a finger closes is checked against the motion itself: flexing brings the tips
/// towards the side that the pads face.
TEST_P(RealHands, CloseTowardsTheirPads) {
  const RealHand& hand = GetParam();
  if (hand.shared) HANDGRAFT_NEEDS_SHARED_DATA(hand.path);
  const HandModel model = io::readUrdf(pathOf(hand)).model;
  LinkPoses X_HL;
  forwardKinematics(model, Pose::Identity(), model.restPose(), X_HL);
  const Digits open = findDigits(model, X_HL);
  for (const Digit& digit : open.digits) {
    const HandModel::Node& last = model.nodes()[static_cast<std::size_t>(digit.nodes.back())];
    const double lower = model.lower()[last.dof];
    const double upper = model.upper()[last.dof];
    const double rest = model.restPose()[last.dof];
    if (std::abs(upper + lower) < 0.1 * (upper - lower)) continue;  // symmetric: no side
    Eigen::VectorXd q = model.restPose();
    q[last.dof] = rest + 0.05 * (upper + lower > 0.0 ? 1.0 : -1.0);
    LinkPoses closed;
    forwardKinematics(model, Pose::Identity(), q, closed);
    const auto link = static_cast<std::size_t>(last.link);
    const Eigen::Vector3d moved = closed[link] * (inverse(X_HL[link]) * digit.tip) - digit.tip;
    EXPECT_GT(moved.normalized().dot(digit.closing), 0.9) << last.joint_name;
  }
}

/// A left hand has the sites of the right one, reflected: the finder favours no side. The skins
/// are wrapped anew and differ a little.
TEST_P(RealHands, HaveMirroredSitesWhenMirrored) {
  HANDGRAFT_NEEDS_CGAL();
  const RealHand& hand = GetParam();
  if (hand.shared) HANDGRAFT_NEEDS_SHARED_DATA(hand.path);
  const HandModel model = io::readUrdf(pathOf(hand)).model;
  const HandModel other = mirrored(model, "other side");
  const std::vector<ContactSite> sites =
      findContactSites(model, buildSkin(model, {}, Progress()));
  const std::vector<ContactSite> reflected =
      findContactSites(other, buildSkin(other, {}, Progress()));
  ASSERT_EQ(sites.size(), reflected.size());
  const Eigen::Vector3d flip(-1.0, 1.0, 1.0);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    EXPECT_EQ(sites[i].name, reflected[i].name);
    EXPECT_EQ(sites[i].link, reflected[i].link) << sites[i].name;
    EXPECT_LT((flip.asDiagonal() * sites[i].p_L - reflected[i].p_L).norm(), 0.003)
        << sites[i].name;
    EXPECT_GT((flip.asDiagonal() * sites[i].n_L).dot(reflected[i].n_L), 0.9) << sites[i].name;
    EXPECT_GT((flip.asDiagonal() * sites[i].direction_L).dot(reflected[i].direction_L), 0.9)
        << sites[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Hands,
    RealHands,
    ::testing::Values(
        RealHand{
            "hands/allegro_right/allegro_hand_right.urdf",
            true,
            16,
            0,
            four_fingers,
            {"link_15.0_tip", "link_3.0_tip", "link_7.0_tip", "link_11.0_tip", "base_link"}},
        RealHand{
            "hands/barrett_bhand/bhand_model.urdf",
            true,
            8,
            0,
            three_fingers,
            {"finger_3_dist_link", "finger_1_dist_link", "finger_2_dist_link", "base_link"}},
        RealHand{"hands/human_hand_graspit20/human_hand_graspit20.urdf",
                 true,
                 20,
                 0,
                 five_fingers,
                 {"thumb3", "index3", "mid3", "ring3", "pinky3", "palm"}},
        RealHand{
            "hands/mia_hand_right/mia_hand_description/urdf/mia_hand.urdf",
            true,
            4,
            2,
            five_fingers,
            {"thumb_fle", "index_sensor", "middle_sensor", "ring_fle", "little_fle", "palm"}},
        RealHand{"hands/mano_mean/mano_mean_fixed.urdf",
                 true,
                 45,
                 0,
                 five_fingers,
                 {"link_th_dd_z", "link_ff_dd_z", "link_mf_dd_z", "link_rf_dd_z",
                  "link_lf_dd_z", "link_palm_rz"}},
        RealHand{"server/models/hands/human20/human20.urdf",
                 false,
                 20,
                 0,
                 five_fingers,
                 {"thumb_distal", "index_distal", "middle_distal", "ring_distal",
                  "little_distal", "palm"}},
        RealHand{"server/models/hands/allegro16/allegro16.urdf",
                 false,
                 16,
                 0,
                 four_fingers,
                 {"thumb_distal", "index_distal", "middle_distal", "ring_distal", "palm"}},
        RealHand{"server/models/hands/barrett8/barrett8.urdf",
                 false,
                 8,
                 0,
                 three_fingers,
                 {"thumb_distal", "index_distal", "middle_distal", "palm"}},
        RealHand{"server/models/hands/tendon16/tendon16.urdf",
                 false,
                 16,
                 0,
                 five_fingers,
                 {"thumb_distal", "index_distal", "middle_distal", "ring_distal",
                  "little_distal", "palm"}}),
    [](const auto& hand) {
      const std::string stem = std::filesystem::path(hand.param.path).stem();
      return std::regex_replace(stem, std::regex("[^A-Za-z0-9]"), "");
    });

}  // namespace
}  // namespace handgraft::hand
