#include "core/hand/wrap_queries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace handgraft::hand {

namespace {

/// Determinants of points of size 1 are noise below this; rounding leaves some 1e-15.
constexpr double kNoise = 1e-12;
/// As CGAL's own search has it.
constexpr double kPrecision = 1e-2;

double largest(const Eigen::Vector3d& v) {
  return v.cwiseAbs().maxCoeff();
}

/// A tetrahedron and the planes of its four sides.
struct Sides {
  explicit Sides(const std::array<Eigen::Vector3d, 4>& t) : corners(t) {
    constexpr std::size_t kSides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (std::size_t i = 0; i < 4; ++i) {
      size = std::max(size, largest(t[i]));
      for (std::size_t k = 0; k < i; ++k)
        longest = std::max(longest, largest(t[i] - t[k]));
      const Eigen::Vector3d& a = t[kSides[i][0]];
      normals[i] = (t[kSides[i][1]] - a).cross(t[kSides[i][2]] - a);
      if (normals[i].dot(t[i] - a) > 0.0) normals[i] = -normals[i];
      bases[i] = a;
    }
  }

  /// 1 where `p` is surely on the outer side of a plane, -1 on the inner one, else 0.
  [[nodiscard]] int sideOf(std::size_t plane, const Eigen::Vector3d& p) const {
    const Eigen::Vector3d to = p - bases[plane];
    const double outside = normals[plane].dot(to);
    const double noise =
        kNoise * std::max(size, largest(p)) * longest * std::max(longest, largest(to));
    return outside > noise ? 1 : outside < -noise ? -1 : 0;
  }

  [[nodiscard]] bool surelyHold(const Eigen::Vector3d& p) const {
    for (std::size_t i = 0; i < 4; ++i)
      if (sideOf(i, p) >= 0) return false;
    return true;
  }

  /// The middle of what the four planes leave of the way from `a` to `b`, if anything.
  [[nodiscard]] std::optional<Eigen::Vector3d> middleWithin(const Eigen::Vector3d& a,
                                                            const Eigen::Vector3d& b) const {
    double from = 0.0;
    double to = 1.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double at_a = normals[i].dot(a - bases[i]);
      const double at_b = normals[i].dot(b - bases[i]);
      if (at_a > 0.0 && at_b > 0.0) return std::nullopt;
      if (at_a > 0.0) from = std::max(from, at_a / (at_a - at_b));
      if (at_b > 0.0) to = std::min(to, at_a / (at_a - at_b));
    }
    if (!(from < to)) return std::nullopt;
    return a + 0.5 * (from + to) * (b - a);
  }

  const std::array<Eigen::Vector3d, 4>& corners;
  std::array<Eigen::Vector3d, 4> normals;
  std::array<Eigen::Vector3d, 4> bases;
  double size = 0.0;
  double longest = 0.0;
};

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Whether an edge of the tetrahedron surely pierces the triangle, whose plane has its corners
/// at heights `above`.
bool surelyPierced(const Triangle& triangle,
                   const Eigen::Vector3d& normal,
                   const std::array<Eigen::Vector3d, 4>& corners,
                   const std::array<double, 4>& above,
                   double noise) {
  // Weights in a sliver are noise.
  constexpr double kMargin = 1e-6;
  const Eigen::Vector3d ab = triangle[1] - triangle[0];
  const Eigen::Vector3d ac = triangle[2] - triangle[0];
  const double normal_squared = normal.squaredNorm();
  if (!(normal_squared > 1e-6 * ab.squaredNorm() * ac.squaredNorm())) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const bool crosses =
          (above[i] > noise && above[k] < -noise) || (above[i] < -noise && above[k] > noise);
      if (!crosses) continue;
      const double share = above[i] / (above[i] - above[k]);
      const Eigen::Vector3d to = corners[i] + share * (corners[k] - corners[i]) - triangle[0];
      const double weight_b = normal.dot(to.cross(ac)) / normal_squared;
      const double weight_c = normal.dot(ab.cross(to)) / normal_squared;
      if (weight_b > kMargin && weight_c > kMargin && weight_b + weight_c < 1.0 - kMargin)
        return true;
    }
  }
  return false;
}

