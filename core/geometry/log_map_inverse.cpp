#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/index_map.h"
#include "core/geometry/log_map.h"

namespace handgraft::geometry {

namespace {

constexpr double kSlack = 1e-9;  // barycentric; as documented
// An edge this much longer in T than on the surface joins two sides of the cut locus.
constexpr double kMostStretch = 4.0;
// Sine between two edges in T below which a face covers nothing.
constexpr double kThinnest = 1e-12;
// Barycentric weights that cover one point of T from two faces without a shared place.
constexpr double kSamePlace = 1e-6;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Weights of the corners at `p`; the corners are counter-clockwise with area.
Eigen::Vector3d weightsAt(const Eigen::Matrix<double, 2, 3>& corners,
                          const Eigen::Vector2d& p) {
  const Eigen::Vector2d a = corners.col(0) - p;
  const Eigen::Vector2d b = corners.col(1) - p;
  const Eigen::Vector2d c = corners.col(2) - p;
  const Eigen::Vector3d areas(cross(b, c), cross(c, a), cross(a, b));
  return areas / areas.sum();
}

enum class Lie { kFlat, kStraddles, kTurnedOver, kNoArea, kUnknown };

/// How a face lies in the tangent plane.
Lie lieOf(const TriangleMesh& mesh, int f, const Eigen::Matrix<double, 2, 3>& corners_T) {
  if (!corners_T.allFinite()) return Lie::kUnknown;
  for (int c = 0; c < 3; ++c) {
    const int n = (c + 1) % 3;
    const double square =
        (mesh.vertex(mesh.faces()(n, f)) - mesh.vertex(mesh.faces()(c, f))).squaredNorm();
    if ((corners_T.col(n) - corners_T.col(c)).squaredNorm() >
        kMostStretch * kMostStretch * square) {
      return Lie::kStraddles;
    }
  }
  const Eigen::Vector2d ab = corners_T.col(1) - corners_T.col(0);
  const Eigen::Vector2d ac = corners_T.col(2) - corners_T.col(0);
  const double area = cross(ab, ac);
  const double thinnest = kThinnest * ab.norm() * ac.norm();
  if (area > thinnest) return Lie::kFlat;
  return area < -thinnest ? Lie::kTurnedOver : Lie::kNoArea;
}

Eigen::Matrix<double, 2, 3> cornersAt(const std::vector<Eigen::Vector2d>& places_T,
                                      const std::array<int, 3>& numbers) {
  Eigen::Matrix<double, 2, 3> corners_T;
  for (int c = 0; c < 3; ++c)
    corners_T.col(c) = places_T[static_cast<std::size_t>(numbers[static_cast<std::size_t>(c)])];
  return corners_T;
}

/// Log coordinates of faces' corners, computed once a vertex.
class Corners {
 public:
  Corners(const TriangleMesh& mesh, const LogMap& map, std::vector<Eigen::Vector2d>& places_T)
      : mesh_(mesh),
        map_(map),
        number_of_(static_cast<int>(map.vertices.size())),
        places_T_(places_T) {}

  /// Their numbers: places in `places_T`.
  std::array<int, 3> numbersOf(int f) {
    std::array<int, 3> numbers{};
    for (int c = 0; c < 3; ++c) {
      const int v = mesh_.faces()(c, f);
      const auto [number, is_new] = number_of_.add(v);
      if (is_new) places_T_.push_back(logCoordinatesAtVertex(map_, v));
      numbers[static_cast<std::size_t>(c)] = number;
    }
    return numbers;
  }

  Lie lieOf(int f) { return geometry::lieOf(mesh_, f, cornersAt(places_T_, numbersOf(f))); }

