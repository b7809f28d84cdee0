#include "tests/bench/round_trip.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "tests/bench/measured_surface.h"
#include "tests/support/plate_hand.h"

namespace handgraft::bench {

namespace {

using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kMillimetres = 1e3;

/// A lopsided loop about `root`: no symmetry hides a wrong turn.
contact::Patch makePatch(const TriangleMesh& mesh, const SurfacePoint& root, double radius_m) {
  contact::Patch patch;
  patch.name = "patch";
  patch.root = root;
  patch.direction_O = normalOf(mesh, root).unitOrthogonal();
  const geometry::LogMap map =
      computeLogMap(mesh, root, *patch.direction_O, 1.2 * radius_m, LogMapMethod::kExact);
  const geometry::LogMapInverse inverse(mesh, map);
  for (int i = 0; i < contact::kDefaultInterpolationCount; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / contact::kDefaultInterpolationCount;
    const double r = radius_m * (0.7 + 0.3 * std::cos(angle) * std::sin(angle + 0.4));
    const auto place = inverse.at(r * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (place.point.valid()) patch.interpolation_boundary.push_back(place.point);
  }
  return patch;
}

}  // namespace

void goRoundTrip(const TriangleMesh& object_O,
                 const contact::Patch& patch,
                 const hand::Skin& skin,
                 const transfer::PatchPlacement& placement,
                 LogMapMethod method,
                 RoundTrip& result) {
  transfer::TransferOptions options;
  options.method = method;
  const transfer::PatchTransfer there =
      transferPatch(object_O, patch, skin, placement, options);
  result.lost += static_cast<int>(there.lost.size());
  if (std::ssize(there.places_S) < contact::kFewestInterpolationPoints) return;

  contact::Patch landed;
  landed.name = patch.name;
  landed.root = placement.root_S;
  landed.direction_O = placement.direction_S;
  landed.interpolation_boundary = there.places_S;
  const auto object = test::makeRigidHand(object_O);
  const transfer::PatchTransfer back =
      transferPatch(skin.mesh(), landed, test::makeRigidSkin(*object, object_O),
                    {patch.root, *patch.direction_O}, options);
  result.lost += static_cast<int>(back.lost.size());

  // What is left of the points, in their order on both ways.
  const auto kept = [](std::size_t count, const std::vector<transfer::LostPoint>& lost) {
    std::vector<int> indices;
    for (int i = 0; i < static_cast<int>(count); ++i) {
      if (std::none_of(lost.begin(), lost.end(), [&](const transfer::LostPoint& point) {
            return point.index == i;
          }))
        indices.push_back(i);
    }
    return indices;
  };
  const std::vector<int> first = kept(patch.interpolation_boundary.size(), there.lost);
  const std::vector<int> second = kept(there.places_S.size(), back.lost);
  double sum = result.mean_mm * result.points;
  for (std::size_t i = 0; i < second.size(); ++i) {
    const int start = first[static_cast<std::size_t>(second[i])];
    const Eigen::Vector3d p_O =
        positionOf(object_O, patch.interpolation_boundary[static_cast<std::size_t>(start)]);
    const double error = kMillimetres * (back.points_S[i] - p_O).norm();
    sum += error;
    result.max_mm = std::max(result.max_mm, error);
    ++result.points;
  }
  if (result.points > 0) result.mean_mm = sum / result.points;
}

std::vector<RoundTrip> smoothRoundTrips(int vertex_count) {
  struct Named {
    std::string name;
    TriangleMesh mesh;
  };

  std::vector<Named> surfaces;
  for (const MeasuredSurface& surface : measuredSurfaces(vertex_count)) {
    if (surface.version != mesh_versions.front()) continue;
    if (surface.surface == "sphere") {
      surfaces.push_back(
          {"sphere", transformed(surface.mesh, Eigen::Affine3d(Eigen::Scaling(0.035)))});
      surfaces.push_back(
          {"ellipsoid", transformed(surface.mesh, Eigen::Affine3d(Eigen::Scaling(
                                                      Eigen::Vector3d(0.03, 0.04, 0.07))))});
    }
    if (surface.surface == "cylinder") {
      surfaces.push_back(
          {"prism", transformed(surface.mesh, Eigen::Affine3d(Eigen::Scaling(0.03)))});
    }
  }
  std::vector<RoundTrip> trips;
  for (const Named& from : surfaces) {
    for (const Named& to : surfaces) {
      if (from.name == to.name) continue;
      const auto hand = test::makeRigidHand(to.mesh);
      const hand::Skin skin = test::makeRigidSkin(*hand, to.mesh);
      for (const LogMapMethod method : {LogMapMethod::kFast, LogMapMethod::kExact}) {
        RoundTrip trip;
        trip.from = from.name;
        trip.to = to.name;
        trip.method = geometry::nameOf(method);
        std::mt19937 random(5);
        const auto middle = [&](const TriangleMesh& mesh) {
          // Not at the prism's open ends, which are no part of a smooth surface.
          const auto faces = static_cast<unsigned>(mesh.faceCount());
          return SurfacePoint{static_cast<int>(faces / 3 + random() % (faces / 3)),
                              {0.2, 0.5, 0.3}};
        };
        for (const double radius_m : {0.005, 0.010, 0.020}) {
          for (int i = 0; i < 3; ++i) {
            const contact::Patch patch = makePatch(from.mesh, middle(from.mesh), radius_m);
            const SurfacePoint root_S = middle(to.mesh);
            goRoundTrip(from.mesh, patch, skin,
                        {root_S, normalOf(to.mesh, root_S).unitOrthogonal()}, method, trip);
          }
        }
        trips.push_back(trip);
      }
    }
  }
  return trips;
}

}  // namespace handgraft::bench
