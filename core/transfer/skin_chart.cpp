#include "core/transfer/skin_chart.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/reference_axis.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMapMethod;
using geometry::LogMapper;

constexpr double kStepsPerDoubling = 8.0;  // a step is 9 % of reach
constexpr double kRounding = 1.0 + 1e-6;

/// The smallest step that holds `reach`; some disk where every point lies on the root.
double radiusFor(const LogMapper& skin_S, double reach) {
  if (!(reach > 0.0)) return skin_S.mesh().meanEdgeLength();
  return std::exp2(std::ceil(kStepsPerDoubling * std::log2(kRounding * reach)) /
                   kStepsPerDoubling);
}

}  // namespace

SkinChart::SkinChart(std::shared_ptr<const LogMapper> skin_S,
                     const PatchPlacement& placement,
                     double reach,
                     LogMapMethod method)
    : skin_S_(std::move(skin_S)),
      root_S_(placement.root_S),
      axis_S_(
          geometry::referenceAxis(skin_S_->mesh(), root_S_, placement.direction_S).direction),
      radius_(radiusFor(*skin_S_, reach)),
      asked_(method) {
  const geometry::LogMap map = skin_S_->map(root_S_, axis_S_, radius_, asked_);
  method_ = map.method;
  inverse_.emplace(skin_S_->mesh(), map);
}

bool SkinChart::answers(const LogMapper& skin_S,
                        const PatchPlacement& placement,
                        double reach,
                        LogMapMethod method) const {
  return &skin_S.mesh() == &skin_S_->mesh() && method == asked_ &&
         placement.root_S.face == root_S_.face &&
         placement.root_S.barycentric == root_S_.barycentric &&
         radiusFor(skin_S, reach) == radius_ &&
         geometry::referenceAxis(skin_S.mesh(), root_S_, placement.direction_S).direction ==
             axis_S_;
}

std::optional<SkinChart::View> SkinChart::viewFrom(const PatchPlacement& placement) const {
  const geometry::TriangleMesh& mesh_S = skin_S_->mesh();
  const geometry::SurfacePoint& root_S = placement.root_S;
  if (root_S.face == root_S_.face && root_S.barycentric == root_S_.barycentric) {
    return View{Eigen::Vector2d::Zero(),
                geometry::referenceAxis(mesh_S, root_S_, placement.direction_S).angle};
  }
  const auto corners_T = inverse_->cornersOf(root_S.face);
  if (!corners_T) return std::nullopt;
  // The face's two sides on the surface and in the chart tell how a tangent lies there.
  const Eigen::Vector3i face = mesh_S.face(root_S.face);
  Eigen::Matrix<double, 3, 2> sides_S;
  Eigen::Matrix2d sides_T;
  for (int k = 0; k < 2; ++k) {
    sides_S.col(k) = mesh_S.vertex(face[k + 1]) - mesh_S.vertex(face[0]);
    sides_T.col(k) = corners_T->col(k + 1) - corners_T->col(0);
  }
  const Eigen::Matrix2d gram = sides_S.transpose() * sides_S;
  const Eigen::Vector2d along_T =
      sides_T * gram.ldlt().solve(sides_S.transpose() * placement.direction_S);
  return View{*corners_T * root_S.barycentric, std::atan2(along_T.y(), along_T.x())};
}

}  // namespace handgraft::transfer
