#include "core/contact/outline.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <gtest/gtest.h>

#include "core/contact/threshold.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

constexpr double kStep = 0.001;
constexpr double kThreshold = 0.4;

/// Contact given by place on a plate of 100 x 100 mm, and the region above the threshold.
struct Touched {
  geometry::TriangleMesh mesh = test::makePlate(100, 100, kStep);
  Eigen::VectorXd value;
  Region region;

  explicit Touched(const std::function<double(double x, double y)>& contact) {
    value.resize(mesh.vertexCount());
    for (int v = 0; v < mesh.vertexCount(); ++v)
      value[v] = contact(mesh.vertex(v).x(), mesh.vertex(v).y());
    for (int f = 0; f < mesh.faceCount(); ++f) {
      const Eigen::Vector3i face = mesh.face(f);
      if (std::min({value[face[0]], value[face[1]], value[face[2]]}) > kThreshold)
        region.push_back(f);
    }
  }

  [[nodiscard]] Region outlinedWith(const OutlineOptions& options) const {
    Region inside = outlined(mesh, region, value, smoothed(mesh, value, kOutlineSmoothingSteps),
                             vertexAreas(mesh), options)
                        .front();
    std::sort(inside.begin(), inside.end());
    return inside;
  }
};

double areaOf(const Region& region) {
  return static_cast<double>(region.size()) * 0.5 * kStep * kStep;
}

/// A tent: contact falls evenly from 1 to 0 at 30 mm from (x0, y0).
double tent(double x, double y, double x0 = 0.0, double y0 = 0.0) {
  return std::max(0.0, 1.0 - std::hypot(x - x0, y - y0) / 0.030);
}

TEST(Outline, LiesWhereATentFallsBelowTheShareOfWhatItReaches) {
  const Touched touched([](double x, double y) {
    return tent(x, y);
  });
  for (const double share : {0.6, 0.75, 0.9}) {
    // The region ends at 18 mm; 5 % of its area lie within 18 mm * sqrt(0.05).
    const double top = 1.0 - 0.018 * std::sqrt(0.05) / 0.030;
    const double radius = 0.030 * (1.0 - share * top);
    const double area = areaOf(touched.outlinedWith({share}));
    EXPECT_NEAR(std::sqrt(area / 3.14159265), radius, 0.5 * kStep) << share;
  }
}

TEST(Outline, DoesNotDependOnTheScaleOfTheValues) {
  const Touched whole([](double x, double y) {
    return tent(x, y);
  });
  Touched half = whole;
  half.value *= 0.5;
  EXPECT_EQ(half.outlinedWith({}), whole.outlinedWith({}));
}

TEST(Outline, OfAMapOfYesAndNoIsTheMapsOwn) {
  const Touched touched([](double x, double y) {
    return std::abs(x) < 0.0105 && std::abs(y) < 0.0055 ? 1.0 : 0.0;
  });
  EXPECT_EQ(touched.outlinedWith({}), touched.region);
}

TEST(Outline, HasNoHoleWhereAFaceHasNoArea) {
  Touched touched([](double x, double y) {
    return std::abs(x) < 0.0105 && std::abs(y) < 0.0055 ? 1.0 : 0.0;
  });
  constexpr int kMiddle = 50 * 101 + 50;
  Eigen::Matrix3Xd vertices(3, touched.mesh.vertexCount());
  Eigen::Matrix3Xi faces(3, touched.mesh.faceCount());
  for (int v = 0; v < touched.mesh.vertexCount(); ++v)
    vertices.col(v) = touched.mesh.vertex(v == kMiddle ? kMiddle + 1 : v);
  for (int f = 0; f < touched.mesh.faceCount(); ++f)
    faces.col(f) = touched.mesh.face(f);
  touched.mesh = geometry::TriangleMesh(vertices, faces);
  EXPECT_EQ(touched.outlinedWith({}), touched.region);
}

TEST(Outline, IsNotCutByDentsThatDeepContactLeaves) {
  // Along x, a narrow valley as deep as the outline's level.
  const Touched touched([](double x, double y) {
    const double contact = tent(x, y);
    return std::abs(x) < 0.5 * kStep ? std::min(contact, 0.6) : contact;
  });
  const Region outline = touched.outlinedWith({});
  const auto is_on_the_left = [&](int f) {
    return touched.mesh.vertex(touched.mesh.face(f)[0]).x() < -0.002;
  };
  const auto left = std::count_if(outline.begin(), outline.end(), is_on_the_left);
  EXPECT_GT(left, 0.3 * static_cast<double>(outline.size()));
  EXPECT_LT(left, 0.7 * static_cast<double>(outline.size()));
}

