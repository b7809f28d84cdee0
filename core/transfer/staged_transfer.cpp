#include "core/transfer/staged_transfer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMapInverse;
using geometry::SurfacePoint;

/// Lays points of a chart onto the skin, face to face.
class Layer {
 public:
  Layer(const hand::Skin& skin,
        const PatchChart& patch,
        double direction_angle,
        const SkinChart& chart,
        const PatchPlacement& placement)
      : skin_(skin), patch_(patch), chart_(chart), placement_(placement) {
    // The hand looks at the object: counter-clockwise becomes clockwise (phi_h = -phi_o).
    const Eigen::Matrix2d mirror = Eigen::Vector2d(1.0, -1.0).asDiagonal();
    const SkinChart::View view = *chart.viewFrom(placement);
    root_T_ = view.root_T;
    turn_ = Eigen::Rotation2Dd(view.direction_angle).toRotationMatrix() * mirror *
            Eigen::Rotation2Dd(-direction_angle).toRotationMatrix();
  }

  /// Where the point goes; without a place, `reason` says why.
  SurfacePoint place(const ChartPoint& point, std::string& reason, bool& folded) const {
    if (!point.reached) {
      reason = "not reached from the patch's root on the object";
      return {};
    }
    const LogMapInverse::Place place = chart_.at(root_T_ + turn_ * point.uv_T);
    if (!place.point.valid())
      reason = fmt::format("on the skin: {}", geometry::reasonOf(place.reason));
    folded = place.folded;
    return place.point;
  }

  [[nodiscard]] NetKnot knot(const ChartPoint& point) const {
    std::string reason;
    bool folded = false;
    const SurfacePoint place_S = place(point, reason, folded);
    if (!place_S.valid()) return {};
    return {true, point.p_O, positionOf(skin_.mesh(), place_S)};
  }

  /// The roots, where all rays begin.
  [[nodiscard]] NetKnot root() const {
    return {true, positionOf(patch_.object().mesh(), patch_.root()),
            positionOf(skin_.mesh(), placement_.root_S)};
  }

 private:
  const hand::Skin& skin_;
  const PatchChart& patch_;
  const SkinChart& chart_;
  const PatchPlacement& placement_;
  Eigen::Vector2d root_T_;  ///< in the skin chart
  Eigen::Matrix2d turn_;    ///< from the patch chart's coordinates to the skin chart's
};

/// Turns points into correspondences, or says why not.
class Collector {
 public:
  /// `planes_S`: null where the skin itself says where its links are.
  Collector(const hand::Skin& skin,
            const hand::SkinPlanes* planes_S,
            const Layer& layer,
            double weight,
            PatchTransfer& transfer)
      : skin_(skin), planes_S_(planes_S), layer_(layer), weight_(weight), transfer_(transfer) {}

  void add(const ChartPoint& point, int index, int ring) {
    std::string reason;
    bool folded = false;
    const SurfacePoint place_S = layer_.place(point, reason, folded);
    if (!place_S.valid()) {
      transfer_.lost.push_back({index, ring, std::move(reason)});
      return;
    }
    const Eigen::Vector3d p_S = positionOf(skin_.mesh(), place_S);
    const auto on_link =
        planes_S_ != nullptr ? planes_S_->project(place_S) : skin_.project(place_S);
    if (!on_link) {
      transfer_.lost.push_back(
          {index, ring,
           fmt::format("no link within {:.1f} mm of the skin", skin_.epsilon() * 1e3)});
      return;
    }
    Correspondence pair;
    pair.link = on_link->link;
    pair.p_L = on_link->p_L;
    pair.n_L = on_link->n_L;
    pair.p_O = point.p_O;
    pair.n_O = point.n_O;
    pair.weight = weight_;
    transfer_.correspondences.push_back(pair);
    transfer_.places_S.push_back(place_S);
    transfer_.points_S.push_back(p_S);
    if (folded || point.folded) ++transfer_.folded;
    Fidelity& fidelity = transfer_.fidelity;
    projection_sum_ += on_link->distance_m;
    fidelity.projection_mean_m =
        projection_sum_ / static_cast<double>(transfer_.correspondences.size());
    fidelity.projection_max_m = std::max(fidelity.projection_max_m, on_link->distance_m);
  }

