// Fingers and segments of one made-up hand under several ways to name its links and joints, and
// of the hands that others made.
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <ostream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/anatomy.h"
#include "core/hand/mirror.h"
#include "core/hand/skin.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The name of a link, and of the joint that carries it, by digit (0: thumb to 4: little) and
/// segment (0 to 2); digit -1 is the palm.
using Style = std::function<std::string(int digit, int segment, bool is_joint)>;

/// A right hand in its frame: palm facing -y, fingers to +z, the thumb on the side of +x.
HandModel madeUpHand(const Style& style) {
  std::string urdf = fmt::format(
      "<robot name='hand'><link name='{}'><visual><origin xyz='0 0 0.045'/><geometry><box "
      "size='0.08 0.02 0.09'/></geometry></visual></link>",
      style(-1, 0, false));
  const std::array<double, 3> lengths{0.04, 0.025, 0.022};
  for (int digit = 0; digit < 5; ++digit) {
    const bool is_thumb = digit == 0;
    const Eigen::Vector3d bone =
        is_thumb ? Eigen::Vector3d(1, 0, 1).normalized() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d closing =
        is_thumb ? Eigen::Vector3d(-1, -1.4, 1).normalized() : -Eigen::Vector3d::UnitY();
    const Eigen::Vector3d axis = bone.cross(closing);
    Eigen::Vector3d from = is_thumb ? Eigen::Vector3d(0.045, 0, 0.03)
                                    : Eigen::Vector3d(0.03 - 0.02 * (digit - 1), 0, 0.1);
    std::string parent = style(-1, 0, false);
    for (int segment = 0; segment < 3; ++segment) {
      const double length = lengths[static_cast<std::size_t>(segment)];
      const Eigen::Vector3d middle = 0.5 * length * bone;
      const std::string link = style(digit, segment, false);
      urdf += fmt::format(
          "<link name='{}'><visual><origin xyz='{} {} {}' rpy='0 {} 0'/><geometry><box "
          "size='0.014 0.014 {}'/></geometry></visual></link>"
          "<joint name='{}' type='revolute'><parent link='{}'/><child link='{}'/><origin "
          "xyz='{} {} {}'/><axis xyz='{} {} {}'/><limit lower='-0.1' upper='1.5' effort='1' "
          "velocity='1'/></joint>",
          link, middle.x(), middle.y(), middle.z(), is_thumb ? 0.785398163 : 0.0,
          length - 0.002, style(digit, segment, true), parent, link, from.x(), from.y(),
          from.z(), axis.x(), axis.y(), axis.z());
      from = length * bone;
      parent = link;
    }
  }
  urdf += "</robot>";
  const auto path = std::filesystem::temp_directory_path() /
                    fmt::format("naming_styles_{}.urdf", std::hash<std::string>()(urdf));
  std::ofstream(path) << urdf;
  HandModel model = io::readUrdf(path).model;
  std::filesystem::remove(path);
  return model;
}

Anatomy anatomyOfHand(const HandModel& model) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  return anatomyOf(model, X_SL, {});
}

/// What the first link of each digit's segments is named in the file, by what we call them.
std::map<std::string, std::vector<std::string>> linksByDigit(const HandModel& model,
                                                             const Anatomy& anatomy) {
  std::map<std::string, std::vector<std::string>> result;
  for (const NamedDigit& digit : anatomy.digits)
    for (const Segment& segment : digit.segments)
      result[digit.name].push_back(
          model.links()[static_cast<std::size_t>(segment.links.front())].name);
  return result;
}

constexpr std::array<const char*, 5> kDigits{"thumb", "index", "middle", "ring", "little"};

/// That each digit's links are those that the style gives to this digit of the hand.
void expectDigits(const Style& style,
                  const std::array<int, 5>& digit_of_name,
                  const Anatomy& anatomy,
                  const HandModel& model) {
  const auto links = linksByDigit(model, anatomy);
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    ASSERT_TRUE(links.contains(kDigits[i])) << kDigits[i];
    const int digit = digit_of_name[i];
    EXPECT_THAT(
        links.at(kDigits[i]),
        ElementsAre(style(digit, 0, false), style(digit, 1, false), style(digit, 2, false)))
        << kDigits[i];
  }
  for (const NamedDigit& digit : anatomy.digits) {
    ASSERT_EQ(digit.segments.size(), 3U);
    EXPECT_EQ(digit.segments[0].name, "proximal");
    EXPECT_EQ(digit.segments[1].name, "middle");
    EXPECT_EQ(digit.segments[2].name, "distal");
  }
}

