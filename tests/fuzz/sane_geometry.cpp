#include "tests/fuzz/sane_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/surface_locator.h"

namespace handgraft::fuzz {

namespace {

using geometry::LogMap;
using geometry::LogMapInverse;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSources = 3;
constexpr int kQueries = 12;
// The heat methods factor the whole mesh: one in this many questions goes to them.
constexpr unsigned kHeatOneIn = 8;

LogMapMethod asked_method = LogMapMethod::kFast;

void require(bool promise, const char* what) {
  if (promise) return;
  std::fprintf(stderr, "broken promise: %s (log map last asked for: %s)\n", what,
               std::string(nameOf(asked_method)).c_str());
  std::abort();
}

#define HANDGRAFT_PROMISE(condition) require(condition, #condition)

bool isWithin(const TriangleMesh& mesh, int vertex) {
  return vertex >= 0 && vertex < mesh.vertexCount();
}

void requireOnSurface(const TriangleMesh& mesh, const SurfacePoint& point) {
  HANDGRAFT_PROMISE(point.face >= 0 && point.face < mesh.faceCount());
  HANDGRAFT_PROMISE((point.barycentric.array() >= 0.0).all());  // NaN fails, too
  HANDGRAFT_PROMISE((point.barycentric.array() <= 1.0).all());
  HANDGRAFT_PROMISE(std::abs(point.barycentric.sum() - 1.0) <= 1e-9);
}

void requireSaneDisk(const TriangleMesh& mesh, const LogMap& map, double radius) {
  std::vector<char> reached(static_cast<std::size_t>(mesh.vertexCount()), 0);
  double last = 0.0;
  for (const int v : map.vertices) {
    HANDGRAFT_PROMISE(isWithin(mesh, v));
    HANDGRAFT_PROMISE(!reached[static_cast<std::size_t>(v)]);
    reached[static_cast<std::size_t>(v)] = 1;
    HANDGRAFT_PROMISE(map.r[v] >= last);  // by increasing r, from zero; NaN fails, too
    HANDGRAFT_PROMISE(map.r[v] <= radius && map.r[v] < kInfinity);
    HANDGRAFT_PROMISE(map.phi[v] > -std::numbers::pi && map.phi[v] <= std::numbers::pi);
    last = map.r[v];
  }
  for (const LogMap::RimVertex& rim : map.rim) {
    HANDGRAFT_PROMISE(isWithin(mesh, rim.vertex) && !reached[rim.vertex]);
    HANDGRAFT_PROMISE(rim.p_T.allFinite());
  }
  for (const std::vector<int>* faces : {&map.faces, &map.rim_faces}) {
    HANDGRAFT_PROMISE(std::is_sorted(faces->begin(), faces->end()));
    for (const int f : *faces) {
      HANDGRAFT_PROMISE(f >= 0 && f < mesh.faceCount());
      for (const int v : mesh.face(f))
        HANDGRAFT_PROMISE(geometry::logCoordinatesAtVertex(map, v).allFinite());
    }
  }
}

/// What the inverse answers stands where it was asked for.
void requireSaneInverse(const TriangleMesh& mesh, const LogMap& map, std::mt19937_64& random) {
  const LogMapInverse inverse(mesh, map);
  double extent = map.vertices.empty() ? 0.0 : map.r[map.vertices.back()];
  for (const LogMap::RimVertex& rim : map.rim)
    extent = std::max(extent, rim.p_T.norm());
  std::uniform_real_distribution<double> part(-1.1, 1.1);
  for (int i = 0; i < kQueries; ++i) {
    const Eigen::Vector2d uv_T = extent * Eigen::Vector2d(part(random), part(random));
    const LogMapInverse::Place place = inverse.at(uv_T);
    if (!place.point.valid()) {
      HANDGRAFT_PROMISE(!geometry::reasonOf(place.reason).empty());
      continue;
    }
    requireOnSurface(mesh, place.point);
    const Eigen::Vector2d back_T = geometry::logCoordinates(mesh, map, place.point);
    HANDGRAFT_PROMISE((back_T - uv_T).norm() <= 1e-6 * extent);
  }
  for (const double odd : {std::numeric_limits<double>::quiet_NaN(), kInfinity,
                           std::numeric_limits<double>::max()}) {
    const LogMapInverse::Place place = inverse.at({odd, 0.0});
    if (place.point.valid()) requireOnSurface(mesh, place.point);
  }
}

SurfacePoint anyPlace(const TriangleMesh& mesh, std::mt19937_64& random) {
  const auto face = static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount()));
  const int corner = static_cast<int>(random() % 3);
  SurfacePoint place{face, {0.2, 0.5, 0.3}};
  switch (random() % 4) {
    case 0:
      place.barycentric = Eigen::Vector3d::Unit(corner);
      break;
    case 1:
      place.barycentric.setConstant(0.5);
      place.barycentric[corner] = 0.0;
      break;
    case 2:  // as good as on an edge
      place.barycentric = {1e-13, 0.25, 0.75 - 1e-13};
      break;
    default:
      break;
  }
  return place;
}

LogMapMethod anyMethod(std::mt19937_64& random) {
  if (random() % kHeatOneIn == 0) {
    return random() % 2 == 0 ? LogMapMethod::kSmooth : LogMapMethod::kHeat;
  }
  constexpr LogMapMethod kMethods[] = {LogMapMethod::kFast, LogMapMethod::kExact,
                                       LogMapMethod::kAuto};
  return kMethods[random() % 3];
}

void exerciseLogMap(const TriangleMesh& mesh, std::mt19937_64& random) {
  const SurfacePoint source = anyPlace(mesh, random);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  const Eigen::Vector3d direction(part(random), part(random), part(random));
  // The diagonal of a mesh of 1e300 m overflows; such a radius is no finite one.
  double radius = mesh.diagonal() * std::ldexp(1.0, -static_cast<int>(random() % 8));
  if (random() % 3 == 0 || !(radius > 0.0)) radius = kInfinity;
  asked_method = anyMethod(random);
  try {
    const LogMap map = geometry::computeLogMap(mesh, source, direction, radius, asked_method);
    requireSaneDisk(mesh, map, radius);
    requireSaneInverse(mesh, map, random);
  } catch (const InvalidInput&) {
    // Sources without a normal, directions along it, components that heat refuses.
  }
}

void exerciseLocator(const TriangleMesh& mesh, std::mt19937_64& random) {
  const geometry::SurfaceLocator locator(mesh);
  std::uniform_real_distribution<double> part(-1.5, 1.5);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d near = mesh.vertex(
        mesh.face(static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount())))[0]);
    const Eigen::Vector3d p =
        near +
        mesh.meanEdgeLength() * Eigen::Vector3d(part(random), part(random), part(random));
    if (!p.allFinite()) continue;
    const geometry::SurfaceLocator::Hit hit = locator.nearest(p);
    requireOnSurface(mesh, hit.point);
    HANDGRAFT_PROMISE(hit.position.allFinite());
    HANDGRAFT_PROMISE(hit.distance <= (p - near).norm() * (1.0 + 1e-9));
  }
}

}  // namespace

void exerciseGeometry(const TriangleMesh& mesh, std::uint64_t choice) {
  if (mesh.faceCount() == 0) return;
  std::mt19937_64 random(choice);
  for (int i = 0; i < kSources; ++i)
    exerciseLogMap(mesh, random);
  exerciseLocator(mesh, random);
}

}  // namespace handgraft::fuzz
