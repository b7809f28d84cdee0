#include "core/io/texture_map.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/io/contact_map_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kBulb = "contacts/contactpose/light_bulb.glb";
constexpr const char* kPicture = "contacts/contactpose/full28_use_light_bulb.png";

TEST(TextureMap, AgreesWithTheMapThatOthersReadFromThePicture) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const contact::ContactMap map =
      readTextureMap(test::sharedData(kBulb), test::sharedData(kPicture), colorMap("inferno"));
  const contact::ContactMap given = readContactMap(
      test::sharedData("contacts/contactpose/full28_use_light_bulb_contact.ply"));
  const geometry::SurfaceLocator surface(map.mesh_O);
  Eigen::VectorXd ours = Eigen::VectorXd::Zero(given.value.size());
  for (int v = 0; v < given.mesh_O.vertexCount(); ++v) {
    const auto hit = surface.nearest(given.mesh_O.vertex(v));
    EXPECT_LT(hit.distance, 1e-4);
    for (int i = 0; i < 3; ++i)
      ours[v] += hit.point.barycentric[i] * map.value[map.mesh_O.face(hit.point.face)[i]];
  }
  const double mean_difference = (ours - given.value).cwiseAbs().mean();
  const Eigen::VectorXd a = ours.array() - ours.mean();
  const Eigen::VectorXd b = given.value.array() - given.value.mean();
  const double correlation = a.normalized().dot(b.normalized());
  RecordProperty("mean_difference", std::to_string(mean_difference));
  RecordProperty("correlation", std::to_string(correlation));
  EXPECT_LT(mean_difference, 0.02);
  EXPECT_GT(correlation, 0.98);  // with the picture upside down about 0
}

TEST(TextureMap, RefusesAScaleThatDoesNotFit) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  EXPECT_THAT(
      [&] {
        readTextureMap(test::sharedData(kBulb), test::sharedData(kPicture),
                       colorMap("viridis"));
      },
      ThrowsMessage<InvalidInput>(HasSubstr("nearest scale is 'inferno'")));
}

}  // namespace
}  // namespace handgraft::io