constexpr std::array<int, 5> kAsTheyAre{0, 1, 2, 3, 4};

TEST(NamingStyles, LettersOfFingersNeedNoShape) {
  const Style style = [](int digit, int segment, bool is_joint) -> std::string {
    constexpr std::array<const char*, 5> kLetters{"th", "ff", "mf", "rf", "lf"};
    constexpr std::array<const char*, 3> kSegments{"proximal", "middle", "distal"};
    if (digit < 0) return "palm";
    const std::string letters = kLetters[static_cast<std::size_t>(digit)];
    return is_joint
               ? fmt::format("rh_{}J{}", letters, 3 - segment)
               : fmt::format("rh_{}{}", letters, kSegments[static_cast<std::size_t>(segment)]);
  };
  const HandModel model = madeUpHand(style);
  const Anatomy anatomy = anatomyOfHand(model);
  expectDigits(style, kAsTheyAre, anatomy, model);
  EXPECT_THAT(anatomy.notes, IsEmpty());
  EXPECT_EQ(anatomy.chirality, Chirality::kRight);
}

TEST(NamingStyles, NamesStrippedAreFoundByShapeAndSaySo) {
  // In an order that tells nothing either.
  const Style style = [](int digit, int segment, bool is_joint) {
    constexpr std::array<int, 5> kOrder{2, 4, 0, 3, 1};
    return digit < 0 ? std::string("body")
                     : fmt::format("{}_{}{}", is_joint ? "j" : "b",
                                   kOrder[static_cast<std::size_t>(digit)], segment);
  };
  const HandModel model = madeUpHand(style);
  const Anatomy anatomy = anatomyOfHand(model);
  expectDigits(style, kAsTheyAre, anatomy, model);
  EXPECT_THAT(anatomy.notes, ElementsAre(HasSubstr("named by the hand's shape")));
}

TEST(NamingStyles, NamesThatLieWinAndAreTold) {
  // Index and little are exchanged.
  const Style style = [](int digit, int segment, bool is_joint) {
    constexpr std::array<const char*, 5> kNames{"thumb", "little", "middle", "ring", "index"};
    return digit < 0 ? std::string("palm")
                     : fmt::format("{}_{}{}", kNames[static_cast<std::size_t>(digit)],
                                   is_joint ? "j" : "l", segment);
  };
  const HandModel model = madeUpHand(style);
  const Anatomy anatomy = anatomyOfHand(model);
  expectDigits(style, {0, 4, 2, 3, 1}, anatomy, model);
  EXPECT_THAT(anatomy.notes,
              ElementsAre(HasSubstr("the names say little where the shape has index"),
                          HasSubstr("the names say index where the shape has little")));
}

TEST(NamingStyles, DigitsNumberedFromTheLittleFingerAreFoundByShape) {
  const Style style = [](int digit, int segment, bool is_joint) {
    return digit < 0 ? std::string("base")
                     : fmt::format(
                           "finger_{}_{}_{}", 5 - digit,
                           std::array{"prox", "med", "dist"}[static_cast<std::size_t>(segment)],
                           is_joint ? "joint" : "link");
  };
  const HandModel model = madeUpHand(style);
  const Anatomy anatomy = anatomyOfHand(model);
  expectDigits(style, kAsTheyAre, anatomy, model);
  EXPECT_THAT(anatomy.notes, ElementsAre(HasSubstr("named by the hand's shape")));
}

TEST(NamingStyles, ANamedThumbLeavesTheFingersToTheShape) {
  const Style style = [](int digit, int segment, bool is_joint) {
    if (digit < 0) return std::string("palm_lower");
    const std::string which = digit == 0 ? "thumb_" : "";
    return fmt::format("{}{}{}_{}", which, is_joint ? "q" : "",
                       std::array{"pip", "dip", "tip"}[static_cast<std::size_t>(segment)],
                       digit);
  };
  const HandModel model = madeUpHand(style);
  const Anatomy anatomy = anatomyOfHand(model);
  expectDigits(style, kAsTheyAre, anatomy, model);
  EXPECT_THAT(anatomy.notes, ElementsAre(HasSubstr("index, middle, ring, little")));
}

