#include "tests/bench/skin_cache.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/io/mesh_file.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

constexpr double kCloseEnough = 0.03;  // share of the vertices
constexpr int kTries = 6;
constexpr double kShortestEdge_m = 5e-4;  // permitted by SkinOptions
constexpr double kLongestEdge_m = 0.05;

fs::path fileOf(const fs::path& urdf, int vertex_count, const fs::path& cache) {
  const std::size_t key = std::hash<std::string>()(fs::absolute(urdf).string());
  return cache / fmt::format("{}_{:016x}_{}.ply", urdf.stem().string(), key, vertex_count);
}

}  // namespace

fs::path defaultCache() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment.
  const char* home = std::getenv("XDG_CACHE_HOME");
  const fs::path folder =
      home != nullptr && *home != '\0' ? fs::path(home) : fs::temp_directory_path();
  return folder / "handgraft-bench";
}

hand::Skin skinOfSize(const fs::path& urdf,
                      const hand::HandModel& model,
                      int vertex_count,
                      const fs::path& cache) {
  hand::SkinOptions options;
  const fs::path file = fileOf(urdf, vertex_count, cache);
  if (fs::exists(file) && fs::last_write_time(file) > fs::last_write_time(urdf)) {
    return {model, io::readMesh(file).mesh, hand::skinReferencePose(model), options.epsilon_m};
  }
  for (int i = 0; i < kTries; ++i) {
    hand::Skin skin = buildSkin(model, options, Progress());
    const double ratio = static_cast<double>(skin.mesh().vertexCount()) / vertex_count;
    if (std::abs(ratio - 1.0) <= kCloseEnough) {
      // Under another name first: a reader never sees half a file.
      const fs::path half = file.string() + ".part";
      fs::create_directories(cache);
      io::writePly(half, skin.mesh());
      fs::rename(half, file);
      return skin;
    }
    // Vertices go with the inverse square of the edge.
    options.edge_m =
        std::clamp(options.edge_m * std::sqrt(ratio), kShortestEdge_m, kLongestEdge_m);
  }
  rejectInput("{}: no edge length from {} to {} m gives its skin {} vertices",
              quoted(urdf.string()), kShortestEdge_m, kLongestEdge_m, vertex_count);
}

}  // namespace handgraft::bench