 private:
  const TriangleMesh& mesh_;
  const LogMap& map_;
  IndexMap number_of_;
  std::vector<Eigen::Vector2d>& places_T_;
};

/// Why ways end at the border to the face of `twin`; nothing where they go on.
std::optional<Unreachable> reasonBeyond(int twin, const IndexMap& covered, Corners& corners) {
  if (twin < 0) return Unreachable::kSurfaceEdge;
  const int beyond = TriangleMesh::faceOf(twin);
  if (covered.find(beyond) >= 0) return std::nullopt;
  const Lie lie = corners.lieOf(beyond);
  // A face without area in T leaves no gap: what lies behind it decides for itself.
  if (lie == Lie::kNoArea) return std::nullopt;
  return lie == Lie::kUnknown || lie == Lie::kFlat ? Unreachable::kBeyondRadius
                                                   : Unreachable::kCutLocus;
}

/// The cell out of `count` that holds `place`, in cells. Coordinates far outside fit no int,
/// and a grid without width makes NaN.
int cellAt(double place, int count) {
  if (!(place > 0.0)) return 0;
  return place < count ? static_cast<int>(place) : count - 1;
}

}  // namespace

std::string_view reasonOf(Unreachable reason) {
  switch (reason) {
    case Unreachable::kSurfaceEdge:
      return "edge of the surface";
    case Unreachable::kCutLocus:
      return "cut locus";
    case Unreachable::kBeyondRadius:
      return "beyond the disk";
  }
  throw BrokenContract("a reason that is not known");
}

LogMapInverse::LogMapInverse(const TriangleMesh& mesh, const LogMap& map)
    : radius_(map.radius) {
  HANDGRAFT_REQUIRE(map.r.size() == mesh.vertexCount());
  const std::size_t face_count = map.faces.size() + map.rim_faces.size();
  std::vector<Sheet> turned_over;
  sheets_.reserve(face_count);
  places_T_.reserve(map.vertices.size() + map.rim.size());
  Corners corners(mesh, map, places_T_);
  IndexMap covered(static_cast<int>(face_count));
  for (const std::vector<int>* faces : {&map.faces, &map.rim_faces}) {
    for (const int f : *faces) {
      const std::array<int, 3> numbers = corners.numbersOf(f);
      const Lie lie = lieOf(mesh, f, cornersAt(places_T_, numbers));
      if (lie == Lie::kTurnedOver) turned_over.push_back({f, numbers});
      if (lie != Lie::kFlat) continue;
      sheets_.push_back({f, numbers});
      covered.add(f);
    }
  }
  turned_over_ = sheets_.size();

  // === Borders: edges of a sheet without a sheet beyond
  for (const Sheet& sheet : sheets_) {
    for (int c = 0; c < 3; ++c) {
      const std::optional<Unreachable> reason =
          reasonBeyond(mesh.twin(3 * sheet.face + c), covered, corners);
      if (!reason) continue;
      borders_.push_back({sheet.corners[static_cast<std::size_t>(c)],
                          sheet.corners[static_cast<std::size_t>((c + 1) % 3)], *reason});
    }
  }
  sheets_.insert(sheets_.end(), turned_over.begin(), turned_over.end());
  buildGrid();
  places_T_.shrink_to_fit();
  sheets_.shrink_to_fit();
  borders_.shrink_to_fit();
}

Eigen::Matrix<double, 2, 3> LogMapInverse::cornersOf(const Sheet& sheet) const {
  return cornersAt(places_T_, sheet.corners);
}

std::optional<Eigen::Matrix<double, 2, 3>> LogMapInverse::cornersOf(int face) const {
  const auto end = sheets_.begin() + static_cast<std::ptrdiff_t>(turned_over_);
  const auto found = std::find_if(sheets_.begin(), end, [face](const Sheet& sheet) {
    return sheet.face == face;
  });
  if (found == end) return std::nullopt;
  return cornersOf(*found);
}

int LogMapInverse::columnOf(double x) const {
  return cellAt((x - low_T_.x()) / cell_size_.x(), columns_);
}

int LogMapInverse::rowOf(double y) const {
  return cellAt((y - low_T_.y()) / cell_size_.y(), rows_);
}

/// Row by row, the cells between the sheet's leftmost and rightmost place in that row: a long
/// thin face visits the cells along it, not those of its bounding box.
template <class Visit>
void LogMapInverse::forCellsOf(const Sheet& sheet, const Visit& visit) const {
  const Eigen::Matrix<double, 2, 3> p = cornersOf(sheet);
  // The slack at edges reaches a little out of the triangle.
  const double margin = 1e-6 * (p.rowwise().maxCoeff() - p.rowwise().minCoeff()).norm();
  const int first_row = rowOf(p.row(1).minCoeff() - margin);
  const int last_row = rowOf(p.row(1).maxCoeff() + margin);
  for (int row = first_row; row <= last_row; ++row) {
    // The first and last row also take what lies beyond them.
    const double low = row == 0 ? -std::numeric_limits<double>::infinity()
                                : low_T_.y() + row * cell_size_.y() - margin;
    const double high = row == rows_ - 1 ? std::numeric_limits<double>::infinity()
                                         : low_T_.y() + (row + 1) * cell_size_.y() + margin;
    double left = std::numeric_limits<double>::infinity();
    double right = -left;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector2d a = p.col(c);
      const Eigen::Vector2d b = p.col((c + 1) % 3);
      if (std::min(a.y(), b.y()) > high || std::max(a.y(), b.y()) < low) continue;
      const double rise = b.y() - a.y();
      double t_low = 0.0;
      double t_high = 1.0;
      if (rise != 0.0) {
        t_low = std::clamp((low - a.y()) / rise, 0.0, 1.0);
        t_high = std::clamp((high - a.y()) / rise, 0.0, 1.0);
      }
      for (const double t : {t_low, t_high}) {
        const double x = a.x() + t * (b.x() - a.x());
        left = std::min(left, x);
        right = std::max(right, x);
      }
    }
    if (left > right) continue;
    const int last_column = columnOf(right + margin);
    for (int column = columnOf(left - margin); column <= last_column; ++column) {
      visit(row * columns_ + column);
    }
  }
}