TEST(NamingStyles, NamesOfTheOtherSideAreTold) {
  const Style style = [](int digit, int segment, bool is_joint) {
    return digit < 0 ? std::string("right_palm")
                     : fmt::format("right_{}_{}{}", kDigits[static_cast<std::size_t>(digit)],
                                   is_joint ? "j" : "l", segment);
  };
  const HandModel model = madeUpHand(style);
  EXPECT_THAT(anatomyOfHand(model).notes, IsEmpty());
  const HandModel left = mirrored(model, "hand").asMirror(false);  // as if it were made so
  const Anatomy anatomy = anatomyOfHand(left);
  expectDigits(style, kAsTheyAre, anatomy, left);
  EXPECT_EQ(anatomy.chirality, Chirality::kLeft);
  EXPECT_THAT(anatomy.side_note, HasSubstr("its names say a right hand"));
  EXPECT_EQ(anatomy.named_side, Chirality::kRight);
  EXPECT_THAT(anatomy.notes, IsEmpty());
}

// Of a claw the names alone tell the side.
TEST(NamingStyles, AMirroredHandHasTheNamesOfTheOtherOne) {
  const HandModel model = madeUpHand([](int digit, int segment, bool is_joint) {
    return digit < 0 ? std::string("right_palm")
                     : fmt::format("right_{}_{}{}", kDigits[static_cast<std::size_t>(digit)],
                                   is_joint ? "j" : "l", segment);
  });
  for (const char* name : {"hand", "my_left_one", "right_mirrored"}) {
    const Anatomy anatomy = anatomyOfHand(mirrored(model, name));
    EXPECT_EQ(anatomy.chirality, Chirality::kLeft) << name;
    EXPECT_EQ(anatomy.named_side, Chirality::kLeft) << name;
    EXPECT_EQ(anatomy.side_note, "") << name;
  }
  EXPECT_EQ(anatomyOfHand(mirrored(mirrored(model, "a"), "b")).named_side, Chirality::kRight);
}

TEST(NamingStyles, SegmentsCloseToWherePalmsFace) {
  const Style style = [](int digit, int segment, bool) {
    return digit < 0 ? std::string("palm")
                     : fmt::format("{}_{}", kDigits[static_cast<std::size_t>(digit)], segment);
  };
  // Joints may be called as their links are.
  const HandModel model = madeUpHand([&](int digit, int segment, bool is_joint) {
    return (is_joint ? "j_" : "") + style(digit, segment, is_joint);
  });
  const Anatomy anatomy = anatomyOfHand(model);
  ASSERT_TRUE(anatomy.palm.has_value());
  // Fingers are bent and spread a little at the skin's reference pose.
  EXPECT_LT((anatomy.palm->facing_S + Eigen::Vector3d::UnitY()).norm(), 0.3);
  EXPECT_LT((anatomy.palm->outward_S - Eigen::Vector3d::UnitZ()).norm(), 0.3);
  EXPECT_GT(anatomy.palm->thumb_side_S.x(), 0.9);
  for (const NamedDigit& digit : anatomy.digits) {
    if (digit.name == "thumb") continue;
    for (const Segment& segment : digit.segments)
      EXPECT_GT(-segment.palmar_S.y(), 0.7) << digit.name << segment.name;
  }
}

// === Hands of others

struct Named {
  const char* path;
  bool shared;
  Chirality side;
  /// The link that carries each segment's surface at its base, by digit.
  std::map<std::string, std::vector<std::string>> links;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const Named& hand, std::ostream* out) {
  *out << hand.path;
}

class NamedHands : public ::testing::TestWithParam<Named> {};

TEST_P(NamedHands, HaveTheirDigitsAndSegmentsRightAndLeft) {
  const Named& hand = GetParam();
  if (hand.shared) HANDGRAFT_NEEDS_SHARED_DATA(hand.path);
  const HandModel right = io::readUrdf(hand.shared ? test::sharedData(hand.path)
                                                   : test::sourceDirectory() / hand.path)
                              .model;
  for (const bool is_mirrored : {false, true}) {
    const HandModel model = is_mirrored ? mirrored(right, "other") : right;
    const Anatomy anatomy = anatomyOfHand(model);
    std::map<std::string, std::vector<std::string>> links;
    for (const NamedDigit& digit : anatomy.digits) {
      for (const Segment& segment : digit.segments) {
        std::string name;  // the last link with a surface
        for (const int link : segment.links)
          if (!model.links()[static_cast<std::size_t>(link)].surface().empty())
            name = model.links()[static_cast<std::size_t>(link)].name;
        links[digit.name].push_back(name);
      }
    }
    EXPECT_EQ(links, hand.links);
    const Chirality other =
        hand.side == Chirality::kRight ? Chirality::kLeft : Chirality::kRight;
    if (hand.side == Chirality::kUnknown) continue;
    EXPECT_EQ(anatomy.chirality, is_mirrored ? other : hand.side);
  }
}

