#include "core/transfer/draft_charts.h"

#include <cmath>

#include "core/base/progress.h"
#include "core/base/weak_cache.h"
#include "core/geometry/sample_thinning.h"

namespace handgraft::transfer {

namespace {

constexpr double kApart = 0.003;     // m, of charts
constexpr double kFarthest = 0.004;  // m, of a root from the middle of its chart

// Charts come in steps of reach, 19 % apart.
constexpr double kStepsPerDoubling = 4.0;

// Some 10 kB each. One more, and all are forgotten.
constexpr std::size_t kMostCharts = 2048;

geometry::SurfacePoint middleOf(int face) {
  return {face, Eigen::Vector3d::Constant(1.0 / 3.0)};
}

}  // namespace

DraftCharts::DraftCharts(const hand::Skin& skin)
    : skin_S_(geometry::LogMapper::borrowing(skin.mesh())) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  Eigen::Matrix3Xd middles(3, mesh_S.faceCount());
  for (int f = 0; f < mesh_S.faceCount(); ++f)
    middles.col(f) = positionOf(mesh_S, middleOf(f));
  const geometry::Thinned thinned = geometry::thinOut(middles, skin.faceLinks(), kApart);
  for (const int nearest : thinned.nearest)
    served_by_.push_back(thinned.kept[static_cast<std::size_t>(nearest)]);
}

std::shared_ptr<const SkinChart> DraftCharts::about(const geometry::SurfacePoint& root_S,
                                                    double reach) const {
  const geometry::TriangleMesh& mesh_S = skin_S_->mesh();
  const int face = served_by_[static_cast<std::size_t>(root_S.face)];
  const geometry::SurfacePoint middle = middleOf(face);
  const double shift = (positionOf(mesh_S, root_S) - positionOf(mesh_S, middle)).norm();
  if (!(shift <= kFarthest)) return nullptr;
  const int step =
      static_cast<int>(std::ceil(kStepsPerDoubling * std::log2(reach + kFarthest)));
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = charts_.find({face, step}); known != charts_.end())
      return known->second;
  }
  const Eigen::Vector3d side =
      mesh_S.vertex(mesh_S.face(face)[1]) - mesh_S.vertex(mesh_S.face(face)[0]);
  auto chart = std::make_shared<const SkinChart>(skin_S_, PatchPlacement{middle, side},
                                                 std::exp2(step / kStepsPerDoubling),
                                                 geometry::LogMapMethod::kFast);
  const std::lock_guard lock(mutex_);
  if (charts_.size() >= kMostCharts) charts_.clear();
  charts_.emplace(std::pair(face, step), chart);
  return chart;
}

std::shared_ptr<const DraftCharts> draftChartsOf(
    const std::shared_ptr<const hand::Skin>& skin) {
  static WeakCache<hand::Skin, DraftCharts> memory;
  return memory.get(skin, Progress(), [&] {
    return std::make_shared<const DraftCharts>(*skin);
  });
}

}  // namespace handgraft::transfer
