#include "core/io/file_mesh.h"

#include <charconv>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string>

#include <Eigen/Geometry>

namespace handgraft::io {

namespace {

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The corners seen along their mean normal (Newell's), counter-clockwise.
Eigen::Matrix2Xd flattened(const Eigen::Matrix3Xd& corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Index n = corners.cols();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d a = corners.col(i) - corners.col(0);
    const Eigen::Vector3d b = corners.col((i + 1) % n) - corners.col(0);
    normal += a.cross(b);
  }
  int drop = 2;
  normal.cwiseAbs().maxCoeff(&drop);
  Eigen::Matrix2Xd flat(2, n);
  flat.row(0) = corners.row((drop + 1) % 3);
  flat.row(1) = corners.row((drop + 2) % 3);
  if (normal[drop] < 0.0) flat.row(0) = -flat.row(0);
  return flat;
}

std::vector<std::array<int, 3>> fan(int n) {
  std::vector<std::array<int, 3>> triangles;
  for (int c = 2; c < n; ++c)
    triangles.push_back({0, c - 1, c});
  return triangles;
}

}  // namespace

std::vector<std::array<int, 3>> cutPolygon(const Eigen::Matrix3Xd& corners) {
  const int n = static_cast<int>(corners.cols());
  // Beyond this, clipping costs seconds; such polygons are caps of round parts: a fan serves.
  constexpr int kMostClipped = 1024;
  if (n == 3 || n > kMostClipped) return fan(n);
  const Eigen::Matrix2Xd flat = flattened(corners);
  std::vector<int> rest(static_cast<std::size_t>(n));
  std::iota(rest.begin(), rest.end(), 0);
  std::vector<std::array<int, 3>> triangles;

  // Polygons that cross themselves may have no ear for long; 16 looks at every pair of corners
  // are plenty for others.
  long looks_left = 16L * n * n;
  const auto is_ear = [&](const std::array<int, 3>& t) {
    looks_left -= std::ssize(rest);
    if (!(turn(flat.col(t[0]), flat.col(t[1]), flat.col(t[2])) > 0.0)) return false;
    for (const int other : rest) {
      if (other == t[0] || other == t[1] || other == t[2]) continue;
      if (turn(flat.col(t[0]), flat.col(t[1]), flat.col(other)) >= 0.0 &&
          turn(flat.col(t[1]), flat.col(t[2]), flat.col(other)) >= 0.0 &&
          turn(flat.col(t[2]), flat.col(t[0]), flat.col(other)) >= 0.0) {
        return false;
      }
    }
    return true;
  };
  std::size_t at = 1;  // where the last ear was: around it, the next one is likely
  while (rest.size() > 3) {
    const std::size_t count = rest.size();
    // Where there is no ear left, any corner goes.
    at %= count;
    for (std::size_t k = 0; looks_left > 0 && k < count; ++k) {
      const std::size_t i = (at + k) % count;
      if (is_ear({rest[(i + count - 1) % count], rest[i], rest[(i + 1) % count]})) {
        at = i;
        break;
      }
    }
    triangles.push_back({rest[(at + count - 1) % count], rest[at], rest[(at + 1) % count]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(at));
  }
  triangles.push_back({rest[0], rest[1], rest[2]});
  return triangles;
}

double numberFrom(std::string_view word, bool& is_number) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  is_number = !word.empty() && stop == word.data() + word.size() &&
              error != std::errc::invalid_argument;
  // Too small or too large for a double: zero or infinity, which the caller judges.
  if (is_number && error == std::errc::result_out_of_range) {
    value = std::strtod(std::string(word).c_str(), nullptr);
  }
  return value;
}

}  // namespace handgraft::io
