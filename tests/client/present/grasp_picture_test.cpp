#include "client/present/grasp_picture.h"

#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/present/text_output.h"
#include "core/base/error.h"

#include "tests/client/present/example_grasp.h"

namespace handgraft::client {
namespace {

using testing::StartsWith;

TEST(GraspPicture, PosesTheLinksAndDrawsEveryPair) {
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  const GraspPicture picture = pictureOf(exampleGrasp(), object, {});
  ASSERT_EQ(picture.scene.layers.size(), 2U);
  const auto& object_layer = picture.scene.layers[0];
  const auto& hand_layer = picture.scene.layers[1];
  EXPECT_LT(object_layer.opacity, 1.0);  // patches behind it are seen
  ASSERT_EQ(hand_layer.meshes.size(), 2U);
  EXPECT_NEAR(hand_layer.meshes[1].vertices_W[1].x(), 0.3F + 0.1F, 1e-6F);
  EXPECT_NEAR(object_layer.meshes[0].vertices_W[0].x(), 0.2F, 1e-6F);
  EXPECT_EQ(picture.scene.markers.size(), 3U);       // one a pair
  EXPECT_EQ(picture.scene.segments.size(), 3U * 3);  // two outlines of three sides, three pairs
  ASSERT_EQ(picture.caption.legend.size(), 2U);
  EXPECT_EQ(picture.caption.legend[0].text, "thumb 1.2 mm (max 2.5) not reached");
  EXPECT_EQ(picture.caption.legend[1].text, "ring dropped");
  EXPECT_NO_THROW(render::renderTwoViews(picture.scene, picture.caption, {300, 250}));
}

TEST(GraspPicture, SaysWhatPeopleCallTheModelsAndWhatIsReached) {
  GraspResult result = exampleGrasp();
  result.session.hand("claw-00c0ffee");
  result.hand.mirrored(true);
  result.session.contacts("plate_2-0123abcd");
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  const render::Caption caption = pictureOf(result, object, {}).caption;
  EXPECT_EQ(caption.title, "claw (mirrored) grasps plate");
  EXPECT_THAT(caption.subtitle,
              StartsWith("contacts plate_2: 0 of 1 patch reached, objective"));
  EXPECT_THAT(text::grasp(result), StartsWith("claw (mirrored) grasps plate by plate_2\n"));
}

// A forearm, far from the object, may be cut off; what grasps may not.
TEST(GraspPicture, FramesWhatGraspsWholly) {
  GraspResult result = exampleGrasp();
  result.solution.X_WL()[1] = poseAt(0.45);
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  const float reach_m = 0.55F;  // of that link's mesh, from W
  EXPECT_LT(pictureOf(result, object, {}).scene.framed_W.max().x(), reach_m - 0.01F);
  v1::SegmentInfo segment;
  segment.link("tip");
  result.hand.digits().emplace_back();
  result.hand.digits()[0].segments().push_back(segment);
  EXPECT_GE(pictureOf(result, object, {}).scene.framed_W.max().x(), reach_m - 1e-6F);
}

TEST(GraspPicture, MarksLostPoints) {
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  v1::PatchInfo patch;
  patch.name("thumb");
  patch.outline_O_m() = {0, 0, 0, 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.05};
  v1::ContactsDescription contacts;
  contacts.patches().push_back(patch);
  const GraspPicture plain = pictureOf(exampleGrasp(), object, {});
  const GraspPicture picture = pictureOf(exampleGrasp(), object, contacts);
  ASSERT_EQ(picture.scene.markers.size(), plain.scene.markers.size() + 1);
  // Point 3 of the outline, placed with the object.
  EXPECT_TRUE(picture.scene.markers.back().center_W.isApprox(Eigen::Vector3f(0.2F, 0, 0.05F)));
  EXPECT_EQ(picture.caption.legend.back().text, "lost: 1");
}

TEST(GraspPicture, KeepsInteriorPointsOutOfTheOutline) {
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  GraspResult result = exampleGrasp();
  v1::PatchFit& fit = result.solution.patches()[0];
  for (std::vector<double>* points : {&fit.hand_W_m(), &fit.object_W_m()})
    points->insert(points->end(), {0.003, 0.003, 0.0});
  const GraspPicture picture = pictureOf(result, object, {});
  EXPECT_EQ(picture.scene.layers[0].decals[0].loop_W.size(), 3U);
  EXPECT_EQ(picture.scene.segments.size(), 2U * 3 + 4);  // outlines of three sides, four pairs
}

TEST(GraspPicture, RefusesAHostileMesh) {
  v1::ObjectDescription object;
  object.mesh_O() = triangle();
  object.mesh_O().triangles()[1] = 4000000000U;
  const GraspPicture picture = pictureOf(exampleGrasp(), object, {});
  EXPECT_THROW(render::renderTwoViews(picture.scene, picture.caption, {300, 250}),
               InvalidInput);
}

}  // namespace
}  // namespace handgraft::client