Touch touchOf(const Sides& sides, const Triangle& triangle) {
  // === A plane between the two
  for (std::size_t i = 0; i < 4; ++i)
    if (sides.sideOf(i, triangle[0]) > 0 && sides.sideOf(i, triangle[1]) > 0 &&
        sides.sideOf(i, triangle[2]) > 0)
      return Touch::kNo;
  const Eigen::Vector3d ab = triangle[1] - triangle[0];
  const Eigen::Vector3d ac = triangle[2] - triangle[0];
  const Eigen::Vector3d normal = ab.cross(ac);
  const double longest = std::max(largest(ab), largest(ac));
  std::array<double, 4> above{};
  double farthest = longest;
  double size = std::max(sides.size, largest(triangle[0]));
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d to = sides.corners[i] - triangle[0];
    above[i] = normal.dot(to);
    farthest = std::max(farthest, largest(to));
  }
  const double noise = kNoise * size * longest * farthest;
  const double noise_of_edges =
      kNoise * size * std::max(longest, sides.longest) * std::max(farthest, sides.longest);
  if (std::all_of(above.begin(), above.end(),
                  [&](double a) {
                    return a > noise;
                  }) ||
      std::all_of(above.begin(), above.end(), [&](double a) {
        return a < -noise;
      }))
    return Touch::kNo;
  // What lies side by side may be parted by a plane along an edge of each alone.
  constexpr std::size_t kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  for (const auto& edge : kEdges) {
    const Eigen::Vector3d along = sides.corners[edge[1]] - sides.corners[edge[0]];
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::Vector3d axis = along.cross(triangle[(c + 1) % 3] - triangle[c]);
      // Corner c and the next one are at 0.
      const double third = axis.dot(triangle[(c + 2) % 3] - triangle[c]);
      const double low = std::min(0.0, third);
      const double high = std::max(0.0, third);
      double lowest = std::numeric_limits<double>::infinity();
      double highest = -lowest;
      for (const Eigen::Vector3d& corner : sides.corners) {
        const double at = axis.dot(corner - triangle[c]);
        lowest = std::min(lowest, at);
        highest = std::max(highest, at);
      }
      if (lowest > high + noise_of_edges || highest < low - noise_of_edges) return Touch::kNo;
    }
  }
  // === A place of both
  for (std::size_t c = 0; c < 3; ++c) {
    const auto middle = sides.middleWithin(triangle[c], triangle[(c + 1) % 3]);
    if (middle && sides.surelyHold(*middle)) return Touch::kYes;
  }
  if (surelyPierced(triangle, normal, sides.corners, above, noise)) return Touch::kYes;
  return Touch::kTooCloseToTell;
}

}  // namespace

Touch touchOf(const std::array<Eigen::Vector3d, 4>& tetrahedron,
              const std::array<Eigen::Vector3d, 3>& triangle) {
  return touchOf(Sides(tetrahedron), triangle);
}

const geometry::SurfaceLocator::Hit& WrapQueries::nearest(const Eigen::Vector3d& p) const {
  if (last_ && p == last_p_) return *last_;
  std::optional<geometry::SurfaceLocator::Hit> hit;
  // The place found last is no farther than it is; a little more, since that was rounded.
  if (last_) hit = locator_.nearest(p, (p - last_->position).norm() * (1.0 + 1e-9) + 1e-12);
  last_ = hit ? *hit : locator_.nearest(p);
  last_p_ = p;
  return *last_;
}

std::optional<Eigen::Vector3d> WrapQueries::firstWithin(double offset_m,
                                                        const Eigen::Vector3d& p,
                                                        const Eigen::Vector3d& q) const {
  const double length = (q - p).norm();
  const double precision = kPrecision * offset_m;
  // No triangle is nearer than the distance, so that far one may go.
  for (double along = 0.0;;) {
    const Eigen::Vector3d at =
        along < length ? Eigen::Vector3d(p + (along / length) * (q - p)) : q;
    const double left = nearest(at).distance - offset_m;
    if (left < precision) return at;
    if (along >= length) return std::nullopt;
    along += left;
  }
}

Touch WrapQueries::touches(const std::array<Eigen::Vector3d, 4>& tetrahedron,
                           std::vector<int>& unclear) const {
  unclear.clear();
  const Sides sides(tetrahedron);
  Eigen::AlignedBox3d box(tetrahedron[0]);
  for (std::size_t i = 1; i < 4; ++i)
    box.extend(tetrahedron[i]);
  // === What the place found last tells
  if (last_) {
    if (sides.surelyHold(last_->position)) return Touch::kYes;
    const bool is_in_free_ball =
        std::all_of(tetrahedron.begin(), tetrahedron.end(), [&](const Eigen::Vector3d& corner) {
          return (corner - last_p_).norm() < last_->distance * (1.0 - 1e-9);
        });
    if (is_in_free_ball) return Touch::kNo;
  }
  // === All triangles near
  locator_.facesTouching(box, near_);
  for (const int f : near_) {
    const Eigen::Vector3i face = triangles().face(f);
    const Touch touch =
        touchOf(sides, {triangles().vertex(face[0]), triangles().vertex(face[1]),
                        triangles().vertex(face[2])});
    if (touch == Touch::kYes) return Touch::kYes;
    if (touch == Touch::kTooCloseToTell) unclear.push_back(f);
  }
  return unclear.empty() ? Touch::kNo : Touch::kTooCloseToTell;
}

}  // namespace handgraft::hand
