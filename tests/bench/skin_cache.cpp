#include "tests/bench/skin_cache.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/hand/skin_cache.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

constexpr double kCloseEnough = 0.03;  // share of the vertices
constexpr int kTries = 6;
constexpr double kShortestEdge = 5e-4;  // m; permitted by SkinOptions
constexpr double kLongestEdge = 0.05;   // m

}  // namespace

fs::path defaultCache() {
  const fs::path home = environment("XDG_CACHE_HOME");
  return (home.empty() ? fs::temp_directory_path() : home) / "handgraft-bench";
}

hand::Skin skinOfSize(const hand::HandModel& model, int vertex_count, const fs::path& cache) {
  const hand::SkinCache kept(cache);
  hand::SkinOptions options;
  for (int i = 0; i < kTries; ++i) {
    hand::Skin skin = kept.get(model, options, Progress());
    const double ratio = static_cast<double>(skin.mesh().vertexCount()) / vertex_count;
    if (std::abs(ratio - 1.0) <= kCloseEnough) return skin;
    // Vertices go with the inverse square of the edge.
    options.edge_m = std::clamp(options.edge_m * std::sqrt(ratio), kShortestEdge, kLongestEdge);
  }
  rejectInput("hand {}: no edge length from {} to {} m gives its skin {} vertices",
              quoted(model.name()), kShortestEdge, kLongestEdge, vertex_count);
}

}  // namespace handgraft::bench