TEST(Outline, IsThatOfThePartWithTheMostContact) {
  // Two tents that run into each other above the threshold, the left one higher.
  const Touched touched([](double x, double y) {
    return std::max(tent(x, y, -0.015), 0.95 * tent(x, y, 0.015));
  });
  const Region outline = touched.outlinedWith({});
  ASSERT_FALSE(outline.empty());
  for (const int f : outline)
    EXPECT_LT(touched.mesh.vertex(touched.mesh.face(f)[0]).x(), 0.0);
}

/// The plate bent round a rim: the side of x > 0 lies under the other one, 3 mm of wall
/// between.
geometry::TriangleMesh rim(const geometry::TriangleMesh& plate) {
  constexpr double kRadius = 0.0015;
  const double turn = 0.5 * 3.14159265358979 * kRadius;  // of the bend, either way from x = 0
  Eigen::Matrix3Xd vertices(3, plate.vertexCount());
  for (int v = 0; v < plate.vertexCount(); ++v) {
    const double s = plate.vertex(v).x();
    const double angle = std::clamp(s, -turn, turn) / kRadius;
    const double flat = std::max(0.0, std::abs(s) - turn);
    vertices.col(v) << kRadius * std::cos(angle) - flat, plate.vertex(v).y(),
        -kRadius * std::sin(angle);
  }
  Eigen::Matrix3Xi faces(3, plate.faceCount());
  for (int f = 0; f < plate.faceCount(); ++f)
    faces.col(f) = plate.face(f);
  return {vertices, faces};
}

TEST(Outline, KeepsToTheSideOfARimThatIsTouchedMore) {
  for (const double more : {-1.0, 1.0}) {
    Touched touched([&](double x, double y) {
      return std::max(0.0, (1.0 - std::hypot(x, y) / 0.030) * (x * more > 0.0 ? 1.0 : 0.97));
    });
    touched.mesh = rim(touched.mesh);
    const Region outline = touched.outlinedWith({});
    ASSERT_GT(areaOf(outline), 0.1 * areaOf(touched.region));
    for (const int f : outline) {
      const Eigen::Vector3i face = touched.mesh.face(f);
      const Eigen::Vector3d a = touched.mesh.vertex(face[0]);
      const Eigen::Vector3d n = (touched.mesh.vertex(face[1]) - a)
                                    .cross(touched.mesh.vertex(face[2]) - a)
                                    .normalized();
      EXPECT_LT(more * n.z(), 0.2) << "looks the other way";
    }
  }
}

TEST(Outline, KeepsWhatASphereTurnsByLess) {
  // Contact within 20 mm on a ball of 40 mm: half a radian, no edge.
  Touched touched([](double x, double y) {
    return std::max(0.0, 1.0 - std::hypot(x, y) / 0.030);
  });
  const Region flat = touched.outlinedWith({});
  Eigen::Matrix3Xd vertices(3, touched.mesh.vertexCount());
  Eigen::Matrix3Xi faces(3, touched.mesh.faceCount());
  for (int v = 0; v < touched.mesh.vertexCount(); ++v) {
    const Eigen::Vector3d p = touched.mesh.vertex(v);
    vertices.col(v) = 0.040 * Eigen::Vector3d(p.x(), p.y(), 0.040).normalized();
  }
  for (int f = 0; f < touched.mesh.faceCount(); ++f)
    faces.col(f) = touched.mesh.face(f);
  touched.mesh = geometry::TriangleMesh(vertices, faces);
  EXPECT_NEAR(areaOf(touched.outlinedWith({})), areaOf(flat), 0.1 * areaOf(flat));
}

TEST(Outline, IsTheRegionsWhereLessThanTheMinimumAreaWouldBeLeft) {
  const Touched touched([](double x, double y) {
    return tent(x, y);
  });
  const double left = areaOf(touched.outlinedWith({0.9}));
  EXPECT_EQ(areaOf(touched.outlinedWith({0.9, 0.99 * left})), left);
  EXPECT_EQ(touched.outlinedWith({0.9, 1.01 * left}), touched.region);
}

}  // namespace
}  // namespace handgraft::contact
