#include "core/contact/reproject.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"

namespace handgraft::contact {
namespace {

using geometry::SurfaceLocator;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

/// Beyond this two meshes of one object are not what makes the difference: m. Scans that were
/// thinned out lie less than 1 mm apart.
constexpr double kNotableGap = 2e-3;

// Of a map's own mesh: scans of one object by two cameras lie 1 to 2 mm apart.
constexpr double kOtherShapeGap = 4e-3;  // m
constexpr double kOtherShapeShare = 0.05;
constexpr int kVerticesLookedAt = 1000;

/// What is to be said of patches whose roots lie so far off the surface, m; changes the order.
std::optional<std::string> noteOnGaps(std::vector<double>& gaps) {
  if (gaps.empty()) return std::nullopt;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  if (*middle <= kNotableGap) return std::nullopt;
  return fmt::format(
      "the contacts lie {:.1f} mm off the object's surface in the median; they were made on "
      "another object, or in another place of it",
      *middle * 1e3);
}

/// Places of `from` on `to`.
class Carrier {
 public:
  Carrier(const TriangleMesh& from, const TriangleMesh& to, double reach_m)
      : from_(from), to_(to), reach_m_(reach_m) {
    for (const Eigen::Vector3d p : to.vertices().colwise())
      box_.extend(p);
  }

  [[nodiscard]] std::optional<SurfacePoint> operator()(const SurfacePoint& point) const {
    const Eigen::Vector3d p = geometry::positionOf(from_, point);
    // Seen from afar, all faces are equally near, and the search would visit every one.
    if (!(box_.squaredExteriorDistance(p) <= reach_m_ * reach_m_)) return std::nullopt;
    const Eigen::Vector3d n = geometry::normalOf(from_, point);
    // Where walls are thin, the nearest place may be on their other side: then look from a
    // little outside.
    for (const double height : {0.0, 0.5 * reach_m_, reach_m_}) {
      const SurfaceLocator::Hit hit = to_.nearest(p + height * n);
      const bool faces_the_same_way = geometry::normalOf(to_.mesh(), hit.point).dot(n) > 0.0;
      if (faces_the_same_way && (hit.position - p).norm() <= reach_m_) return hit.point;
    }
    return std::nullopt;
  }

 private:
  const TriangleMesh& from_;
  SurfaceLocator to_;
  double reach_m_;
  Eigen::AlignedBox3d box_;  ///< of the mesh that is carried to
};

}  // namespace

ContactSet reproject(const ContactSet& set,
                     const TriangleMesh& from_O,
                     const TriangleMesh& to_O,
                     double reach_m) {
  if (!(reach_m > 0.0)) rejectInput("reach is {} m; it must be above 0", reach_m);
  const Carrier carried(from_O, to_O, reach_m);
  ContactSet result = set;
  result.patches.clear();
  std::vector<double> gaps;  // of roots
  for (const Patch& patch : set.patches) {
    Patch moved = patch;
    moved.boundary.clear();
    moved.interpolation_boundary.clear();
    for (const SurfacePoint& point : patch.interpolation_boundary) {
      if (const auto place = carried(point)) moved.interpolation_boundary.push_back(*place);
    }
    const auto root = carried(patch.root);
    const std::size_t kept = moved.interpolation_boundary.size();
    if (!root || kept < kFewestInterpolationPoints ||
        2 * kept < patch.interpolation_boundary.size()) {
      result.notes.push_back(fmt::format(
          "{} dropped: no place within {:.1f} mm of the object's surface faces the same way",
          quoted(patch.name), reach_m * 1e3));
      continue;
    }
    if (kept < patch.interpolation_boundary.size()) {
      result.notes.push_back(fmt::format(
          "{}: {} of {} points left out: no place within {:.1f} mm that faces the same way",
          quoted(patch.name), patch.interpolation_boundary.size() - kept,
          patch.interpolation_boundary.size(), reach_m * 1e3));
    }
    moved.root = *root;
    gaps.push_back(
        (geometry::positionOf(to_O, *root) - geometry::positionOf(from_O, patch.root)).norm());
    result.patches.push_back(std::move(moved));
  }
  if (2 * result.patches.size() < set.patches.size() || result.patches.empty()) {
    rejectInput(
        "contacts do not fit the object: {} of {} patches have no place within {:.1f} mm of "
        "its "
        "surface that faces the same way; is it another object, another frame, or inside out?",
        set.patches.size() - result.patches.size(), set.patches.size(), reach_m * 1e3);
  }
  if (auto note = noteOnGaps(gaps)) result.notes.push_back(std::move(*note));
  return result;
}

std::optional<std::string> noteOnOtherShape(const TriangleMesh& map_O,
                                            const TriangleMesh& object_O) {
  const SurfaceLocator object(object_O);
  const int step = 1 + map_O.vertexCount() / kVerticesLookedAt;
  int looked_at = 0;
  int off = 0;
  for (int v = 0; v < map_O.vertexCount(); v += step) {
    ++looked_at;
    off += object.nearest(map_O.vertex(v), kOtherShapeGap) ? 0 : 1;
  }
  if (off < kOtherShapeShare * looked_at || off == 0) return std::nullopt;
  return fmt::format(
      "{:.0f} % of the map's own mesh lie more than {:.0f} mm off the object's surface; "
      "the map is of another object, or in another place of it",
      100.0 * off / looked_at, kOtherShapeGap * 1e3);
}

}  // namespace handgraft::contact
