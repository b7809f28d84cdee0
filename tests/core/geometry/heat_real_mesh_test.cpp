#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/heat_log_map.h"
#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::geometry {
namespace {

// Factoring takes most of the time; meshes larger than this add nothing new.
constexpr int kMostVertices = 6000;

void expectSaneDisk(const TriangleMesh& mesh, const LogMap& map) {
  const Eigen::Vector3d origin = positionOf(mesh, map.source);
  for (const int v : map.vertices) {
    ASSERT_TRUE(std::isfinite(map.phi[v]));
    ASSERT_LE(map.r[v], map.radius);
    ASSERT_GE(map.r[v], 0.899 * (mesh.vertex(v) - origin).norm());
  }
  const LogMapInverse inverse(mesh, map);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d uv_T =
        Eigen::Rotation2Dd(0.3 * i) * Eigen::Vector2d(map.radius * i / 20, 0);
    const LogMapInverse::Place place = inverse.at(uv_T);
    if (!place.point.valid()) continue;
    ASSERT_LT((logCoordinates(mesh, map, place.point) - uv_T).norm(), 1e-8 * mesh.diagonal());
  }
}

TEST(HeatLogMap, IsSaneOrRefusedOnRealMeshes) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(11);
  int served = 0;
  int refused = 0;
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
      if (mesh.vertexCount() > kMostVertices) continue;
      const HeatLogMap solver(mesh);
      for (int i = 0; i < 6; ++i) {
        SurfacePoint source{
            static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount())),
            {0.2, 0.5, 0.3}};
        if (i % 3 == 1) source.barycentric = {0.0, 0.4, 0.6};
        if (i % 3 == 2) source.barycentric = {0.0, 0.0, 1.0};
        const Eigen::Vector3d direction = normalOf(mesh, source).unitOrthogonal();
        const double radius = (i < 3 ? 0.15 : 1.0) * mesh.diagonal();
        try {
          expectSaneDisk(mesh, solver.smooth(source, direction, radius));
          if (i < 3) expectSaneDisk(mesh, solver.heat(source, direction, radius));
          ++served;
        } catch (const InvalidInput&) {
          ++refused;
        }
      }
    }
  }
  RecordProperty("served", served);
  RecordProperty("refused", refused);
  EXPECT_GT(served, 200);
}

}  // namespace
}  // namespace handgraft::geometry