std::map<std::string, std::vector<std::string>> fiveOf(const std::string& first,
                                                       const std::string& second,
                                                       const std::string& third) {
  std::map<std::string, std::vector<std::string>> links;
  for (const char* digit : kDigits)
    links[digit] = {digit + first, digit + second, digit + third};
  return links;
}

/// Its thumb bends at the wrist, too: what names count from there is one bone off.
std::map<std::string, std::vector<std::string>> human20() {
  auto links = fiveOf("_proximal", "_middle", "_distal");
  links["thumb"] = {"thumb_metacarpal", "thumb_proximal", "thumb_distal"};
  return links;
}

INSTANTIATE_TEST_SUITE_P(
    Hands,
    NamedHands,
    ::testing::Values(Named{"hands/shadow_right/shadow_hand_right.urdf",
                            true,
                            Chirality::kRight,
                            {{"thumb", {"thproximal", "thmiddle", "thdistal"}},
                             {"index", {"ffproximal", "ffmiddle", "ffdistal"}},
                             {"middle", {"mfproximal", "mfmiddle", "mfdistal"}},
                             {"ring", {"rfproximal", "rfmiddle", "rfdistal"}},
                             {"little", {"lfproximal", "lfmiddle", "lfdistal"}}}},
                      Named{"hands/allegro_right/allegro_hand_right.urdf",
                            true,
                            Chirality::kRight,
                            {{"thumb", {"link_13.0", "link_14.0", "link_15.0_tip"}},
                             {"index", {"link_1.0", "link_2.0", "link_3.0_tip"}},
                             {"middle", {"link_5.0", "link_6.0", "link_7.0_tip"}},
                             {"ring", {"link_9.0", "link_10.0", "link_11.0_tip"}}}},
                      Named{"hands/mano_mean/mano_mean_fixed.urdf",
                            true,
                            Chirality::kRight,
                            {{"thumb", {"link_th_pm_z", "link_th_md_z", "link_th_dd_z"}},
                             {"index", {"link_ff_pm_z", "link_ff_md_z", "link_ff_dd_z"}},
                             {"middle", {"link_mf_pm_z", "link_mf_md_z", "link_mf_dd_z"}},
                             {"ring", {"link_rf_pm_z", "link_rf_md_z", "link_rf_dd_z"}},
                             {"little", {"link_lf_pm_z", "link_lf_md_z", "link_lf_dd_z"}}}},
                      Named{"hands/human_hand_graspit20/human_hand_graspit20.urdf",
                            true,
                            Chirality::kRight,
                            {{"thumb", {"thumb1", "thumb2", "thumb3"}},
                             {"index", {"index1", "index2", "index3"}},
                             {"middle", {"mid1", "mid2", "mid3"}},
                             {"ring", {"ring1", "ring2", "ring3"}},
                             {"little", {"pinky1", "pinky2", "pinky3"}}}},
                      Named{"hands/barrett_bhand/bhand_model.urdf",
                            true,
                            Chirality::kUnknown,
                            {{"thumb", {"finger_3_med_link", "finger_3_dist_link"}},
                             {"index", {"finger_1_med_liink", "finger_1_dist_link"}},
                             {"middle", {"finger_2_med_link", "finger_2_dist_link"}}}},
                      Named{"server/models/hands/human20/human20.urdf", false,
                            Chirality::kRight, human20()},
                      Named{"server/models/hands/tendon16/tendon16.urdf", false,
                            Chirality::kRight, fiveOf("_proximal", "_middle", "_distal")}),
    [](const auto& hand) {
      std::string stem = std::filesystem::path(hand.param.path).stem();
      std::erase_if(stem, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) == 0;
      });
      return stem;
    });

// Both sides of a claw are alike, but for one whose maker says which it is.
TEST(NamingStyles, AClawHasTheSideThatItsNamesSay) {
  Anatomy claw;
  claw.digits.resize(kClawDigits);
  claw.chirality = Chirality::kLeft;
  EXPECT_EQ(sideOf(claw), Chirality::kUnknown);
  claw.named_side = Chirality::kLeft;
  EXPECT_EQ(sideOf(claw), Chirality::kLeft);
  claw.named_side = Chirality::kUnknown;
  claw.digits.resize(kClawDigits + 1);
  EXPECT_EQ(sideOf(claw), Chirality::kLeft);
}

TEST(NamingStyles, SidesAreNamedAndReadBack) {
  for (const Chirality side : {Chirality::kRight, Chirality::kLeft})
    EXPECT_EQ(sideNamed(nameOf(side), "side"), side);
  try {
    sideNamed("links", "side");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("field 'side' is 'links'; permitted are 'right' and "));
  }
}

}  // namespace
}  // namespace handgraft::hand
