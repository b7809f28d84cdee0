#include "tests/bench/disk_speed.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/geometry/heat_log_map.h"

#include "tests/bench/cgal_geodesics.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

using geometry::LogMap;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kLow = 0.1;
constexpr double kHigh = 0.9;
/// CGAL's disk reaches this much farther, so that no path inside is cut.
constexpr double kCutMargin = 1.1;

Eigen::Vector3d directionAt(const TriangleMesh& mesh, const SurfacePoint& root) {
  return normalOf(mesh, root).unitOrthogonal();
}

LogMap mapAbout(const DiskTask& task,
                const SurfacePoint& root,
                LogMapMethod method,
                double radius_m) {
  return computeLogMap(*task.mesh, root, directionAt(*task.mesh, root), radius_m, method);
}

DiskSpeed describe(const DiskTask& task, const std::string& method) {
  DiskSpeed speed;
  speed.surface = task.surface;
  speed.vertices = task.mesh->vertexCount();
  speed.radius_m = task.radius_m;
  speed.method = method;
  speed.roots = static_cast<int>(task.roots.size());
  return speed;
}

/// Runs `work` for every root and compares the distances that `distance_to` then gives with
/// our `exact`.
template <class Work, class DistanceTo>
void measureRoots(const DiskTask& task,
                  int repeats,
                  const Work& work,
                  const DistanceTo& distance_to,
                  DiskSpeed& speed) {
  std::vector<double> times;
  std::vector<double> reached;
  for (const SurfacePoint& root : task.roots) {
    times.push_back(leastMilliseconds(repeats, [&] {
      work(root);
    }));
    const LogMap exact = mapAbout(task, root, LogMapMethod::kExact, task.radius_m);
    int count = 0;
    for (const int v : exact.vertices) {
      const double r = distance_to(v);
      if (std::isnan(r)) continue;
      ++count;
      speed.r_difference_m = std::max(speed.r_difference_m, std::abs(r - exact.r[v]));
    }
    reached.push_back(count);
  }
  speed.times = timesOf(times);
  speed.reached = quantile(reached, 0.5);
}

/// The disk's faces as a mesh of their own.
struct Cut {
  TriangleMesh mesh;
  std::vector<int> vertex;  ///< number in the cut of every vertex of the whole; -1 outside
  std::vector<int> face;    ///< likewise of faces
};

Cut cutOut(const TriangleMesh& mesh, const LogMap& map) {
  Cut cut{{},
          std::vector<int>(static_cast<std::size_t>(mesh.vertexCount()), -1),
          std::vector<int>(static_cast<std::size_t>(mesh.faceCount()), -1)};
  Eigen::Matrix3Xd vertices(3, mesh.vertexCount());
  Eigen::Matrix3Xi faces(3, static_cast<int>(map.faces.size()));
  int count = 0;
  for (std::size_t i = 0; i < map.faces.size(); ++i) {
    const Eigen::Vector3i face = mesh.face(map.faces[i]);
    cut.face[static_cast<std::size_t>(map.faces[i])] = static_cast<int>(i);
    for (int corner = 0; corner < 3; ++corner) {
      int& number = cut.vertex[static_cast<std::size_t>(face[corner])];
      if (number < 0) {
        vertices.col(count) = mesh.vertex(face[corner]);
        number = count++;
      }
      faces(corner, static_cast<int>(i)) = number;
    }
  }
  cut.mesh = TriangleMesh(vertices.leftCols(count), faces);
  return cut;
}

}  // namespace

Times timesOf(const std::vector<double>& per_root_ms) {
  return {quantile(per_root_ms, 0.5), quantile(per_root_ms, kLow),
          quantile(per_root_ms, kHigh)};
}

