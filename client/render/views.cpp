#include "client/render/views.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "client/render/camera.h"
#include "client/render/scene_renderer.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kAzimuths = 8;
constexpr int kScoutSize = 112;  // pixels: a fingertip's patch is about 6 across
constexpr double kLeastTurn = 80.0 * std::numbers::pi / 180.0;

struct Direction {
  int azimuth;  // in steps of 360 / kAzimuths degrees
  Eigen::Vector3d from_W;
  double contact;
};

std::vector<Direction> scout(const Scene& scene, const std::vector<double>& elevations_rad) {
  const SceneRenderer renderer(scene);
  const std::vector<Eigen::Vector3f> points = scene.points();
  std::vector<Direction> directions;
  for (const double elevation : elevations_rad) {
    for (int a = 0; a < kAzimuths; ++a) {
      const double azimuth = 2.0 * std::numbers::pi * (a + 0.25) / kAzimuths;  // seldom edge-on
      const Eigen::Vector3d from_W(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth),
                                   std::sin(elevation));
      const Camera camera = Camera::fitting(points, from_W, Eigen::Vector3d::UnitZ(),
                                            kScoutSize, kScoutSize, Projection::kPerspective);
      directions.push_back(
          {a, from_W, renderer.visibleContact(camera, kScoutSize, kScoutSize)});
    }
  }
  return directions;
}

const Direction& best(const std::vector<Direction>& directions,
                      const std::function<bool(const Direction&)>& counts) {
  const Direction* found = nullptr;
  for (const Direction& direction : directions) {
    if (!counts(direction)) continue;
    if (found == nullptr || direction.contact > found->contact) found = &direction;
  }
  HANDGRAFT_REQUIRE(found != nullptr);
  return *found;
}

}  // namespace

std::array<View, 2> viewsAroundUp(const Scene& scene) {
  const std::vector<Direction> directions = scout(scene, {0.18, 0.65});  // level, from above
  const Direction& first = best(directions, [](const Direction& /*any*/) {
    return true;
  });
  const Direction& second = best(directions, [&](const Direction& direction) {
    const int turn = std::abs(direction.azimuth - first.azimuth);
    const int steps = std::min(turn, kAzimuths - turn);
    return steps >= kAzimuths / 4 && steps <= 3 * kAzimuths / 8;
  });
  return {{{first.from_W}, {second.from_W}}};
}

std::array<View, 2> viewsAllAround(const Scene& scene) {
  const std::vector<Direction> directions = scout(scene, {-1.0, -0.45, 0.18, 0.65, 1.2});
  const Direction& first = best(directions, [](const Direction& /*any*/) {
    return true;
  });
  const Direction& second = best(directions, [&](const Direction& direction) {
    return std::acos(std::clamp(direction.from_W.dot(first.from_W), -1.0, 1.0)) >= kLeastTurn;
  });
  return {{{first.from_W}, {second.from_W}}};
}

}  // namespace handgraft::client::render
