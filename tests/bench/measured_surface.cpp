#include "tests/bench/measured_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <Eigen/Geometry>

#include "tests/bench/mesh_versions.h"

namespace handgraft::bench {

namespace {

using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kTie = 1e-9;         // of the way round: both ways are right, phi is neither
constexpr double kShake = 0.3;        // of an edge
constexpr double kStretch = 10.0;     // of an anisotropic cell
constexpr int kSides = 24;            // of prism and pyramid; even
constexpr double kPlaneSide = 1.0;    // m
constexpr double kPrismHeight = 3.0;  // m; its corners stand 1 m off the axis
constexpr double kSlant = 1.5;        // m; of the pyramid's ridges
constexpr double kConeSine = 0.6;     // of half the angle at its apex

// === Grids that become developable polyhedra

/// A grid of cells, each cut in two; places in cells, counter-clockwise faces.
struct Grid {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> places;
  std::vector<Eigen::Vector3i> faces;
};

/// `per_side`: columns of one flat side of what the grid is bent to (ridges at its multiples,
/// which vertices do not leave). `wrap` joins the right side to the left one. `apex_angle`: of
/// one cell about the apex, one vertex, that the lowest row is then; 0 where there is none.
Grid makeGrid(int columns,
              int rows,
              int per_side,
              bool wrap,
              double apex_angle,
              const std::string& version) {
  std::mt19937 random(7);
  Grid grid{columns, rows, {}, {}};
  const bool apex = apex_angle > 0.0;
  const int per_row = wrap ? columns : columns + 1;
  const auto vertex_at = [&](int column, int row) {
    if (wrap) column %= columns;
    return apex ? std::max(0, 1 + (row - 1) * per_row + column * (row > 0 ? 1 : 0))
                : row * per_row + column;
  };
  std::uniform_real_distribution<double> turn(0.0, 2.0 * kPi);
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column < (apex && row == 0 ? 1 : per_row); ++column) {
      Eigen::Vector2d place(column, row);
      const bool free_x = column % per_side != 0 && (wrap || (column > 0 && column < columns));
      const bool free_y = row > 0 && row < rows;
      if (version == "jittered") {
        // By a share of the cell's shorter side.
        const double angle = turn(random);
        const double aspect = apex ? apex_angle * row : 1.0;
        if (free_x) place.x() += kShake * std::min(1.0, 1.0 / aspect) * std::cos(angle);
        if (free_y) place.y() += kShake * std::min(1.0, aspect) * std::sin(angle);
      }
      if (version == "obtuse" && free_y && column % 2 == 1) place.y() += 0.5;
      grid.places.push_back(place);
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int a = vertex_at(column, row);
      const int b = vertex_at(column + 1, row);
      const int c = vertex_at(column + 1, row + 1);
      const int d = vertex_at(column, row + 1);
      // The longer diagonal of a slanted cell leaves two obtuse faces.
      const bool rising = version == "obtuse" ? column % 2 == 0 : (random() & 1U) != 0;
      if (a == b) {
        grid.faces.emplace_back(a, c, d);
      } else if (rising) {
        grid.faces.emplace_back(a, b, c);
        grid.faces.emplace_back(a, c, d);
      } else {
        grid.faces.emplace_back(a, b, d);
        grid.faces.emplace_back(b, c, d);
      }
    }
  }
  return grid;
}

/// Columns and rows of `vertex_count` cells that cover width x height, 1:1 or, if anisotropic,
/// 1:10; columns a multiple of `multiple`.
std::pair<int, int> cellsOf(
    int vertex_count, double width, double height, int multiple, const std::string& version) {
  const double stretch = version == "anisotropic" ? kStretch : 1.0;
  const double columns = std::sqrt(vertex_count * stretch * width / height);
  const int per_side = std::max(1, static_cast<int>(std::lround(columns / multiple)));
  const int rows =
      static_cast<int>(std::lround(static_cast<double>(vertex_count) / (per_side * multiple)));
  return {per_side * multiple, std::max(rows, 3)};
}

// === Polyhedra and their unrolled places

/// The plane an unrolled surface lies in.
enum class Chart {
  kPlane,
  kStrip,  ///< x comes round after `period` metres
  kSector  ///< (angle, distance from the apex); the angle comes round after `period` radians
};

struct Developable {
  TriangleMesh mesh;
  Chart chart = Chart::kPlane;
  double period = 0.0;
  std::vector<Eigen::Vector2d> flat;  ///< of every vertex

