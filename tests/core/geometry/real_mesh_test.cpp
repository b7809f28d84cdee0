#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::geometry {
namespace {

void expectSaneDisk(const TriangleMesh& mesh,
                    const SurfacePoint& source,
                    double radius,
                    LogMapMethod method) {
  const Eigen::Vector3d normal = normalOf(mesh, source);
  const LogMap map = computeLogMap(mesh, source, normal.unitOrthogonal(), radius, method);
  const Eigen::Vector3d origin = positionOf(mesh, source);
  for (const int v : map.vertices) {
    ASSERT_TRUE(std::isfinite(map.phi[v]));
    ASSERT_LE(map.r[v], radius);
    // No way over the surface is shorter than the straight one, but for what DGPC fits.
    const double least = map.method == LogMapMethod::kExact ? 1.0 - 1e-9 : 0.9;
    ASSERT_GE(map.r[v], least * (mesh.vertex(v) - origin).norm());
  }
  const LogMapInverse inverse(mesh, map);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d uv_T =
        Eigen::Rotation2Dd(0.3 * i) * Eigen::Vector2d(radius * i / 20, 0);
    const LogMapInverse::Place place = inverse.at(uv_T);
    if (!place.point.valid()) continue;
    ASSERT_LT((logCoordinates(mesh, map, place.point) - uv_T).norm(), 1e-8 * mesh.diagonal());
  }
}

/// Dijkstra's distances bound exact ones from above.
void expectNoShorterWayAlongEdges(const TriangleMesh& mesh,
                                  const SurfacePoint& source,
                                  double radius) {
  const LogMap map = computeLogMap(mesh, source, normalOf(mesh, source).unitOrthogonal(),
                                   radius, LogMapMethod::kExact);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  Eigen::VectorXd r =
      Eigen::VectorXd::Constant(mesh.vertexCount(), std::numeric_limits<double>::infinity());
  const auto offer = [&](int v, double distance) {
    if (distance >= r[v] || distance > radius) return;
    r[v] = distance;
    queue.emplace(distance, v);
  };
  for (const int v : mesh.face(source.face))
    offer(v, (mesh.vertex(v) - positionOf(mesh, source)).norm());
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > r[v]) continue;
    ASSERT_LE(map.r[v], distance * (1.0 + 1e-9)) << v;  // NaN where missed fails, too
    for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
      for (const int to : {mesh.to(*h), mesh.from(TriangleMesh::previous(*h))})
        offer(to, distance + (mesh.vertex(to) - mesh.vertex(v)).norm());
    }
  }
}

TEST(LogMap, IsSaneOnEveryRealMesh) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(11);
  int meshes = 0;
  for (const char* folder : {"hands", "objects"}) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(test::sharedData(folder))) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".obj" || extension == ".stl" || extension == ".ply") {
        paths.push_back(entry.path());
      }
    }
    std::sort(paths.begin(), paths.end());
    for (const std::filesystem::path& path : paths) {
      SCOPED_TRACE(path.string());
      const TriangleMesh mesh = io::readMesh(path).mesh;
      ++meshes;
      for (int i = 0; i < 6; ++i) {
        SurfacePoint source{
            static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount())),
            {0.2, 0.5, 0.3}};
        if (i % 3 == 1) source.barycentric = {0.0, 0.4, 0.6};
        if (i % 3 == 2) source.barycentric = {0.0, 0.0, 1.0};
        expectSaneDisk(mesh, source, (i < 3 ? 0.15 : 1.0) * mesh.diagonal(),
                       LogMapMethod::kFast);
        if (i < 3) expectSaneDisk(mesh, source, 0.15 * mesh.diagonal(), LogMapMethod::kAuto);
        // No vertex is farther than along edges, and none that edges reach is missed.
        if (i < 3) expectNoShorterWayAlongEdges(mesh, source, 0.1 * mesh.diagonal());
      }
    }
  }
  EXPECT_GT(meshes, 60);
}

}  // namespace
}  // namespace handgraft::geometry
