#include "client/present/render/views.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "client/present/render/camera.h"
#include "client/present/render/scene_renderer.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kAzimuths = 8;
constexpr int kScoutSize = 112;  // pixels: a fingertip's patch is about 6 across
constexpr double kLeastTurn = 80.0 * std::numbers::pi / 180.0;

struct Direction {
  int azimuth;  // in steps of 360 / kAzimuths degrees
  Eigen::Vector3d from_W;
  std::vector<double> seen;  // of each decal
  double contact;            // of all together
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
      std::vector<double> seen = renderer.visibleDecals(camera, kScoutSize, kScoutSize);
      const double contact = std::accumulate(seen.begin(), seen.end(), 0.0);
      directions.push_back({a, from_W, std::move(seen), contact});
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
  // Large decals must not crowd out small ones: each counts as a share of what can be seen of
  // it.
  std::vector<double> best_seen(directions.front().seen.size(), 0.0);
  for (const Direction& direction : directions) {
    for (std::size_t d = 0; d < best_seen.size(); ++d)
      best_seen[d] = std::max(best_seen[d], direction.seen[d]);
  }
  const auto share = [&](const Direction& direction, std::size_t d) {
    return best_seen[d] > 0.0 ? direction.seen[d] / best_seen[d] : 0.0;
  };
  std::pair<const Direction*, const Direction*> chosen(nullptr, nullptr);
  double best_score = -1.0;
  for (const Direction& first : directions) {
    for (const Direction& second : directions) {
      if (first.contact < second.contact) continue;
      const double turn = std::acos(std::clamp(first.from_W.dot(second.from_W), -1.0, 1.0));
      if (turn < kLeastTurn) continue;
      double score = 0.0;
      for (std::size_t d = 0; d < best_seen.size(); ++d)
        score += std::max(share(first, d), share(second, d));
      score += 1e-3 * (first.contact + second.contact);  // between equal ones
      if (score <= best_score) continue;
      best_score = score;
      chosen = {&first, &second};
    }
  }
  HANDGRAFT_REQUIRE(chosen.first != nullptr);
  return {{{chosen.first->from_W}, {chosen.second->from_W}}};
}

}  // namespace handgraft::client::render