  [[nodiscard]] Eigen::Vector2d flatOf(const SurfacePoint& point) const {
    const Eigen::Vector3i face = mesh.face(point.face);
    if (chart == Chart::kSector) {
      // Any corner but the apex tells the angle about which the face is laid flat.
      const int first = flat[face[0]].y() > 0.0 ? 0 : 1;
      const double angle = flat[face[first]].x();
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (int corner = 0; corner < 3; ++corner) {
        const Eigen::Vector2d& p = flat[face[corner]];
        const double turn = std::remainder(p.x() - angle, period);
        sum +=
            point.barycentric[corner] * p.y() * Eigen::Vector2d(std::cos(turn), std::sin(turn));
      }
      return {angle + std::atan2(sum.y(), sum.x()), sum.norm()};
    }
    Eigen::Vector2d place = flat[face[0]];
    for (int corner = 1; corner < 3; ++corner)
      place += point.barycentric[corner] * difference(flat[face[corner]], flat[face[0]]);
    return place;
  }

  [[nodiscard]] Eigen::Vector2d difference(const Eigen::Vector2d& to,
                                           const Eigen::Vector2d& from) const {
    Eigen::Vector2d d = to - from;
    if (chart == Chart::kStrip) d.x() = std::remainder(d.x(), period);
    return d;
  }

  [[nodiscard]] PolarTruth truth(const SurfacePoint& source) const {
    const Eigen::Vector2d from = flatOf(source);
    PolarTruth truth{Eigen::VectorXd(mesh.vertexCount()), Eigen::VectorXd(mesh.vertexCount())};
    for (int v = 0; v < mesh.vertexCount(); ++v) {
      Eigen::Vector2d d;
      double turns = 0.0;  // of the way round
      if (chart == Chart::kSector) {
        const double turn = std::remainder(flat[v].x() - from.x(), period);
        // The angle runs clockwise about the apex, seen from the faces' outside.
        d = {flat[v].y() * std::cos(turn) - from.y(), -flat[v].y() * std::sin(turn)};
        if (flat[v].y() > 0.0) turns = std::abs(turn) / period;
      } else {
        d = difference(flat[v], from);
        if (chart == Chart::kStrip) turns = std::abs(d.x()) / period;
      }
      truth.r[v] = d.norm();
      truth.phi[v] = turns > 0.5 - kTie ? kNaN : std::atan2(d.y(), d.x());
    }
    return truth;
  }
};

TriangleMesh meshOf(const Eigen::Matrix3Xd& vertices,
                    const std::vector<Eigen::Vector3i>& faces) {
  Eigen::Matrix3Xi corners(3, static_cast<int>(faces.size()));
  for (std::size_t f = 0; f < faces.size(); ++f)
    corners.col(static_cast<int>(f)) = faces[f];
  return {vertices, corners};
}

using PlaceMap = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;
using BendMap = std::function<Eigen::Vector3d(const Eigen::Vector2d&)>;

Developable develop(const Grid& grid,
                    Chart chart,
                    double period,
                    const PlaceMap& flatten,
                    const BendMap& bend,
                    const std::string& version) {
  Developable sheet;
  sheet.chart = chart;
  sheet.period = period;
  Eigen::Matrix3Xd vertices(3, static_cast<int>(grid.places.size()));
  for (std::size_t v = 0; v < grid.places.size(); ++v) {
    sheet.flat.push_back(flatten(grid.places[v]));
    vertices.col(static_cast<int>(v)) = bend(grid.places[v]);
  }
  sheet.mesh = meshOf(vertices, grid.faces);
  if (version == "sliver") {
    std::mt19937 random(11);
    NeedledMesh needled = withNeedles(sheet.mesh, random);
    for (const SurfacePoint& point : needled.added)
      sheet.flat.push_back(sheet.flatOf(point));
    sheet.mesh = std::move(needled.mesh);
  }
  return sheet;
}

/// Side of the polyhedron at column x, and how far along it.
std::pair<int, double> sideAt(double x, int per_side) {
  const double side = x / per_side;
  const double first = std::floor(side);
  return {static_cast<int>(first), side - first};
}

MeasuredSurface measured(std::string surface,
                         const std::string& version,
                         const std::shared_ptr<const Developable>& sheet) {
  return {std::move(surface),
          version,
          sheet->mesh,
          [](const Eigen::Vector3d&) {
            return true;
          },
          [](const SurfacePoint&) {
            return std::numeric_limits<double>::infinity();
          },
          [sheet](const SurfacePoint& source) {
            return sheet->truth(source);
          }};
}