void LogMapInverse::buildGrid() {
  if (sheets_.empty()) return;
  low_T_.setConstant(std::numeric_limits<double>::infinity());
  high_T_ = -low_T_;
  for (const Sheet& sheet : sheets_) {
    const Eigen::Matrix<double, 2, 3> corners_T = cornersOf(sheet);
    low_T_ = low_T_.cwiseMin(corners_T.rowwise().minCoeff());
    high_T_ = high_T_.cwiseMax(corners_T.rowwise().maxCoeff());
  }
  // About a cell for every two faces, however stretched the disk.
  constexpr double kFacesPerCell = 2.0;
  constexpr double kMostCells = 2048.0;
  const Eigen::Vector2d extent = high_T_ - low_T_;
  const double side =
      std::sqrt(kFacesPerCell * extent.x() * extent.y() / static_cast<double>(sheets_.size()));
  const auto cells_along = [&](double length) {
    const double cells = std::ceil(length / side);
    return cells > 1.0 ? static_cast<int>(std::min(cells, kMostCells)) : 1;  // NaN: one
  };
  columns_ = cells_along(extent.x());
  rows_ = cells_along(extent.y());
  cell_size_ = {extent.x() / columns_, extent.y() / rows_};

  // Counted first, then filled in the order of the sheets.
  cell_offsets_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  std::vector<std::pair<int, int>> met;
  met.reserve(6 * sheets_.size());
  for (std::size_t s = 0; s < sheets_.size(); ++s) {
    forCellsOf(sheets_[s], [&](int cell) {
      met.emplace_back(cell, static_cast<int>(s));
      ++cell_offsets_[cell + 1];
    });
  }
  for (std::size_t c = 1; c < cell_offsets_.size(); ++c)
    cell_offsets_[c] += cell_offsets_[c - 1];
  cell_sheets_.resize(met.size());
  std::vector<int> cursor(cell_offsets_.begin(), cell_offsets_.end() - 1);
  for (const auto& [cell, sheet] : met)
    cell_sheets_[cursor[cell]++] = sheet;
}

LogMapInverse::Place LogMapInverse::at(const Eigen::Vector2d& uv_T) const {
  Place place;
  if (!uv_T.allFinite() || sheets_.empty()) return place;
  const double slack = kSlack * (high_T_ - low_T_).norm();
  const bool in_grid = (uv_T.array() >= low_T_.array() - slack).all() &&
                       (uv_T.array() <= high_T_.array() + slack).all();
  if (!in_grid || uv_T.norm() > radius_ * (1.0 + kSlack)) {
    place.reason = reasonAt(uv_T);
    return place;
  }

  const int cell = rowOf(uv_T.y()) * columns_ + columnOf(uv_T.x());
  double best_r = std::numeric_limits<double>::infinity();
  double best_margin = 0.0;
  int strictly_inside = 0;
  for (int i = cell_offsets_[cell]; i < cell_offsets_[cell + 1]; ++i) {
    const auto s = static_cast<std::size_t>(cell_sheets_[i]);
    const Eigen::Matrix<double, 2, 3> corners_T = cornersOf(sheets_[s]);
    const Eigen::Vector3d weights = weightsAt(corners_T, uv_T);
    const double margin = weights.minCoeff();
    if (!(margin >= -kSlack)) continue;
    if (margin > kSamePlace) ++strictly_inside;
    if (s >= turned_over_) continue;
    const Eigen::Vector3d r_of_corners = corners_T.colwise().norm().transpose();
    const double r = weights.dot(r_of_corners);
    // Faces that share the edge or vertex tie but for rounding: the one further inside wins.
    const bool tie = std::abs(r - best_r) <= kSlack * r;
    if (tie ? margin > best_margin : r < best_r) {
      best_r = r;
      best_margin = margin;
      const Eigen::Vector3d kept = weights.cwiseMax(0.0);
      place.point = {sheets_[s].face, kept / kept.sum()};
    }
  }
  place.folded = place.point.valid() && strictly_inside > 1;
  if (!place.point.valid()) place.reason = reasonAt(uv_T);
  return place;
}

Unreachable LogMapInverse::reasonAt(const Eigen::Vector2d& uv_T) const {
  Unreachable reason = Unreachable::kBeyondRadius;
  double last = -1.0;
  for (const Border& border : borders_) {
    // The way t * uv_T, 0 < t <= 1, leaves a counter-clockwise face where the border turns
    // left.
    const Eigen::Vector2d& from_T = places_T_[static_cast<std::size_t>(border.from)];
    const Eigen::Vector2d along = places_T_[static_cast<std::size_t>(border.to)] - from_T;
    const double turn = cross(uv_T, along);
    if (!(turn > 0.0)) continue;
    const double t = cross(from_T, along) / turn;
    const double s = cross(from_T, uv_T) / turn;
    if (t > last && t <= 1.0 + kSlack && s >= -kSlack && s <= 1.0 + kSlack) {
      last = t;
      reason = border.reason;
    }
  }
  return reason;
}

}  // namespace handgraft::geometry