 private:
  const hand::Skin& skin_;
  const hand::SkinPlanes* planes_S_;
  const Layer& layer_;
  double weight_;
  PatchTransfer& transfer_;
  double projection_sum_ = 0.0;
};

Fidelity shapeKept(const PatchChart& chart, const Layer& layer) {
  std::vector<std::vector<NetKnot>> rows;
  rows.emplace_back(chart.boundary().size(), layer.root());
  const auto append = [&](const std::vector<ChartPoint>& points) {
    std::vector<NetKnot>& row = rows.emplace_back();
    for (const ChartPoint& point : points)
      row.push_back(layer.knot(point));
  };
  for (const ChartRing& ring : chart.fidelityRings())
    append(ring.points);
  append(chart.boundary());
  return fidelityOf(rows);
}

}  // namespace

Surfaces borrowedSurfaces(const geometry::TriangleMesh& object_O, const hand::Skin& skin) {
  return {geometry::LogMapper::borrowing(object_O), geometry::LogMapper::borrowing(skin.mesh()),
          std::shared_ptr<const hand::Skin>(std::shared_ptr<void>(), &skin)};
}

PatchTransfer StagedTransfer::lay(const Surfaces& surfaces,
                                  const contact::Patch& patch,
                                  const PatchPlacement& placement,
                                  const TransferOptions& options,
                                  bool is_draft) {
  HANDGRAFT_REQUIRE(patch.direction_O.has_value());
  const hand::Skin& skin = *surfaces.skin;
  validate(options);
  validate(surfaces.object_O->mesh(), patch);
  validate(skin.mesh(), placement.root_S, "root on the skin");

  // === What changed since the last time
  std::shared_ptr<const PatchChart> chart = patch_chart_;
  if (!chart || !chart->answers(*surfaces.object_O, patch, options))
    chart = std::make_shared<const PatchChart>(surfaces.object_O, patch, options);
  const double direction_angle = chart->directionAngle(*patch.direction_O);
  const bool is_quick = is_draft && options.method == geometry::LogMapMethod::kAuto;
  const geometry::LogMapMethod method_S =
      is_quick ? geometry::LogMapMethod::kFast : options.method;
  std::shared_ptr<const SkinChart> skin_chart;
  if (is_quick && surfaces.drafts_S != nullptr)
    skin_chart = surfaces.drafts_S->about(placement.root_S, chart->reach());
  if (!skin_chart || !skin_chart->viewFrom(placement)) {
    skin_chart = skin_chart_;
    if (!skin_chart ||
        !skin_chart->answers(*surfaces.skin_S, placement, chart->reach(), method_S)) {
      skin_chart = std::make_shared<const SkinChart>(surfaces.skin_S, placement, chart->reach(),
                                                     method_S);
    }
  }

  // === Points
  PatchTransfer transfer;
  transfer.name = patch.name;
  transfer.method_O = chart->method();
  transfer.method_S = skin_chart->method();
  const Layer layer(skin, *chart, direction_angle, *skin_chart, placement);
  transfer.root_is_outside = !chart->surroundsRoot();
  transfer.is_draft = is_draft;
  if (!is_draft) transfer.fidelity = shapeKept(*chart, layer);
  Collector collector(skin, is_draft ? surfaces.planes_S.get() : nullptr, layer, patch.weight,
                      transfer);
  for (std::size_t i = 0; i < chart->boundary().size(); ++i)
    collector.add(chart->boundary()[i], static_cast<int>(i), 0);
  transfer.boundary_count = static_cast<int>(transfer.correspondences.size());
  for (std::size_t r = 0; r < chart->interiorRings().size(); ++r) {
    const std::vector<ChartPoint>& ring = chart->interiorRings()[r].points;
    for (std::size_t i = 0; i < ring.size(); ++i)
      collector.add(ring[i], static_cast<int>(i), static_cast<int>(r) + 1);
  }
  patch_chart_ = std::move(chart);
  skin_chart_ = std::move(skin_chart);
  return transfer;
}

}  // namespace handgraft::transfer
