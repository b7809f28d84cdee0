// Places on built-in hands: there and back, mirrored, and carried from one hand to another.
#include "core/hand/finger_coordinates.h"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/hand/mirror.h"
#include "core/hand/skin_cache.h"
#include "core/hand/variant.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

struct Hand {
  explicit Hand(HandModel made) : model(std::move(made)) {}

  HandModel model;
  Skin skin = SkinCache::fromEnvironment().get(model, {}, Progress());
  FingerCoordinates coordinates{model, skin, {}};
};

HandModel builtIn(const std::string& name) {
  return io::readUrdf(test::sourceDirectory() / "server/models/hands" / name / (name + ".urdf"))
      .model;
}

geometry::SurfacePoint middleOf(int face) {
  return {face, Eigen::Vector3d::Constant(1.0 / 3.0)};
}

/// The link that a place of the skin belongs to, and where on it, in its frame.
std::pair<int, Eigen::Vector3d> onLink(const Hand& hand, const SkinSpot& spot) {
  const int link = hand.skin.faceLinks()[static_cast<std::size_t>(spot.root_S.face)];
  LinkPoses X_SL;
  forwardKinematics(hand.model, Pose::Identity(), hand.skin.qReference(), X_SL);
  return {link, inverse(X_SL[static_cast<std::size_t>(link)]) *
                    geometry::positionOf(hand.skin.mesh(), spot.root_S)};
}

class BuiltInHands : public ::testing::TestWithParam<const char*> {};

TEST_P(BuiltInHands, FindEveryPlaceAgain) {
  const Hand hand(builtIn(GetParam()));
  const geometry::TriangleMesh& mesh = hand.skin.mesh();
  int asked = 0;
  int found = 0;
  for (int f = 0; f < mesh.faceCount(); f += 13) {
    const auto place = hand.coordinates.placeOf(middleOf(f));
    // A palm's place tells no depth, and robots' palms are frames of many sheets.
    if (!place || place->digit == kPalmPart) continue;
    const auto spot = hand.coordinates.spotAt(*place);
    ++asked;
    if (!spot) continue;
    const double off =
        (geometry::positionOf(mesh, spot->root_S) - geometry::positionOf(mesh, middleOf(f)))
            .norm();
    if (off < 0.002) ++found;
  }
  EXPECT_GT(asked, 250);
  // The rest lies behind another sheet of the skin, as seen from the bone.
  EXPECT_GT(found, 0.93 * asked);
}

TEST_P(BuiltInHands, PointBackAlongTheBone) {
  const Hand hand(builtIn(GetParam()));
  for (const NamedDigit& digit : hand.coordinates.anatomy().digits) {
    for (const Segment& segment : digit.segments) {
      HandLocation place;
      place.digit = digit.name;
      place.segment = segment.name;
      place.segment_count = static_cast<int>(digit.segments.size());
      for (const double around : {-1.5, 0.0, 1.5}) {
        place.around_rad = around;
        const auto spot = hand.coordinates.spotAt(place);
        ASSERT_TRUE(spot.has_value()) << digit.name << segment.name;
        EXPECT_LT(spot->direction_S.dot(segment.boneInSkin()), -0.3)
            << digit.name << segment.name;
        EXPECT_NEAR(spot->direction_S.norm(), 1.0, 1e-9);
        EXPECT_NEAR(spot->direction_S.dot(geometry::normalOf(hand.skin.mesh(), spot->root_S)),
                    0.0, 1e-9);
        if (around != 0.0) continue;
        const Eigen::Vector3d n_S = geometry::normalOf(hand.skin.mesh(), spot->root_S);
        EXPECT_GT(n_S.dot(segment.palmar_S), 0.3) << digit.name << segment.name;
      }
    }
  }
}

