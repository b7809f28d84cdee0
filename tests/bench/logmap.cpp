#include "tests/bench/logmap.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/heat_log_map.h"
#include "core/geometry/log_map.h"
#include "core/io/mesh_file.h"

namespace handgraft::bench {

namespace {

constexpr int kRepeats = 20;

struct LogMapOptions {
  std::string mesh;
  int root_vertex = 0;
  std::string method = "fast";
  double radius_m = std::numeric_limits<double>::infinity();
  std::vector<double> direction;
  std::string csv;
};

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

int meshVertexOf(const io::MeshFile& file, int file_vertex) {
  const int count = static_cast<int>(file.mesh_vertex.size());
  if (file_vertex < 0 || file_vertex >= count) {
    rejectInput("--root-vertex is {}, the file has vertices 0 to {}", file_vertex, count - 1);
  }
  if (file.mesh_vertex[file_vertex] < 0) {
    rejectInput("--root-vertex is {}, a vertex without a face; permitted are those with one",
                file_vertex);
  }
  return file.mesh_vertex[file_vertex];
}

/// Without --direction: the axis of the mesh's frame that lies flattest at the root, x before y
/// before z.
Eigen::Vector3d directionOf(const LogMapOptions& options, const Eigen::Vector3d& normal) {
  if (!options.direction.empty()) {
    return {options.direction[0], options.direction[1], options.direction[2]};
  }
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  return Eigen::Vector3d::Unit(axis);
}

/// Rows in the file's own order; vertices that were welded into one have a row each.
void writeCsv(const std::string& path, const io::MeshFile& file, const geometry::LogMap& map) {
  std::ofstream out(path);
  out << "vertex,r,phi\n";
  for (std::size_t v = 0; v < file.mesh_vertex.size(); ++v) {
    const int vertex = file.mesh_vertex[v];
    if (vertex < 0 || std::isnan(map.r[vertex])) continue;
    out << fmt::format("{},{:.17g},{:.17g}\n", v, map.r[vertex], map.phi[vertex]);
  }
  out.close();
  if (!out) rejectInput("--csv file {} cannot be written", handgraft::quoted(path));
}

void runLogMap(const LogMapOptions& options) {
  const geometry::LogMapMethod method = geometry::logMapMethodFrom(options.method);
  const io::MeshFile file = io::readMesh(options.mesh);
  const geometry::SurfacePoint root =
      geometry::surfacePointAtVertex(file.mesh, meshVertexOf(file, options.root_vertex));
  const Eigen::Vector3d direction = directionOf(options, geometry::normalOf(file.mesh, root));

  // Setup is what a method prepares once per mesh: the connectivity, and for the heat methods
  // their factors.
  Clock::time_point start = Clock::now();
  const geometry::TriangleMesh mesh(file.mesh.vertices(), file.mesh.faces());
  const bool smooth = method == geometry::LogMapMethod::kSmooth;
  std::optional<geometry::HeatLogMap> heat;
  if (smooth || method == geometry::LogMapMethod::kHeat) {
    heat.emplace(mesh);
    // The vector heat method factors a third system when it is first asked.
    if (!smooth) static_cast<void>(heat->heat(root, direction, options.radius_m));
  }
  const double setup_ms = millisecondsSince(start);

  geometry::LogMap map;
  std::vector<double> solve_ms;
  for (int i = 0; i < kRepeats; ++i) {
    start = Clock::now();
    if (heat) {
      map = smooth ? heat->smooth(root, direction, options.radius_m)
                   : heat->heat(root, direction, options.radius_m);
    } else {
      map = geometry::computeLogMap(mesh, root, direction, options.radius_m, method);
    }
    solve_ms.push_back(millisecondsSince(start));
  }
  std::sort(solve_ms.begin(), solve_ms.end());
  const double median_ms = (solve_ms[kRepeats / 2 - 1] + solve_ms[kRepeats / 2]) / 2.0;

  if (!options.csv.empty()) writeCsv(options.csv, file, map);
  fmt::print(
      "{{\"method\":\"{}\",\"vertices\":{},\"reached\":{},\"ms_setup\":{:.6g},"
      "\"ms_solve\":{:.6g}}}\n",
      geometry::nameOf(map.method), mesh.vertexCount(), map.vertices.size(), setup_ms,
      median_ms);
}

}  // namespace

void addLogMapCommand(CLI::App& app) {
  auto options = std::make_shared<LogMapOptions>();
  CLI::App* command =
      app.add_subcommand("logmap", "Log map of a mesh about one of its vertices");
  command->add_option("mesh", options->mesh, "STL, OBJ, PLY, glTF/GLB or DAE")->required();
  command->add_option("--root-vertex", options->root_vertex, "source, in the file's own order")
      ->required();
  command->add_option("--method", options->method, "fast, exact, auto, smooth or heat");
  command->add_option("--radius", options->radius_m,
                      "of the disk, metres (default: whole mesh)");
  command
      ->add_option(
          "--direction", options->direction,
          "x axis, projected onto the tangent plane (default: the flattest of x, y, z)")
      ->expected(3);
  command->add_option("--csv", options->csv, "write vertex,r,phi here (metres, radians)");
  command->callback([options]() {
    runLogMap(*options);
  });
}

}  // namespace handgraft::bench
