#include "core/cloud/point_cloud_surface.h"

#include <cmath>
#include <random>
#include <string>
#include <thread>
#include <vector>

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
using ::testing::Not;

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

/// A grid on a box's faces, 40 mm wide.
PointCloud boxCloud() {
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
  return cloud;
}

std::string faultOf(const PointCloud& cloud) {
  try {
    surfaceOf(cloud);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CloudSurface, JoinsCleanPointsWithAndWithoutNormals) {
  for (const bool with_normals : {false, true}) {
    PointCloud cloud = sphereCloud();
    if (with_normals) cloud.normals_O = cloud.points_O.colwise().normalized();
    const CloudSurface surface = surfaceOf(cloud);
    EXPECT_EQ(surface.method, Method::kAdvancingFront);
    EXPECT_TRUE(surface.mesh_O.isClosed());
    EXPECT_EQ(surface.hole_count, 0);
    EXPECT_EQ(surface.handle_count, 0);
    EXPECT_EQ(surface.mesh_O.vertexCount(), cloud.points_O.cols());
    EXPECT_TRUE(facesAwayFromOrigin(surface.mesh_O));
    EXPECT_NEAR(surface.max_m, 0.0, 1e-12);
    EXPECT_THAT(surface.notes, Not(Contains(HasSubstr("check:"))));
  }
}

TEST(CloudSurface, FitsASphereWithAndWithoutNormals) {
  SurfaceOptions options;
  options.method = Method::kPoisson;
  for (const bool with_normals : {false, true}) {
    PointCloud cloud = sphereCloud();
    if (with_normals) cloud.normals_O = cloud.points_O.colwise().normalized();
    const CloudSurface surface = surfaceOf(cloud, options);
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
  EXPECT_EQ(surface.method, Method::kPoisson);
  EXPECT_THAT(surface.notes, Contains(HasSubstr("the points are noisy")));
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
  EXPECT_EQ(surface.hole_count, 1);
  EXPECT_NEAR(surface.widest_hole_m, 2.0 * kRadius, surface.spacing_m);
  EXPECT_THAT(surface.notes,
              Contains(HasSubstr("check: the surface has 1 hole, up to 60.0 mm")));
  EXPECT_TRUE(facesAwayFromOrigin(surface.mesh_O));
  EXPECT_NEAR(surface.max_m, 0.0, 1e-12);
  EXPECT_THAT(surface.notes, Contains(HasSubstr("an open scan")));

  half.normals_O = -half.points_O.colwise().normalized();  // a bowl, seen from inside
  const TriangleMesh bowl = surfaceOf(half).mesh_O;
  EXPECT_LT(bowl.faceNormals().col(0).dot(bowl.vertex(bowl.face(0)[0])), 0.0);
}

TEST(CloudSurface, RoundsABoxByLessThanItsSpacing) {
  SurfaceOptions options;
  options.method = Method::kPoisson;
  const CloudSurface surface = surfaceOf(boxCloud(), options);
  EXPECT_TRUE(surface.mesh_O.isClosed());
  EXPECT_LT(surface.max_m, 1.0 * surface.spacing_m);
}

TEST(CloudSurface, KeepsABoxesEdgesSharp) {
  const CloudSurface surface = surfaceOf(boxCloud());
  EXPECT_TRUE(surface.mesh_O.isClosed());
  // The front may nick an edge by a cell of the grid: 1 of 3456.
  constexpr double kArea = 6.0 * 0.04 * 0.04;
  EXPECT_NEAR(surface.mesh_O.area(), kArea, 5e-4 * kArea);
}

TEST(CloudSurface, WarnsOfUnevenPoints) {
  PointCloud cloud = boxCloud();
  // Corners of a finely cut base below corners of large faces, as CAD files have them.
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < cloud.points_O.cols(); ++i) {
    const Eigen::Array3d step = cloud.points_O.col(i).array() / (0.04 / 24);
    if (step.z() < 2.5 || (step / 12.0 - (step / 12.0).round()).abs().maxCoeff() < 1e-6)
      kept.push_back(i);
  }
  cloud.points_O = Eigen::Matrix3Xd(cloud.points_O(Eigen::all, kept));
  EXPECT_THAT(surfaceOf(cloud).notes, Contains(HasSubstr("check: the points are uneven")));
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

bool sameBytes(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
         a.vertices() == b.vertices() && a.faces() == b.faces();
}

TEST(CloudSurface, GivesTheSameBytesTwiceAndInAnyThread) {
  // Sphere and box: the one has the roundings that fronts and meshers break, the other the
  // ties.
  for (const PointCloud& cloud : {sphereCloud(), boxCloud()}) {
    for (const Method method : {Method::kPoisson, Method::kAdvancingFront}) {
      SurfaceOptions options;
      options.method = method;
      const TriangleMesh first = surfaceOf(cloud, options).mesh_O;
      // Other addresses: the heap is in use.
      const std::vector<std::vector<char>> ballast(1000, std::vector<char>(777));
      EXPECT_TRUE(sameBytes(surfaceOf(cloud, options).mesh_O, first)) << nameOf(method);
      TriangleMesh other;
      std::thread([&] {
        other = surfaceOf(cloud, options).mesh_O;
      }).join();
      EXPECT_TRUE(sameBytes(other, first)) << nameOf(method);
    }
  }
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

TEST(CloudSurface, ComesToAnEndWherePointsFillSpace) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 0.1);
  PointCloud cloud{Eigen::Matrix3Xd(3, 200), {}};
  for (Eigen::Index i = 0; i < 200; ++i)
    cloud.points_O.col(i) << uniform(random), uniform(random), uniform(random);
  EXPECT_THAT(surfaceOf(cloud).notes, Contains(HasSubstr("check: ")));
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
  EXPECT_LT(sum / surface.mesh_O.vertexCount(), 1e-12);  // its vertices are the points
  EXPECT_EQ(surface.mesh_O.eulerCharacteristic(), 2);
}

TEST(CloudSurface, KeepsTheHandlesOfARealScan) {
  HANDGRAFT_NEEDS_SHARED_DATA("objects/ycb_16k/037_scissors.stl");
  const TriangleMesh truth =
      io::readMesh(test::sharedData("objects/ycb_16k/037_scissors.stl")).mesh;
  const CloudSurface surface = surfaceOf({truth.vertices(), {}});
  EXPECT_TRUE(surface.mesh_O.isClosed());
  EXPECT_EQ(surface.mesh_O.eulerCharacteristic(), truth.eulerCharacteristic());
  EXPECT_EQ(surface.handle_count, 3);
}

}  // namespace
}  // namespace handgraft::cloud