DiskSpeed measureDisk(const DiskTask& task, LogMapMethod method) {
  DiskSpeed speed = describe(task, std::string(geometry::nameOf(method)));
  std::optional<geometry::HeatLogMap> heat;
  const bool smooth = method == LogMapMethod::kSmooth;
  if (smooth || method == LogMapMethod::kHeat) {
    const double start = threadMilliseconds();
    heat.emplace(*task.mesh);
    // The vector heat method factors a third system when it is first asked.
    if (!smooth) {
      static_cast<void>(heat->heat(task.roots.front(),
                                   directionAt(*task.mesh, task.roots.front()), task.radius_m));
    }
    speed.setup_ms = threadMilliseconds() - start;
  }
  LogMap map;
  const auto work = [&](const SurfacePoint& root) {
    const Eigen::Vector3d direction = directionAt(*task.mesh, root);
    map = smooth ? heat->smooth(root, direction, task.radius_m)
          : heat ? heat->heat(root, direction, task.radius_m)
                 : computeLogMap(*task.mesh, root, direction, task.radius_m, method);
  };
  measureRoots(
      task, task.repeats, work,
      [&](int v) {
        return map.r[v];
      },
      speed);
  for (const SurfacePoint& root : task.roots) {
    if (heat) break;
    work(root);
    speed.exact_maps += map.method == LogMapMethod::kExact ? 1 : 0;
  }
  return speed;
}

DiskSpeed measureCgalWhole(const DiskTask& task) {
  DiskSpeed speed = describe(task, "cgal exact");
  const double start = threadMilliseconds();
  CgalShortestPaths paths(*task.mesh);
  speed.setup_ms = threadMilliseconds() - start;
  measureRoots(
      task, 1,
      [&](const SurfacePoint& root) {
        paths.build(root);
      },
      [&](int v) {
        return paths.distanceTo(v);
      },
      speed);
  return speed;
}

DiskSpeed measureCgalCut(const DiskTask& task) {
  DiskSpeed speed = describe(task, "cgal exact cut");
  std::vector<double> times;
  std::vector<double> reached;
  for (const SurfacePoint& root : task.roots) {
    DiskTask single = task;
    single.roots = {root};
    const double wide_m = kCutMargin * task.radius_m + 2.0 * task.mesh->meanEdgeLength();
    const Cut cut = cutOut(*task.mesh, mapAbout(task, root, LogMapMethod::kExact, wide_m));
    CgalShortestPaths paths(cut.mesh);
    const SurfacePoint source{cut.face[static_cast<std::size_t>(root.face)], root.barycentric};
    measureRoots(
        single, task.repeats,
        [&](const SurfacePoint&) {
          paths.build(source);
        },
        [&](int v) {
          const int number = cut.vertex[static_cast<std::size_t>(v)];
          return number < 0 ? std::numeric_limits<double>::quiet_NaN()
                            : paths.distanceTo(number);
        },
        speed);
    times.push_back(speed.times.median_ms);
    reached.push_back(speed.reached);
  }
  speed.times = timesOf(times);
  speed.reached = quantile(reached, 0.5);
  return speed;
}

DiskSpeed measureCgalHeat(const DiskTask& task) {
  DiskSpeed speed = describe(task, "cgal heat");
  const double start = threadMilliseconds();
  CgalHeatMethod heat(*task.mesh);
  speed.setup_ms = threadMilliseconds() - start;
  // It starts at vertices alone: all are compared from there.
  DiskTask at_vertices = task;
  for (SurfacePoint& root : at_vertices.roots) {
    int corner = 0;
    root.barycentric.maxCoeff(&corner);
    root.barycentric = Eigen::Vector3d::Unit(corner);
  }
  Eigen::VectorXd r;
  measureRoots(
      at_vertices, std::min(task.repeats, 2),
      [&](const SurfacePoint& root) {
        r = heat.distancesFrom(vertexAt(*task.mesh, root));
      },
      [&](int v) {
        return r[v];
      },
      speed);
  return speed;
}

double growthExponent(const std::vector<double>& x, const std::vector<double>& y) {
  const auto count = static_cast<double>(x.size());
  if (x.size() < 2) return 0.0;
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / count;
    mean_y += std::log(y[i]) / count;
  }
  double above = 0.0;
  double below = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double d = std::log(x[i]) - mean_x;
    above += d * (std::log(y[i]) - mean_y);
    below += d * d;
  }
  return below > 0.0 ? above / below : 0.0;
}

}  // namespace handgraft::bench
