#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/geometry/log_mapper.h"
#include "core/hand/skin.h"
#include "core/transfer/skin_chart.h"

namespace handgraft::transfer {

/// Quick charts of a skin for drafts, shared by all that lay patches on it.
///
/// A chart serves all roots next to its own: about those its coordinates are off by what the
/// surface bends between the two, some millimetres apart. Searches slide roots over the same
/// few square centimetres of fingers, grasp after grasp. Which chart serves a root, and what
/// it is, depends on the skin alone. Safe from several threads.
class DraftCharts {
 public:
  /// Keeps `skin` by reference, and so do charts.
  explicit DraftCharts(const hand::Skin& skin);

  /// A chart of all coordinates up to `reach` about `root_S`; null where the next one is too
  /// far away. Cost: a log map where nobody asked before.
  std::shared_ptr<const SkinChart> about(const geometry::SurfacePoint& root_S,
                                         double reach) const;

 private:
  std::shared_ptr<const geometry::LogMapper> skin_S_;
  std::vector<int> served_by_;  ///< per face: the face whose middle has a chart for it
  mutable std::mutex mutex_;
  mutable std::map<std::pair<int, int>, std::shared_ptr<const SkinChart>>
      charts_;  ///< by face and step of reach
};

/// Those of a skin, the same for all who ask while it lives; they must not outlive it.
std::shared_ptr<const DraftCharts> draftChartsOf(const std::shared_ptr<const hand::Skin>& skin);

}  // namespace handgraft::transfer