MeasuredSurface makePlane(int vertex_count, const std::string& version) {
  const auto [columns, rows] = cellsOf(vertex_count, kPlaneSide, kPlaneSide, 2, version);
  const Grid grid = makeGrid(columns, rows, columns, false, 0.0, version);
  const double width = kPlaneSide / columns;
  const double height = kPlaneSide / rows;
  const auto flatten = [=](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(p.x() * width, p.y() * height);
  };
  const auto bend = [=](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(p.x() * width, p.y() * height, 0.0);
  };
  return measured("plane", version,
                  std::make_shared<const Developable>(
                      develop(grid, Chart::kPlane, 0.0, flatten, bend, version)));
}

MeasuredSurface makePrism(int vertex_count, const std::string& version) {
  const double period = 2.0 * kSides * std::sin(kPi / kSides);
  const auto [columns, rows] = cellsOf(vertex_count, period, kPrismHeight, kSides, version);
  const int per_side = columns / kSides;
  const double height = kPrismHeight / rows;
  const auto ridge = [](int k) {
    const double angle = 2.0 * kPi * (k % kSides) / kSides;
    return Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  const auto flatten = [=, width = period / columns](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(p.x() * width, p.y() * height);
  };
  const auto bend = [=](const Eigen::Vector2d& p) {
    const auto [k, t] = sideAt(p.x(), per_side);
    const Eigen::Vector2d xy = (1.0 - t) * ridge(k) + t * ridge(k + 1);
    return Eigen::Vector3d(xy.x(), xy.y(), p.y() * height);
  };
  const Grid grid = makeGrid(columns, rows, per_side, true, 0.0, version);
  MeasuredSurface prism = measured("cylinder", version,
                                   std::make_shared<const Developable>(develop(
                                       grid, Chart::kStrip, period, flatten, bend, version)));
  prism.radius = [period](const SurfacePoint&) {
    return 0.4 * period;  // the cut locus begins at half of it
  };
  return prism;
}

/// `share`: radius of the disk over the source's distance from the apex, where the cut locus
/// begins.
MeasuredSurface makePyramid(int vertex_count,
                            const std::string& version,
                            std::string name,
                            double share) {
  const double side_angle = 2.0 * std::asin(kConeSine * std::sin(kPi / kSides));
  const double period = kSides * side_angle;
  const auto [columns, rows] =
      cellsOf(vertex_count, 0.5 * period * kSlant, kSlant, kSides, version);
  const int per_side = columns / kSides;
  const auto ridge = [](int k) {
    const double angle = 2.0 * kPi * (k % kSides) / kSides;
    return Eigen::Vector3d(kConeSine * std::cos(angle), kConeSine * std::sin(angle),
                           std::sqrt(1.0 - kConeSine * kConeSine));
  };
  const auto flatten = [=, columns = columns,
                        height = kSlant / rows](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(p.x() * period / columns, p.y() * height);
  };
  const auto bend = [=, height = kSlant / rows](const Eigen::Vector2d& p) {
    const auto [k, t] = sideAt(p.x(), per_side);
    const Eigen::Vector3d middle = (ridge(k) + ridge(k + 1)).normalized();
    const Eigen::Vector3d across = (ridge(k + 1) - ridge(k)).normalized();
    const double angle = (t - 0.5) * side_angle;
    return Eigen::Vector3d(p.y() * height *
                           (std::cos(angle) * middle + std::sin(angle) * across));
  };
  const Grid grid = makeGrid(columns, rows, per_side, true, period / columns, version);
  const auto sheet = std::make_shared<const Developable>(
      develop(grid, Chart::kSector, period, flatten, bend, version));
  MeasuredSurface pyramid = measured(std::move(name), version, sheet);
  pyramid.may_start = [](const Eigen::Vector3d& p) {
    return p.norm() > 0.4 * kSlant && p.norm() < 0.8 * kSlant;
  };
  pyramid.radius = [sheet, share](const SurfacePoint& source) {
    return share * positionOf(sheet->mesh, source).norm();
  };
  return pyramid;
}

// === The sphere

TriangleMesh onSphere(const TriangleMesh& mesh) {
  return {mesh.vertices().colwise().normalized(), mesh.faces()};
}

/// Cells of latitude and longitude, ten times as high as wide at the equator.
TriangleMesh makeGlobe(int vertex_count) {
  const int rows =
      std::max(4, static_cast<int>(std::lround(std::sqrt(vertex_count / (2.0 * kStretch)))));
  const int columns = static_cast<int>(2.0 * kStretch) * rows;
  Eigen::Matrix3Xd vertices(3, columns * (rows - 1) + 2);
  const auto south = static_cast<int>(vertices.cols()) - 2;
  const int north = south + 1;
  vertices.col(south) = -Eigen::Vector3d::UnitZ();
  vertices.col(north) = Eigen::Vector3d::UnitZ();
  std::vector<Eigen::Vector3i> faces;
  for (int row = 1; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double latitude = kPi * (static_cast<double>(row) / rows - 0.5);
      const double longitude = 2.0 * kPi * column / columns;
      const int a = (row - 1) * columns + column;
      const int b = (row - 1) * columns + (column + 1) % columns;
      vertices.col(a) << std::cos(latitude) * std::cos(longitude),
          std::cos(latitude) * std::sin(longitude), std::sin(latitude);
      if (row == 1) faces.emplace_back(south, b, a);
      if (row == rows - 1) {
        faces.emplace_back(a, b, north);
      } else {
        faces.emplace_back(a, b, b + columns);
        faces.emplace_back(a, b + columns, a + columns);
      }
    }
  }
  return meshOf(vertices, faces);
}

