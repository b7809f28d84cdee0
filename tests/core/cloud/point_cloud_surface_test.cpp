#include "core/cloud/point_cloud_surface.h"

#include <cmath>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::cloud {
namespace {

using geometry::TriangleMesh;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kRadius = 0.03;

PointCloud sphereCloud(int subdivisions = 4) {
  return {geometry::makeSphere(kRadius, subdivisions).vertices(), {}};
}

/// Farthest that vertices and middles of faces are from the sphere of kRadius.
double offSphere(const TriangleMesh& mesh) {
  double worst = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int v : mesh.face(f)) {
      worst = std::max(worst, std::abs(mesh.vertex(v).norm() - kRadius));
      middle += mesh.vertex(v) / 3.0;
    }
    worst = std::max(worst, std::abs(middle.norm() - kRadius));
  }
  return worst;
}

bool facesAwayFromOrigin(const TriangleMesh& mesh) {
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (mesh.faceNormals().col(f).dot(mesh.vertex(mesh.face(f)[0])) <= 0.0) return false;
  return true;
}

std::string faultOf(const PointCloud& cloud) {
  try {
    surfaceOf(cloud);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CloudSurface, ClosesASphereWithAndWithoutNormals) {
  for (const bool with_normals : {false, true}) {
    PointCloud cloud = sphereCloud();
    if (with_normals) cloud.normals_O = cloud.points_O.colwise().normalized();
    const CloudSurface surface = surfaceOf(cloud);
    EXPECT_EQ(surface.method, Method::kPoisson);
    EXPECT_TRUE(surface.mesh_O.isClosed());
    EXPECT_EQ(surface.mesh_O.eulerCharacteristic(), 2);
    EXPECT_TRUE(facesAwayFromOrigin(surface.mesh_O));
    // The middle of a triangle of edge e lies e^2 / (6 R) below the sphere; the fit may be off
    // by a tenth of the spacing besides.
    const double s = surface.spacing_m;
    EXPECT_LT(offSphere(surface.mesh_O), s * s / kRadius + 0.1 * s);
    EXPECT_LT(surface.max_m, 0.1 * s);
    EXPECT_EQ(surface.invented_share, 0.0);
  }
}

TEST(CloudSurface, SmoothsNoise) {
  PointCloud cloud = sphereCloud();
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2e-4);
  for (Eigen::Index i = 0; i < cloud.points_O.cols(); ++i)
    cloud.points_O.col(i) *= 1.0 + noise(random) / kRadius;
  const CloudSurface surface = surfaceOf(cloud);
  ASSERT_TRUE(surface.mesh_O.isClosed());
  double sum = 0.0;
  for (int v = 0; v < surface.mesh_O.vertexCount(); ++v)
    sum += std::abs(surface.mesh_O.vertex(v).norm() - kRadius);
  // Points themselves are off by sqrt(2 / pi) sigma on average, 0.16 mm.
  EXPECT_LT(sum / surface.mesh_O.vertexCount(), 1.6e-4);
}

TEST(CloudSurface, LeavesAnOpenScanOpen) {
  const Eigen::Matrix3Xd sphere = sphereCloud().points_O;
  PointCloud half;
  half.points_O.resize(3, sphere.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < sphere.cols(); ++i)
    if (sphere(2, i) >= 0.0) half.points_O.col(count++) = sphere.col(i);
  half.points_O.conservativeResize(3, count);
  const CloudSurface surface = surfaceOf(half);
  EXPECT_EQ(surface.method, Method::kAdvancingFront);
  EXPECT_FALSE(surface.mesh_O.isClosed());
  EXPECT_EQ(surface.mesh_O.eulerCharacteristic(), 1);  // a disk
  EXPECT_TRUE(facesAwayFromOrigin(surface.mesh_O));
  EXPECT_NEAR(surface.max_m, 0.0, 1e-12);
  EXPECT_THAT(surface.notes, Contains(HasSubstr("an open scan")));

  half.normals_O = -half.points_O.colwise().normalized();  // a bowl, seen from inside
  const TriangleMesh bowl = surfaceOf(half).mesh_O;
  EXPECT_LT(bowl.faceNormals().col(0).dot(bowl.vertex(bowl.face(0)[0])), 0.0);
}

