#include "tests/bench/disk_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::bench {

namespace {

using geometry::LogMap;
using geometry::LogMapInverse;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr int kCircle = 25;
constexpr double kInside = 1e-6;    // barycentric: covered beyond doubt
constexpr double kNoShare = 1e-6;   // of its area: the face is a line in T, and covers nothing
constexpr double kThinnest = 1e-9;  // of the squared edges: no side to turn over
// Of an edge's length, in T: beyond, a face joins two sides of the cut locus and covers
// nothing.
constexpr double kMostStretch = 4.0;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A face as it lies in the tangent plane.
struct Laid {
  int face;
  Eigen::Matrix<double, 2, 3> corners_T;
  double share;   ///< area in T by area on the surface; negative if turned over
  bool has_area;  ///< on the surface
  bool stretched;

  /// Least barycentric weight of `p_T`; positive inside, whichever side is up.
  [[nodiscard]] double margin(const Eigen::Vector2d& p_T) const {
    const Eigen::Vector2d a = corners_T.col(0) - p_T;
    const Eigen::Vector2d b = corners_T.col(1) - p_T;
    const Eigen::Vector2d c = corners_T.col(2) - p_T;
    const Eigen::Vector3d areas(cross(b, c), cross(c, a), cross(a, b));
    return (areas / areas.sum()).minCoeff();
  }
};

Laid layOut(const TriangleMesh& mesh, const LogMap& map, int f) {
  Laid laid{f, {}, 0.0, true, false};
  Eigen::Matrix3d corners;
  for (int c = 0; c < 3; ++c) {
    corners.col(c) = mesh.vertex(mesh.faces()(c, f));
    laid.corners_T.col(c) = geometry::logCoordinatesAtVertex(map, mesh.faces()(c, f));
  }
  const Eigen::Vector3d ab = corners.col(1) - corners.col(0);
  const Eigen::Vector3d ac = corners.col(2) - corners.col(0);
  const double area = ab.cross(ac).norm();
  laid.has_area = area > kThinnest * (ab.squaredNorm() + ac.squaredNorm());
  const Eigen::Vector2d ab_T = laid.corners_T.col(1) - laid.corners_T.col(0);
  const Eigen::Vector2d ac_T = laid.corners_T.col(2) - laid.corners_T.col(0);
  laid.share = laid.has_area ? cross(ab_T, ac_T) / area : 0.0;
  for (int c = 0; c < 3; ++c) {
    const int n = (c + 1) % 3;
    const double length = (corners.col(n) - corners.col(c)).norm();
    laid.stretched = laid.stretched || (laid.corners_T.col(n) - laid.corners_T.col(c)).norm() >
                                           kMostStretch * length;
  }
  return laid;
}

long countNotFinite(const LogMap& map) {
  long count = 0;
  for (const int v : map.vertices)
    count += std::isfinite(map.r[v]) && std::isfinite(map.phi[v]) ? 0 : 1;
  for (const LogMap::RimVertex& rim : map.rim)
    count += rim.p_T.allFinite() ? 0 : 1;
  return count;
}

class DiskJudge {
 public:
  DiskJudge(const TriangleMesh& mesh, const LogMap& map, const LogMapInverse& inverse)
      : inverse_(inverse) {
    tally_.not_finite = countNotFinite(map);
    for (const std::vector<int>* faces : {&map.faces, &map.rim_faces}) {
      for (const int f : *faces)
        laid_.push_back(layOut(mesh, map, f));
    }
  }

  DiskTally judge(double radius) {
    for (const Laid& laid : laid_)
      judgeFace(laid);
    for (int i = 0; i < kCircle; ++i) {
      judgePlace(
          radius *
          Eigen::Rotation2Dd(2.0 * std::numbers::pi * i / kCircle).toRotationMatrix().col(0));
    }
    return tally_;
  }

 private:
  void judgeFace(const Laid& laid) {
    constexpr double kCollapsed = 0.1;
    ++tally_.faces;
    if (!laid.has_area || laid.share >= kCollapsed) return;
    const bool is_turned_over = laid.share < -kNoShare;
    ++(is_turned_over ? tally_.turned_over : tally_.collapsed);
    if (!is_turned_over) return;
    // Asked for its own middle, the inverse must not answer with a face that looks away.
    const LogMapInverse::Place place = inverse_.at(laid.corners_T.rowwise().mean());
    if (place.point.face == laid.face) ++tally_.unreported;
  }

  void judgePlace(const Eigen::Vector2d& uv_T) {
    ++tally_.queries;
    const LogMapInverse::Place place = inverse_.at(uv_T);
    if (!place.point.valid()) {
      switch (place.reason) {
        case geometry::Unreachable::kSurfaceEdge:
          ++tally_.lost_at_edge;
          break;
        case geometry::Unreachable::kCutLocus:
          ++tally_.lost_at_cut_locus;
          break;
        case geometry::Unreachable::kBeyondRadius:
          ++tally_.lost_beyond;
          break;
      }
      return;
    }
    ++tally_.placed;
    if (!place.point.barycentric.allFinite()) ++tally_.not_finite;
    if (place.folded) {
      ++tally_.folded;
      return;
    }
    int covering = 0;
    for (const Laid& laid : laid_) {
      if (std::abs(laid.share) > kNoShare && !laid.stretched && laid.margin(uv_T) > kInside)
        ++covering;
    }
    if (covering > 1) ++tally_.unreported;
  }