TriangleMesh jittered(const TriangleMesh& sphere) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> turn(0.0, 2.0 * kPi);
  Eigen::Matrix3Xd vertices = sphere.vertices();
  for (int v = 0; v < sphere.vertexCount(); ++v) {
    double edge = std::numeric_limits<double>::infinity();
    for (const int* h = sphere.outgoingBegin(v); h != sphere.outgoingEnd(v); ++h)
      edge = std::min(edge, (sphere.vertex(sphere.to(*h)) - sphere.vertex(v)).norm());
    const Eigen::Vector3d x = sphere.vertex(v).unitOrthogonal();
    const double angle = turn(random);
    vertices.col(v) +=
        kShake * edge * (std::cos(angle) * x + std::sin(angle) * sphere.vertex(v).cross(x));
  }
  return onSphere({vertices, sphere.faces()});
}

PolarTruth arcs(const TriangleMesh& sphere, const SurfacePoint& source) {
  const Eigen::Vector3d z = positionOf(sphere, source).normalized();
  const Eigen::Vector3d x = z.unitOrthogonal();
  const Eigen::Vector3d y = z.cross(x);
  PolarTruth truth{Eigen::VectorXd(sphere.vertexCount()),
                   Eigen::VectorXd(sphere.vertexCount())};
  for (int v = 0; v < sphere.vertexCount(); ++v) {
    const Eigen::Vector3d p = sphere.vertex(v);
    truth.r[v] = std::atan2(z.cross(p).norm(), z.dot(p));
    truth.phi[v] = std::atan2(y.dot(p), x.dot(p));
  }
  return truth;
}

MeasuredSurface makeSphere(int vertex_count, const std::string& version) {
  constexpr double kIcosahedron = 10.0;
  const int splits = std::clamp(
      static_cast<int>(std::lround(std::log(vertex_count / kIcosahedron) / std::log(4.0))), 1,
      8);
  TriangleMesh mesh = geometry::makeSphere(1.0, splits);
  std::mt19937 random(17);
  if (version == "sliver") mesh = onSphere(withNeedles(mesh, random).mesh);
  if (version == "anisotropic") mesh = makeGlobe(vertex_count);
  if (version == "jittered") mesh = jittered(mesh);
  if (version == "obtuse") mesh = flippedToObtuse(mesh);
  const auto shared = std::make_shared<const TriangleMesh>(mesh);
  return {"sphere",
          version,
          std::move(mesh),
          [version](const Eigen::Vector3d& p) {
            // A globe's cells are 1:10 at the equator alone.
            return version != "anisotropic" || std::abs(p.z()) < 0.5;
          },
          [](const SurfacePoint&) {
            return 0.2 * kPi;
          },
          [shared](const SurfacePoint& source) {
            return arcs(*shared, source);
          }};
}

}  // namespace

std::vector<MeasuredSurface> measuredSurfaces(int vertex_count) {
  std::vector<MeasuredSurface> surfaces;
  for (const std::string& version : mesh_versions)
    surfaces.push_back(makePlane(vertex_count, version));
  for (const std::string& version : mesh_versions)
    surfaces.push_back(makePrism(vertex_count, version));
  for (const std::string& version : mesh_versions)
    surfaces.push_back(makePyramid(vertex_count, version, "cone", 0.8));
  for (const std::string& version : mesh_versions)
    surfaces.push_back(makePyramid(vertex_count, version, "cone past its apex", 1.5));
  for (const std::string& version : mesh_versions)
    surfaces.push_back(makeSphere(vertex_count, version));
  return surfaces;
}

}  // namespace handgraft::bench
