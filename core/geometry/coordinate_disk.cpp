#include "core/geometry/coordinate_disk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace handgraft::geometry {

namespace {

constexpr double kShortest = 0.9;  // of the straight line; as documented

double distanceToOrigin(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length_squared = ab.squaredNorm();
  const double t =
      length_squared > 0.0 ? std::clamp(-a.dot(ab) / length_squared, 0.0, 1.0) : 0.0;
  return (a + t * ab).norm();
}

class DiskFlood {
 public:
  DiskFlood(const TriangleMesh& mesh,
            const Eigen::Matrix2Xd& p_T,
            const SurfacePoint& source,
            double radius)
      : mesh_(mesh),
        p_T_(p_T),
        origin_(positionOf(mesh, source)),
        met_(static_cast<std::size_t>(mesh.faceCount()), 0) {
    map_.source = source;
    map_.radius = radius;
    map_.r.setConstant(mesh.vertexCount(), std::numeric_limits<double>::quiet_NaN());
    map_.phi = map_.r;
  }

  LogMap spreadFrom(const std::vector<int>& source_faces) {
    for (const int f : source_faces)
      reach(f);
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      const int f = waiting_[i];
      if (!takeFace(f, i < source_faces.size())) continue;
      for (int h = 3 * f; h < 3 * f + 3; ++h) {
        if (mesh_.twin(h) >= 0) reach(TriangleMesh::faceOf(mesh_.twin(h)));
      }
    }
    sortAll();
    return std::move(map_);
  }

 private:
  void reach(int f) {
    if (met_[f]) return;
    met_[f] = 1;
    waiting_.push_back(f);
  }

  [[nodiscard]] bool isTrusted(int v) const {
    return p_T_.col(v).norm() >= kShortest * (mesh_.vertex(v) - origin_).norm();
  }

  bool takeFace(int f, bool at_source) {
    const Eigen::Vector3i face = mesh_.face(f);
    double farthest = 0.0;
    for (const int v : face) {
      if (!isTrusted(v)) return false;  // NaN fails, too
      farthest = std::max(farthest, p_T_.col(v).norm());
    }
    const bool inside = farthest <= map_.radius;
    if (inside || at_source) {
      map_.faces.push_back(f);
    } else if (std::min({distanceToOrigin(p_T_.col(face[0]), p_T_.col(face[1])),
                         distanceToOrigin(p_T_.col(face[1]), p_T_.col(face[2])),
                         distanceToOrigin(p_T_.col(face[2]), p_T_.col(face[0]))}) <=
               map_.radius) {
      map_.rim_faces.push_back(f);
    } else {
      return false;
    }
    for (const int v : face)
      takeVertex(v);
    return true;
  }

  void takeVertex(int v) {
    const double r = p_T_.col(v).norm();
    if (r > map_.radius) {
      map_.rim.push_back({v, p_T_.col(v)});
    } else if (std::isnan(map_.r[v])) {
      map_.vertices.push_back(v);
      map_.r[v] = r;
      const double phi = std::atan2(p_T_(1, v), p_T_(0, v));
      map_.phi[v] = phi == -std::numbers::pi ? std::numbers::pi : phi;
    }
  }

  void sortAll() {
    std::sort(map_.vertices.begin(), map_.vertices.end(), [&](int a, int b) {
      return std::pair(map_.r[a], a) < std::pair(map_.r[b], b);
    });
    const auto by_vertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex < b.vertex;
    };
    const auto same_vertex = [](const LogMap::RimVertex& a, const LogMap::RimVertex& b) {
      return a.vertex == b.vertex;
    };
    std::sort(map_.rim.begin(), map_.rim.end(), by_vertex);
    map_.rim.erase(std::unique(map_.rim.begin(), map_.rim.end(), same_vertex), map_.rim.end());
    std::sort(map_.faces.begin(), map_.faces.end());
    std::sort(map_.rim_faces.begin(), map_.rim_faces.end());
  }

  const TriangleMesh& mesh_;
  const Eigen::Matrix2Xd& p_T_;
  Eigen::Vector3d origin_;
  std::vector<char> met_;
  std::vector<int> waiting_;
  LogMap map_;
};

}  // namespace

LogMap diskFromCoordinates(const TriangleMesh& mesh,
                           const Eigen::Matrix2Xd& p_T,
                           const SurfacePoint& source,
                           const std::vector<int>& source_faces,
                           double radius) {
  return DiskFlood(mesh, p_T, source, radius).spreadFrom(source_faces);
}

}  // namespace handgraft::geometry