  const LogMapInverse& inverse_;
  std::vector<Laid> laid_;
  DiskTally tally_;
};

}  // namespace

DiskTally& DiskTally::operator+=(const DiskTally& other) {
  for (long DiskTally::*count :
       {&DiskTally::disks, &DiskTally::refused, &DiskTally::queries, &DiskTally::placed,
        &DiskTally::folded, &DiskTally::lost_at_edge, &DiskTally::lost_at_cut_locus,
        &DiskTally::lost_beyond, &DiskTally::not_finite, &DiskTally::faces,
        &DiskTally::turned_over, &DiskTally::collapsed, &DiskTally::unreported,
        &DiskTally::fell_back}) {
    this->*count += other.*count;
  }
  ms.insert(ms.end(), other.ms.begin(), other.ms.end());
  return *this;
}

double DiskTally::medianMs() const {
  if (ms.empty()) return 0.0;
  std::vector<double> sorted = ms;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

DiskTally checkDisk(const geometry::LogMapper& maps,
                    const SurfacePoint& root,
                    double radius,
                    LogMapMethod method) {
  using Clock = std::chrono::steady_clock;
  const TriangleMesh& mesh = maps.mesh();
  const auto start = Clock::now();
  try {
    const Eigen::Vector3d normal = normalOf(mesh, root);
    const LogMap map = maps.map(root, normal.unitOrthogonal(), radius, method);
    const LogMapInverse inverse(mesh, map);
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    DiskTally tally = DiskJudge(mesh, map, inverse).judge(radius);
    tally.disks = 1;
    tally.ms = {ms};
    tally.fell_back = method == LogMapMethod::kAuto && map.method != LogMapMethod::kExact;
    return tally;
  } catch (const InvalidInput&) {
    DiskTally refused;
    refused.refused = 1;
    return refused;
  }
}

std::vector<Root> randomRoots(const TriangleMesh& mesh, int count, unsigned seed) {
  constexpr double kRadii[] = {0.005, 0.010, 0.020, 0.040};
  std::vector<double> sums;
  double sum = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const Eigen::Vector3d a = mesh.vertex(face[0]);
    sum += (mesh.vertex(face[1]) - a).cross(mesh.vertex(face[2]) - a).norm();
    sums.push_back(sum);
  }
  if (!(sum > 0.0)) return {};
  std::mt19937 random(seed);
  // Not std::uniform_real_distribution, whose numbers differ from library to library.
  const auto part = [&]() {
    return static_cast<double>(random()) / 4294967296.0;
  };
  std::vector<Root> roots;
  for (int i = 0; i < count; ++i) {
    const auto place = std::upper_bound(sums.begin(), sums.end(), part() * sum);
    const int face =
        static_cast<int>(std::min<std::ptrdiff_t>(place - sums.begin(), std::ssize(sums) - 1));
    double u = part();
    double v = part();
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    roots.push_back({{face, {1.0 - u - v, u, v}}, kRadii[i % 4]});
  }
  return roots;
}

const char* nameOf(Damage damage) {
  switch (damage) {
    case Damage::kNone:
      return "whole";
    case Damage::kDeleted:
      return "deleted";
    case Damage::kDuplicated:
      return "duplicated";
    case Damage::kFlipped:
      return "flipped";
    case Damage::kMerged:
      return "merged";
  }
  return "";
}

TriangleMesh broken(const TriangleMesh& mesh, Damage damage, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<int> drawn_to(static_cast<std::size_t>(mesh.vertexCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    drawn_to[v] = v;
    const bool is_drawn = damage == Damage::kMerged && random() % 50 == 0 &&
                          mesh.outgoingBegin(v) != mesh.outgoingEnd(v);
    if (!is_drawn) continue;
    // Three edges away: no neighbour, but near.
    int near = v;
    for (int step = 0; step < 3; ++step) {
      const int* out = mesh.outgoingBegin(near);
      const auto count = static_cast<unsigned>(mesh.outgoingEnd(near) - out);
      near = mesh.to(out[random() % count]);
    }
    drawn_to[v] = near;
  }
  std::vector<int> corners;
  const auto add = [&](int a, int b, int c) {
    if (a != b && b != c && c != a) corners.insert(corners.end(), {a, b, c});
  };
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const int a = drawn_to[face[0]];
    const int b = drawn_to[face[1]];
    const int c = drawn_to[face[2]];
    const auto chance = static_cast<int>(random() % 100);
    if (damage == Damage::kDeleted && chance < 10) continue;
    if (damage == Damage::kFlipped && chance < 5) {
      add(a, c, b);
      continue;
    }
    add(a, b, c);
    if (damage == Damage::kDuplicated && chance < 5) add(a, b, c);
  }
  return {mesh.vertices(), Eigen::Map<const Eigen::Matrix3Xi>(
                               corners.data(), 3, static_cast<int>(corners.size()) / 3)};
}

}  // namespace handgraft::bench