TEST(CloudSurface, RoundsABoxByLessThanItsSpacing) {
  constexpr int kSteps = 24;
  const double step = 0.04 / kSteps;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k)
        if (i % kSteps == 0 || j % kSteps == 0 || k % kSteps == 0)
          points.emplace_back(step * i, step * j, step * k);
  PointCloud cloud;
  cloud.points_O.resize(3, std::ssize(points));
  for (std::size_t i = 0; i < points.size(); ++i)
    cloud.points_O.col(static_cast<Eigen::Index>(i)) = points[i];
  const CloudSurface surface = surfaceOf(cloud);
  EXPECT_TRUE(surface.mesh_O.isClosed());
  EXPECT_LT(surface.max_m, 1.0 * surface.spacing_m);
}

TEST(CloudSurface, KeepsTheLargerOfTwoPieces) {
  const Eigen::Matrix3Xd large = sphereCloud(4).points_O;
  const Eigen::Matrix3Xd small = sphereCloud(2).points_O * 0.2;
  PointCloud cloud;
  cloud.points_O.resize(3, large.cols() + small.cols());
  cloud.points_O << small.colwise() + Eigen::Vector3d(0.1, 0, 0), large;
  const CloudSurface surface = surfaceOf(cloud);
  EXPECT_EQ(surface.point_count, large.cols());
  EXPECT_EQ(surface.mesh_O.components().second, 1);
  EXPECT_THAT(surface.notes, Contains(HasSubstr("left out 162 of 2724 points")));
}

TEST(CloudSurface, GivesTheSameSurfaceTwice) {
  const CloudSurface first = surfaceOf(sphereCloud(3));
  const TriangleMesh second = surfaceOf(sphereCloud(3)).mesh_O;
  // CGAL's mesher breaks ties by addresses: not the same triangles, but the same surface.
  const geometry::SurfaceLocator locator(first.mesh_O);
  for (int v = 0; v < second.vertexCount(); ++v)
    EXPECT_LT(locator.nearest(second.vertex(v)).distance, 0.1 * first.spacing_m);
}

TEST(CloudSurface, ThinsAndMergesWithANote) {
  PointCloud cloud = sphereCloud(4);
  cloud.points_O = Eigen::Matrix3Xd(cloud.points_O.replicate(1, 2));
  SurfaceOptions options;
  options.most_points = 1000;
  const CloudSurface surface = surfaceOf(cloud, options);
  EXPECT_LE(surface.point_count, 1000);
  EXPECT_THAT(surface.notes, Contains("merged 5124 points to 2562"));
  EXPECT_THAT(surface.notes, Contains(HasSubstr("thinned 2562 points to")));
}

TEST(CloudSurface, RefusesWhatIsNoSurface) {
  EXPECT_THAT(faultOf({Eigen::Matrix3Xd::Random(3, 29), {}}), HasSubstr("at least 30"));
  EXPECT_THAT(faultOf({Eigen::Matrix3Xd::Zero(3, 99), {}}), HasSubstr("1 distinct points"));
  PointCloud plane{Eigen::Matrix3Xd::Random(3, 400), {}};
  plane.points_O.row(2).setZero();
  EXPECT_THAT(faultOf(plane), HasSubstr("a plane"));
  plane.points_O.row(1).setZero();
  EXPECT_THAT(faultOf(plane), HasSubstr("a line"));
  PointCloud broken = sphereCloud(2);
  broken.points_O(1, 7) = std::nan("");
  EXPECT_THAT(faultOf(broken), HasSubstr("point 7 is"));
}

TEST(CloudSurface, StopsWhenAsked) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(surfaceOf(sphereCloud(3), {}, progress), Cancelled);
}

TEST(CloudSurface, FindsARealScanAgain) {
  HANDGRAFT_NEEDS_SHARED_DATA("objects/ycb_16k/014_lemon.stl");
  const TriangleMesh truth =
      io::readMesh(test::sharedData("objects/ycb_16k/014_lemon.stl")).mesh;
  const CloudSurface surface = surfaceOf({truth.vertices(), {}});
  const geometry::SurfaceLocator locator(truth);
  double sum = 0.0;
  for (int v = 0; v < surface.mesh_O.vertexCount(); ++v)
    sum += locator.nearest(surface.mesh_O.vertex(v)).distance;
  EXPECT_LT(sum / surface.mesh_O.vertexCount(), 5e-5);  // 0.006 mm when this was written
  EXPECT_EQ(surface.mesh_O.eulerCharacteristic(), 2);
}

}  // namespace
}  // namespace handgraft::cloud
