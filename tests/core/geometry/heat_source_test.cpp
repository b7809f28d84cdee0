#include "core/geometry/heat_source.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

#include "tests/core/geometry/sheet.h"

namespace handgraft::geometry {
namespace {

using Complex = std::complex<double>;

const Eigen::Vector3d heat_direction(0.3, 0.8, 0.1);

/// sum(weight * p_T^k), in edges.
Complex momentOf(const std::vector<HeatSeed>& seeds, int k, double edge) {
  Complex sum = 0.0;
  for (const HeatSeed& seed : seeds)
    sum += seed.weight * std::pow(seed.p_T / edge, k);
  return sum;
}

std::vector<HeatSeed> roundSeedsOf(const TriangleMesh& mesh, const SurfacePoint& source) {
  const IntrinsicDelaunay surface(mesh);
  const Eigen::Vector3d direction = normalOf(mesh, source).unitOrthogonal();
  return roundSeeds(mesh, surface, source, layOutSource(mesh, source, direction),
                    mesh.meanEdgeLength());
}

void expectShares(const std::vector<HeatSeed>& seeds) {
  double sum = 0.0;
  for (const HeatSeed& seed : seeds) {
    EXPECT_GT(seed.weight, 0.0);
    EXPECT_NEAR(std::abs(seed.axis), 1.0, 1e-12);
    sum += seed.weight;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(HeatSource, IsRoundInsideAFaceAndOnAnEdge) {
  const TriangleMesh sphere = makeSphere(1.0, 4);
  const IntrinsicDelaunay surface(sphere);
  const double edge = sphere.meanEdgeLength();
  std::mt19937 random(3);
  double corner_moment = 0.0;
  for (int i = 0; i < 40; ++i) {
    SurfacePoint source{static_cast<int>(random() % 5120), {0.2, 0.5, 0.3}};
    if (i % 2 == 1) source.barycentric = {0.0, 0.4, 0.6};
    const SourceLayout layout = layOutSource(sphere, source, heat_direction);
    const std::vector<HeatSeed> seeds = roundSeeds(sphere, surface, source, layout, edge);
    expectShares(seeds);
    for (int k = 1; k <= 3; ++k)
      EXPECT_LT(std::abs(momentOf(seeds, k, edge)), 0.05) << i << ", moment " << k;
    const std::vector<HeatSeed> corners = cornerSeeds(sphere, surface, source, layout);
    expectShares(corners);
    EXPECT_LT(std::abs(momentOf(corners, 1, edge)), 1e-12);
    corner_moment = std::max(corner_moment, std::abs(momentOf(corners, 2, edge)));
  }
  // What there is to gain: the ends of an edge are as far from round as can be.
  EXPECT_GT(corner_moment, 0.2);
}

TEST(HeatSource, StandsOnAPlaneAsThePlaneDoes) {
  const test::Sheet sheet = test::makePlane();
  const TriangleMesh& mesh = sheet.mesh;
  const IntrinsicDelaunay surface(mesh);
  const Complex x = std::polar(1.0, std::atan2(heat_direction.y(), heat_direction.x()));
  for (int f = 0; f < mesh.faceCount(); f += 7) {
    for (const Eigen::Vector3d& weights :
         {Eigen::Vector3d(0.2, 0.5, 0.3), Eigen::Vector3d(0.4, 0.0, 0.6)}) {
      const SurfacePoint source{f, weights};
      const Eigen::Vector3d origin = positionOf(mesh, source);
      const std::vector<HeatSeed> seeds =
          roundSeeds(mesh, surface, source, layOutSource(mesh, source, heat_direction),
                     mesh.meanEdgeLength());
      expectShares(seeds);
      for (const HeatSeed& seed : seeds) {
        const Eigen::Vector3d p = mesh.vertex(seed.vertex) - origin;
        ASSERT_LT(std::abs(seed.p_T * x - Complex(p.x(), p.y())), 1e-14);
        // An edge is seen along the same line from T and from the vertex.
        const int h = *mesh.outgoingBegin(seed.vertex);
        const Eigen::Vector3d e = mesh.vertex(mesh.to(h)) - mesh.vertex(seed.vertex);
        const Complex edge_T = Complex(e.x(), e.y()) / (e.norm() * x);
        ASSERT_LT(std::abs(surface.meshDirection(seed.vertex, h, 0.0) - seed.axis * edge_T),
                  1e-12);
      }
    }
  }
}

TEST(HeatSource, IsOneShareAtAVertexAndNearlySoBesideIt) {
  const TriangleMesh sphere = makeSphere(1.0, 3);
  const SurfacePoint vertex = surfacePointAtVertex(sphere, 77);
  const std::vector<HeatSeed> seeds = roundSeedsOf(sphere, vertex);
  ASSERT_EQ(seeds.size(), 1U);
  EXPECT_EQ(seeds[0].vertex, 77);
  EXPECT_EQ(seeds[0].weight, 1.0);
  EXPECT_EQ(seeds[0].p_T, Complex(0.0));

  constexpr double kBeside = 1e-5;
  SurfacePoint beside = vertex;
  beside.barycentric =
      (1.0 - kBeside) * vertex.barycentric + kBeside * Eigen::Vector3d::Constant(1.0 / 3.0);
  double share = 0.0;
  for (const HeatSeed& seed : roundSeedsOf(sphere, beside)) {
    if (seed.vertex == 77) share = seed.weight;
  }
  EXPECT_NEAR(share, 1.0, 10.0 * kBeside);
}

TEST(HeatSource, IsTheSameThroughEitherFaceOfAnEdge) {
  const TriangleMesh sphere = makeSphere(1.0, 3);
  for (int h = 0; h < 3 * sphere.faceCount(); h += 37) {
    const auto through = [&](int side, double from_weight) {
      SurfacePoint source{TriangleMesh::faceOf(side), Eigen::Vector3d::Zero()};
      source.barycentric[side % 3] = from_weight;
      source.barycentric[TriangleMesh::next(side) % 3] = 1.0 - from_weight;
      std::vector<HeatSeed> seeds = roundSeedsOf(sphere, source);
      std::sort(seeds.begin(), seeds.end(), [](const HeatSeed& a, const HeatSeed& b) {
        return a.vertex < b.vertex;
      });
      return seeds;
    };
    const std::vector<HeatSeed> one = through(h, 0.3);
    const std::vector<HeatSeed> other = through(sphere.twin(h), 0.7);
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].vertex, other[i].vertex);
      EXPECT_NEAR(one[i].weight, other[i].weight, 1e-12);
    }
  }
}

TEST(HeatSource, KeepsToItsFaceWhereNothingLiesAround) {
  Eigen::Matrix3Xd corners(3, 3);
  corners << 0, 1, 0, 0, 0, 1, 0, 0, 0;
  const TriangleMesh triangle(corners, Eigen::Vector3i(0, 1, 2));
  for (const Eigen::Vector3d& weights :
       {Eigen::Vector3d(0.2, 0.5, 0.3), Eigen::Vector3d(0.0, 0.4, 0.6)}) {
    const std::vector<HeatSeed> seeds = roundSeedsOf(triangle, {0, weights});
    expectShares(seeds);
    EXPECT_LE(seeds.size(), 3U);
  }
}

}  // namespace
}  // namespace handgraft::geometry
