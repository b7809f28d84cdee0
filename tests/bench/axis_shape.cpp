#include "tests/bench/axis_shape.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/geometry/log_map.h"

namespace handgraft::bench {
namespace {

using geometry::SurfacePoint;

double angleAt(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return std::atan2((b - a).cross(c - a).norm(), (b - a).dot(c - a));
}

}  // namespace

PatchNet netOf(const geometry::TriangleMesh& object_O, const contact::Patch& patch, int rings) {
  const std::vector<SurfacePoint>& boundary = patch.interpolation_boundary;
  double farthest = 0.0;
  const Eigen::Vector3d p_root = positionOf(object_O, patch.root);
  for (const SurfacePoint& point : boundary)
    farthest = std::max(farthest, (positionOf(object_O, point) - p_root).norm());
  const geometry::LogMap map = computeLogMap(object_O, patch.root, *patch.direction_O,
                                             2.0 * farthest + 4.0 * object_O.meanEdgeLength(),
                                             geometry::LogMapMethod::kExact);
  const geometry::LogMapInverse inverse(object_O, map);

  PatchNet net;
  const int count = static_cast<int>(boundary.size());
  net.places.push_back(patch.root);
  std::vector<std::vector<int>> at(1, std::vector<int>(boundary.size(), 0));
  for (int ring = 1; ring <= rings; ++ring) {
    at.emplace_back(boundary.size(), -1);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d uv = logCoordinates(object_O, map, boundary[i]);
      SurfacePoint place = boundary[i];
      if (ring < rings) place = inverse.at(static_cast<double>(ring) / rings * uv).point;
      if (!place.valid()) continue;
      at[ring][i] = static_cast<int>(net.places.size());
      net.places.push_back(place);
    }
  }
  for (const SurfacePoint& place : net.places)
    net.p_O.push_back(positionOf(object_O, place));
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0 || a == b || b == c || c == a) return;
    net.triangles.emplace_back(a, b, c);
  };
  for (int ring = 1; ring <= rings; ++ring) {
    for (int i = 0; i < count; ++i) {
      const int j = (i + 1) % count;
      add(at[ring - 1][i], at[ring][i], at[ring][j]);
      add(at[ring - 1][i], at[ring][j], at[ring - 1][j]);
    }
  }
  return net;
}

NetChange changeOf(const PatchNet& net,
                   const std::vector<std::optional<Eigen::Vector3d>>& p_S,
                   const std::vector<std::optional<Eigen::Vector3d>>& n_S) {
  NetChange change;
  for (const auto& p : p_S)
    change.lost += p ? 0 : 1;
  std::vector<double> lengths;
  double angles = 0.0;
  double area_O = 0.0;
  double area_S = 0.0;
  int turned = 0;
  int counted = 0;
  for (const Eigen::Vector3i& t : net.triangles) {
    if (!p_S[t[0]] || !p_S[t[1]] || !p_S[t[2]]) continue;
    ++counted;
    for (int c = 0; c < 3; ++c) {
      const int a = t[c];
      const int b = t[(c + 1) % 3];
      const int d = t[(c + 2) % 3];
      lengths.push_back(
          std::abs((*p_S[b] - *p_S[a]).norm() / (net.p_O[b] - net.p_O[a]).norm() - 1.0));
      angles += std::abs(angleAt(*p_S[a], *p_S[b], *p_S[d]) -
                         angleAt(net.p_O[a], net.p_O[b], net.p_O[d]));
    }
    const Eigen::Vector3d twice_S = (*p_S[t[1]] - *p_S[t[0]]).cross(*p_S[t[2]] - *p_S[t[0]]);
    area_S += twice_S.norm();
    area_O += (net.p_O[t[1]] - net.p_O[t[0]]).cross(net.p_O[t[2]] - net.p_O[t[0]]).norm();
    // Mirrored, what is counter-clockwise on the object is clockwise on the skin.
    if (twice_S.dot(*n_S[t[0]]) > 0.0) ++turned;
  }
  if (counted == 0) return change;
  for (const double length : lengths)
    change.length_mean += length / static_cast<double>(lengths.size());
  std::sort(lengths.begin(), lengths.end());
  change.length_worst = lengths[lengths.size() * 95 / 100];
  change.angle_mean = angles / (3.0 * counted);
  change.area_ratio = area_S / area_O;
  change.turned_over = static_cast<double>(turned) / counted;

  // === Face to face: normals opposed, the mirrored figure fits by a rigid motion
  std::vector<int> kept;
  for (std::size_t i = 0; i < p_S.size(); ++i) {
    if (p_S[i]) kept.push_back(static_cast<int>(i));
  }
  Eigen::Matrix3Xd object(3, static_cast<int>(kept.size()));
  Eigen::Matrix3Xd skin(3, static_cast<int>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    object.col(static_cast<int>(i)) = net.p_O[kept[i]];
    skin.col(static_cast<int>(i)) = *p_S[kept[i]];
  }
  const Eigen::Affine3d X(Eigen::umeyama(object, skin, false));
  change.fit_rms =
      std::sqrt((X * object - skin).squaredNorm() / static_cast<double>(kept.size()));
  return change;
}

}  // namespace handgraft::bench