TEST_P(BuiltInHands, MirrorTheirPlaces) {
  const Hand right(builtIn(GetParam()));
  const Hand left(mirrored(right.model, "left"));
  const Eigen::Vector3d flip(-1.0, 1.0, 1.0);
  for (const NamedDigit& digit : right.coordinates.anatomy().digits) {
    for (const double around : {-0.8, 0.0, 0.8}) {
      HandLocation place;
      place.digit = digit.name;
      place.segment = "distal";
      place.segment_count = static_cast<int>(digit.segments.size());
      place.around_rad = around;
      const auto here = right.coordinates.spotAt(place);
      const auto there = left.coordinates.spotAt(place);
      ASSERT_TRUE(here && there) << digit.name;
      // Their reference poses differ: places are compared on the links.
      const auto [link, p] = onLink(right, *here);
      const auto [mirrored_link, q] = onLink(left, *there);
      EXPECT_EQ(link, mirrored_link) << digit.name << around;
      EXPECT_LT((flip.asDiagonal() * p - q).norm(), 0.004) << digit.name << around;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Library,
                         BuiltInHands,
                         ::testing::Values("human20", "allegro16", "tendon16", "barrett8"));

TEST(FingerCoordinates, CountPositiveTowardsTheThumb) {
  const Hand hand(builtIn("human20"));
  HandLocation place{"middle", "proximal", 3, 0.5, 1.5, 0.5, -1.0};
  const auto spot = hand.coordinates.spotAt(place);
  ASSERT_TRUE(spot.has_value());
  ASSERT_TRUE(hand.coordinates.anatomy().palm.has_value());
  EXPECT_GT(geometry::normalOf(hand.skin.mesh(), spot->root_S)
                .dot(hand.coordinates.anatomy().palm->thumb_side_S),
            0.7);
}

/// A hand of twice the size touches as many metres from the knuckle, on a segment before.
TEST(FingerCoordinates, GoByLengthFromTheKnuckle) {
  const Hand hand(builtIn("human20"));
  const Hand large(makeVariant(hand.model, "large", {{HandProperty::kSize, "", 2.0}}).model);
  const NamedDigit& digit = *large.coordinates.anatomy().maybeDigit("index");
  HandLocation place{"index", "middle", 3, 0.5, 0.0, 0.5, 0.4};
  const auto spot = large.coordinates.spotByLength(place);
  ASSERT_TRUE(spot.has_value());
  const Eigen::Vector3d p_S = geometry::positionOf(large.skin.mesh(), spot->root_S);
  const Segment& proximal = digit.segments.front();
  // Of a human finger's 90 mm, six tenths lie before the place.
  EXPECT_NEAR((p_S - proximal.base_S).dot(proximal.boneInSkin()), 0.6 * 0.09, 0.004);
  EXPECT_EQ(large.coordinates.placeOf(spot->root_S)->segment, "proximal");
  EXPECT_EQ(large.coordinates.placeOf(large.coordinates.spotAt(place)->root_S)->segment,
            "middle");
  EXPECT_FALSE(large.coordinates.spotByLength({"palm", "", 0, 0.5, 0.0, 0.5, -1.0}));
}

/// Of two segments where the place was taken from three: as far from the tip by length.
TEST(FingerCoordinates, GoByLengthWhereSegmentsDiffer) {
  const Hand hand(builtIn("barrett8"));
  const NamedDigit* digit = hand.coordinates.anatomy().maybeDigit("index");
  ASSERT_NE(digit, nullptr);
  ASSERT_EQ(digit->segments.size(), 2U);
  HandLocation place{"index", "middle", 3, 0.5, 0.0, 0.5, 0.4};
  const auto spot = hand.coordinates.spotAt(place);
  ASSERT_TRUE(spot.has_value());
  const auto back = hand.coordinates.placeOf(spot->root_S);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->from_tip, 0.4, 0.03);
}

TEST(FingerCoordinates, KnowNoPlaceOnADigitThatIsMissing) {
  const Hand hand(builtIn("allegro16"));
  EXPECT_FALSE(hand.coordinates.spotAt({"little", "distal", 3}).has_value());
  EXPECT_TRUE(hand.coordinates.spotAt({"ring", "distal", 3}).has_value());
}

TEST(FingerCoordinates, AreSharedByWhoAsksForTheSameSites) {
  handgraft::hand::Hand hand;
  hand.model = std::make_shared<const HandModel>(builtIn("allegro16"));
  hand.skin = std::make_shared<const Skin>(
      SkinCache::fromEnvironment().get(*hand.model, {}, Progress()));
  hand.sites = findContactSites(*hand.model, *hand.skin);
  const auto first = coordinatesOf(hand);
  handgraft::hand::Hand other = hand;
  EXPECT_EQ(coordinatesOf(other), first);
  other.sites.pop_back();
  EXPECT_NE(coordinatesOf(other), first);
  EXPECT_EQ(coordinatesOf(hand), first);
}

TEST(HandPlaces, AreReadFromNames) {
  const auto place = placeNamed("index_proximal_2");
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->digit, "index");
  EXPECT_EQ(place->segment, "proximal");
  EXPECT_EQ(placeNamed("palm")->digit, "palm");
  EXPECT_EQ(placeNamed("palm_2")->digit, "palm");
  EXPECT_EQ(placeNamed("f2_distal")->digit, "f2");
  for (const char* name : {"index", "thumb_2", "indx_distal", "index_", "_distal",
                           "palm_distal", "distal", "", "c1"})
    EXPECT_FALSE(placeNamed(name).has_value()) << name;
}

}  // namespace
}  // namespace handgraft::hand
