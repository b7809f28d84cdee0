#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/present/contacts_picture.h"
#include "client/present/hand_picture.h"
#include "client/present/picture_parts.h"
#include "core/base/error.h"

#include "tests/client/hands.h"

namespace handgraft::client {
namespace {

using render::Color;
using render::Image;

constexpr render::PictureSize kSize{900, 520};

// Pixels of exactly this colour in the views, left or right, without the legend below them.
int countOf(const Image& image, Color color, bool right) {
  int count = 0;
  const int middle = image.width() / 2;
  for (int y = 40; y < image.height() - 60; ++y) {
    for (int x = right ? middle : 0; x < (right ? image.width() : middle); ++x)
      count += image.at(x, y) == color ? 1 : 0;
  }
  return count;
}

TEST(PatchColor, IsItsFingersAndNoOtherPatchesOfAUsualSet) {
  std::vector<std::string> names{"palm", "palm_2"};
  for (const char* finger : {"thumb", "index", "middle", "ring", "little", "f1", "f2"}) {
    for (const char* segment : {"_proximal", "_middle", "_distal"}) {
      names.push_back(std::string(finger) + segment);
      names.push_back(names.back() + "_2");
    }
  }
  std::vector<Color> colors;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Color color = colorOf(names[i], i);
    EXPECT_EQ(std::count(colors.begin(), colors.end(), color), 0) << names[i];
    EXPECT_EQ(color, colorOf(names[i], i + 1)) << names[i];
    colors.push_back(color);
  }
  EXPECT_EQ(colorOf("index_middle", 3), colorOf("index", 0));
  const Color index = colorOf("index", 0);
  EXPECT_LT(colorOf("index_proximal", 0).b, index.b);
  EXPECT_GT(colorOf("index_distal_2", 0).b, index.b);
}

TEST(PatchColor, TakesTurnsWhereNamesSayNoFinger) {
  std::vector<Color> colors;
  for (std::size_t i = 0; i < 18; ++i) {
    const Color color = colorOf("c" + std::to_string(i + 1), i);
    EXPECT_EQ(std::count(colors.begin(), colors.end(), color), 0) << i;
    colors.push_back(color);
  }
}

TEST(HandPicture, ShowsEverySiteFromThePalmsSide) {
  const v1::HandDescription hand = test::flatHand();
  const HandPicture picture = pictureOfSites(hand);
  const Image image =
      render::renderTwoViews(picture.scene, picture.caption, picture.views, kSize);
  for (const char* name : {"thumb", "index", "middle", "palm"})
    EXPECT_GT(countOf(image, colorOf(name, 0), false), 60) << name;
}

TEST(HandPicture, LooksAtThePadsWithTheFingersUpAndThenFromTheThumbsSide) {
  const HandPicture picture = pictureOfSites(test::flatHand());
  EXPECT_GT(picture.views[0].from_W.normalized().z(), 0.95);
  EXPECT_GT(picture.views[0].up_W.y(), 0.7);
  EXPECT_GT(picture.views[1].from_W.normalized().x(), 0.9);
  EXPECT_GT(picture.views[1].up_W.y(), 0.7);
  // The mirrored hand is looked at from the other side.
  v1::HandDescription left = test::flatHand();
  left.X_SL()[3].p_m()[0] = -0.09;
  EXPECT_LT(pictureOfSites(left).views[1].from_W.normalized().x(), -0.9);
}

TEST(HandPicture, DrawsAHandWithoutSites) {
  v1::HandDescription hand = test::flatHand();
  hand.sites().clear();
  const HandPicture picture = pictureOfSites(hand);
  EXPECT_NO_THROW(render::renderTwoViews(picture.scene, picture.caption, picture.views, kSize));
}

TEST(HandPicture, RefusesDescriptionsThatContradictThemselves) {
  v1::HandDescription hand = test::flatHand();
  hand.X_SL().pop_back();
  EXPECT_THROW(pictureOfSites(hand), TransportError);
  hand = test::flatHand();
  hand.sites()[0].link("elbow");
  EXPECT_THROW(pictureOfSites(hand), TransportError);
  hand = test::flatHand();
  hand.skin_face_links().pop_back();
  EXPECT_THROW(pictureOfSkin(hand), TransportError);
  hand = test::flatHand();
  hand.skin_S().triangles()[5] = 99;
  EXPECT_THROW(pictureOfSkin(hand), TransportError);
}

TEST(SkinPicture, HasAnEntryForEachLinkThatTheSkinIsOf) {
  const HandPicture picture = pictureOfSkin(test::flatHand());
  ASSERT_EQ(picture.caption.legend.size(), 3U);
  EXPECT_EQ(picture.caption.legend[0].text, "on no link");
  EXPECT_EQ(picture.caption.legend[1].text, "palm");
  EXPECT_EQ(picture.caption.legend[2].text, "index_tip");
  const render::SurfaceMesh& mesh = picture.scene.layers[0].meshes[0];
  EXPECT_EQ(mesh.vertex_colors[3 * 3], picture.caption.legend[2].color);
  EXPECT_EQ(mesh.vertex_colors[3 * 4], picture.caption.legend[0].color);
}

v1::ContactsDescription withMap() {
  v1::ContactsDescription set = test::squareOnBox();
  v1::MapInfo map;
  map.mesh_O(test::boxObject().mesh_O());
  map.value() = {0, 0, 0, 0, 1, 1, 1, 1};  // the top touches
  map.threshold(0.4);
  set.contact_map().push_back(map);
  return set;
}

TEST(ContactsPicture, LooksAtThePatchAndShowsItsOutline) {
  const ContactsPicture picture = pictureOf(withMap(), test::boxObject(), {});
  EXPECT_GT(picture.views[0].from_W.z(), 0.5);
  const Image image =
      render::renderTwoViews(picture.scene, picture.caption, picture.views, kSize);
  EXPECT_GT(countOf(image, colorOf("index", 0), false), 300);
}

TEST(ContactsPicture, DarkensWithContact) {
  const ContactsPicture picture = pictureOf(withMap(), test::boxObject(), {});
  const render::SurfaceMesh& mesh = picture.scene.layers[0].meshes[0];
  ASSERT_EQ(mesh.vertex_colors.size(), 8U);
  EXPECT_GT(mesh.vertex_colors[0].g, mesh.vertex_colors[7].g + 100);
}

TEST(ContactsPicture, ShowsValuesOfAnyScaleBetweenTheirExtremes) {
  v1::ContactsDescription set = withMap();
  const auto shares = pictureOf(set, test::boxObject(), {}).scene.layers[0].meshes[0];
  for (float& value : set.contact_map()[0].value())
    value = 20.0F + 15.0F * value;  // as degrees
  const ContactsPicture picture = pictureOf(set, test::boxObject(), {});
  EXPECT_EQ(picture.scene.layers[0].meshes[0].vertex_colors, shares.vertex_colors);
  EXPECT_EQ(picture.caption.legend.back().text, "35");
}

TEST(ContactsPicture, PutsAPosedHandAboutTheObject) {
  PosedLinks hand;
  hand.surfaces_L = {test::box({-0.01F, -0.01F, -0.01F}, {0.01F, 0.01F, 0.01F})};
  hand.X_OL = {test::poseAt(0.0, 0.0, 0.06)};
  const ContactsPicture picture = pictureOf(test::squareOnBox(), test::boxObject(), hand);
  ASSERT_EQ(picture.scene.layers.size(), 2U);
  EXPECT_LT(picture.scene.layers[1].opacity, 0.6);
  EXPECT_NEAR(picture.scene.layers[1].meshes[0].vertices_W[7].z(), 0.07F, 1e-6F);
}

TEST(ContactsPicture, RefusesDescriptionsThatContradictThemselves) {
  v1::ContactsDescription set = withMap();
  set.contact_map()[0].value().pop_back();
  EXPECT_THROW(pictureOf(set, test::boxObject(), {}), TransportError);
  set = test::squareOnBox();
  set.patches()[0].root().face(12);
  EXPECT_THROW(pictureOf(set, test::boxObject(), {}), TransportError);
  set.patches()[0].root().face(-1);
  EXPECT_THROW(pictureOf(set, test::boxObject(), {}), TransportError);
}

}  // namespace
}  // namespace handgraft::client
