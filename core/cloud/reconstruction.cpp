#include "core/cloud/reconstruction.h"

// Tells CGAL's headers that Eigen is there.
#define CGAL_EIGEN3_ENABLED

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_with_circumcenter_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Poisson_reconstruction_function.h>
#include <CGAL/Random.h>
#include <CGAL/Robust_circumcenter_traits_3.h>
#include <CGAL/Surface_mesh_cell_base_3.h>
#include <CGAL/Surface_mesh_complex_2_in_triangulation_3.h>
#include <CGAL/Surface_mesh_vertex_base_3.h>
#include <CGAL/Triangulation_data_structure_3.h>
#include <CGAL/jet_estimate_normals.h>
#include <CGAL/make_surface_mesh.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/property_map.h>

#include "core/base/error.h"
#include "core/cloud/triangle_soup.h"
#include "core/geometry/kd_tree.h"

namespace handgraft::cloud {

namespace {

using geometry::KdTree;
using geometry::TriangleMesh;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;

struct OrientedPoint {
  Point point;
  Vector normal;
  Eigen::Index index = 0;

  bool operator==(const OrientedPoint& other) const { return index == other.index; }
};

// NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
struct PointMap {
  using key_type = OrientedPoint;
  using value_type = Point;
  using reference = const Point&;
  using category = boost::lvalue_property_map_tag;

  friend reference get(PointMap, const OrientedPoint& p) { return p.point; }
};

struct NormalMap {
  using key_type = OrientedPoint;
  using value_type = Vector;
  using reference = const Vector&;
  using category = boost::lvalue_property_map_tag;

  friend reference get(NormalMap, const OrientedPoint& p) { return p.normal; }

  friend void put(NormalMap, OrientedPoint& p, const Vector& normal) { p.normal = normal; }
};

// NOLINTEND(readability-identifier-naming)

Point pointFrom(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

Eigen::Vector3d vectorFrom(const Vector& v) {
  return {v.x(), v.y(), v.z()};
}

// === The same bytes for the same points

/// CGAL's own generator starts with the time of day: without this every run looks elsewhere
/// first.
void makeRepeatable() {
  CGAL::get_default_random() = CGAL::Random(0);
}

/// A vertex or cell that knows its turn. CGAL keeps sets of handles and orders them by address,
/// unless there is such a stamp: the order in which elements came to be.
template <class Base>
struct Stamped : Base {
  using Base::Base;
  // NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
  using Has_timestamp = CGAL::Tag_true;

  template <class Structure>
  struct Rebind_TDS {
    using Other = Stamped<typename Base::template Rebind_TDS<Structure>::Other>;
  };

  // NOLINTEND(readability-identifier-naming)

  Stamped() = default;

  // A copy is another element.
  Stamped(const Stamped& other) : Base(other) {}

  Stamped& operator=(const Stamped& other) {
    Base::operator=(other);
    return *this;
  }

  // NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
  [[nodiscard]] std::size_t time_stamp() const { return stamp; }

  void set_time_stamp(std::size_t value) { stamp = value; }

  // NOLINTEND(readability-identifier-naming)

  std::size_t stamp = std::numeric_limits<std::size_t>::max();  // CGAL's word for none
};

// === Poisson

/// Points through which no smooth surface goes are refined without end, and with them memory
/// grows: a surface that is there takes about a hundredth of this.
constexpr long kFewestSteps = 500'000;
constexpr long kStepsPerPoint = 500;

/// Lets a wish to stop, and the end of what a cloud may cost, into the refinement.
struct Budget {
  struct Spent {};

  const Progress* progress;
  long steps_left;

  void step() {
    progress->checkpoint();
    if (--steps_left < 0) throw Spent();
  }
};

struct Checkpoint {
  Budget* budget;

  // NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
  void before_insertion() const { budget->step(); }

  // NOLINTEND(readability-identifier-naming)
};

using Poisson = CGAL::Poisson_reconstruction_function<Kernel>;

struct Field {
  const Poisson* function;
  Budget* budget;

  Kernel::FT operator()(const Point& p) const {
    budget->step();
    return (*function)(p);
  }
};

using SurfaceTraits = CGAL::Robust_circumcenter_traits_3<Kernel>;
using SurfaceTriangulation = CGAL::Delaunay_triangulation_3<
    SurfaceTraits,
    CGAL::Triangulation_data_structure_3<
        Stamped<CGAL::Surface_mesh_vertex_base_3<SurfaceTraits>>,
        Stamped<CGAL::Delaunay_triangulation_cell_base_with_circumcenter_3<
            SurfaceTraits,
            CGAL::Surface_mesh_cell_base_3<SurfaceTraits>>>>>;
using SurfaceComplex = CGAL::Surface_mesh_complex_2_in_triangulation_3<SurfaceTriangulation>;

/// The facets of a complex, those of each component agreeing.
TriangleMesh meshOf(const SurfaceComplex& complex) {
  const SurfaceTriangulation& cells = complex.triangulation();
  std::vector<Eigen::Vector3d> vertices;
  std::unordered_map<SurfaceTriangulation::Vertex_handle, int> index_of;
  Triangles triangles;
  for (auto facet = cells.finite_facets_begin(); facet != cells.finite_facets_end(); ++facet) {
    if (!facet->first->is_facet_on_surface(facet->second)) continue;
    std::array<int, 3> triangle{};
    for (int c = 0; c < 3; ++c) {
      const auto vertex =
          facet->first->vertex(SurfaceTriangulation::vertex_triple_index(facet->second, c));
      const auto [known, is_new] = index_of.emplace(vertex, static_cast<int>(vertices.size()));
      if (is_new) {
        const auto& p = vertex->point();
        vertices.emplace_back(p.x(), p.y(), p.z());
      }
      triangle[c] = known->second;
    }
    triangles.push_back(triangle);
  }
  return orientedMesh(vertices, std::move(triangles));
}

// === Advancing front

/// Numbers addresses in the order in which they are first asked for.
class TurnOfAddress {
 public:
  std::size_t of(const void* address) {
    return turns_.emplace(address, turns_.size()).first->second;
  }

 private:
  std::unordered_map<const void*, std::size_t> turns_;
};

/// Of the reconstruction that this thread makes; CGAL's front has no room for it.
thread_local TurnOfAddress* turn_of_edge = nullptr;

/// The front takes the edge whose triangle has the smallest radius. The two edges that share a
/// candidate tie, which CGAL breaks by address, and this by turn.
template <class Base>
struct FrontVertex : Base {
  using Base::Base;

  // NOLINTBEGIN(readability-identifier-naming): names that CGAL asks for
  template <class Structure>
  struct Rebind_TDS {
    using Other = FrontVertex<typename Base::template Rebind_TDS<Structure>::Other>;
  };

  struct Radius_ptr_type : std::pair<typename Base::criteria, typename Base::IO_edge_type*> {
    Radius_ptr_type(typename Base::criteria radius, typename Base::IO_edge_type* edge)
        : std::pair<typename Base::criteria, typename Base::IO_edge_type*>(radius, edge),
          turn(turn_of_edge->of(edge)) {}

    bool operator<(const Radius_ptr_type& other) const {
      return std::tie(this->first, turn) < std::tie(other.first, other.turn);
    }

    std::size_t turn;
  };

  // NOLINTEND(readability-identifier-naming)
};

using FrontTriangulation = CGAL::Delaunay_triangulation_3<
    Kernel,
    CGAL::Triangulation_data_structure_3<
        FrontVertex<
            Stamped<CGAL::Advancing_front_surface_reconstruction_vertex_base_3<Kernel>>>,
        Stamped<CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>>>>;

/// CGAL's priority, the radius of the smallest empty sphere, for triangles that are small
/// enough.
struct ShortEdgesFirst {
  double longest_edge_squared;
  const Progress* progress;

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    progress->checkpoint();
    for (int c = 0; c < 3; ++c) {
      const auto& a = cell->vertex((index + 1 + c) % 4)->point();
      const auto& b = cell->vertex((index + 1 + (c + 1) % 3) % 4)->point();
      // The front's own word for "never".
      if (CGAL::squared_distance(a, b) > longest_edge_squared) return front.infinity();
    }
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

}  // namespace

Eigen::Matrix3Xd estimateNormals(const Eigen::Matrix3Xd& points,
                                 int neighbours,
                                 const Progress& progress) {
  HANDGRAFT_REQUIRE(neighbours >= 6 && neighbours < points.cols());
  std::vector<OrientedPoint> cloud;
  cloud.reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cloud.push_back({pointFrom(points.col(i)), CGAL::NULL_VECTOR, i});
  const auto callback = [&](double) {
    progress.checkpoint();
    return true;
  };
  const auto maps = CGAL::parameters::point_map(PointMap()).normal_map(NormalMap());
  CGAL::jet_estimate_normals<CGAL::Sequential_tag>(cloud, static_cast<unsigned>(neighbours),
                                                   maps.callback(callback));
  progress.checkpoint();
  const auto first_unturned =
      CGAL::mst_orient_normals(cloud, static_cast<unsigned>(neighbours), maps);
  progress.checkpoint();

  // Points that no chain of neighbours reached follow the nearest one that was.
  const Eigen::Index turned_count = std::distance(cloud.begin(), first_unturned);
  HANDGRAFT_REQUIRE(turned_count > 0);
  if (turned_count < points.cols()) {
    Eigen::Matrix3Xd turned(3, turned_count);
    for (Eigen::Index i = 0; i < turned_count; ++i)
      turned.col(i) = points.col(cloud[static_cast<std::size_t>(i)].index);
    const KdTree tree(std::move(turned));
    for (auto p = first_unturned; p != cloud.end(); ++p) {
      const Vector& near = cloud[tree.nearest(points.col(p->index)).index].normal;
      if (near * p->normal < 0.0) p->normal = -p->normal;
    }
  }
  Eigen::Matrix3Xd normals(3, points.cols());
  for (const OrientedPoint& p : cloud)
    normals.col(p.index) = vectorFrom(p.normal);
  return normals;
}

TriangleMesh poissonSurface(const Eigen::Matrix3Xd& points,
                            const Eigen::Matrix3Xd& normals,
                            double spacing,
                            double edge,
                            const Progress& progress) {
  HANDGRAFT_REQUIRE(points.cols() == normals.cols() && spacing > 0.0 && edge > 0.0);
  makeRepeatable();
  Budget budget{&progress, kFewestSteps + kStepsPerPoint * static_cast<long>(points.cols())};
  std::vector<OrientedPoint> cloud;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d n = normals.col(i);
    cloud.push_back({pointFrom(points.col(i)), Vector(n.x(), n.y(), n.z()), i});
  }
  using Matrix = CGAL::Eigen_sparse_symmetric_matrix<double>::EigenType;
  using Solver = CGAL::Eigen_solver_traits<Eigen::ConjugateGradient<Matrix>>;
  Poisson function(cloud.begin(), cloud.end(), PointMap(), NormalMap());
  progress.checkpoint();
  try {
    if (!function.compute_implicit_function(Solver(), Checkpoint{&budget})) return {};
  } catch (const Budget::Spent&) {
    return {};
  }

  // The mesher looks along segments that end on a sphere around the whole.
  const Point inside = function.get_inner_point();
  const double radius = 5.0 * std::sqrt(function.bounding_sphere().squared_radius());
  constexpr double kSmallestAngleDeg = 20.0;    // CGAL's recommendation: below 30
  constexpr double kDistanceOfSpacing = 0.1;    // facet to surface, in spacings
  constexpr double kDichotomyOfSpacing = 1e-3;  // vertex to surface, in spacings
  const CGAL::Implicit_surface_3<Kernel, Field> surface(
      Field{&function, &budget}, Kernel::Sphere_3(inside, radius * radius),
      kDichotomyOfSpacing * spacing / radius);
  // A Delaunay facet of circumradius r has edges of about r times the square root of 3, of
  // which meshing to the bound leaves three quarters.
  const CGAL::Surface_mesh_default_criteria_3<SurfaceTriangulation> criteria(
      kSmallestAngleDeg, edge / 1.3, kDistanceOfSpacing * spacing);
  SurfaceTriangulation triangulation;
  SurfaceComplex complex(triangulation);
  try {
    CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag());
  } catch (const Budget::Spent&) {
    return {};
  }
  progress.checkpoint();
  return meshOf(complex);
}

TriangleMesh advancingFrontSurface(const Eigen::Matrix3Xd& points,
                                   double longest_edge,
                                   const Progress& progress) {
  HANDGRAFT_REQUIRE(longest_edge > 0.0);
  makeRepeatable();
  std::vector<std::pair<Point, std::size_t>> cloud;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cloud.emplace_back(pointFrom(points.col(i)), static_cast<std::size_t>(i));
  FrontTriangulation triangulation(cloud.begin(), cloud.end());
  progress.checkpoint();
  TurnOfAddress turns;
  turn_of_edge = &turns;
  CGAL::Advancing_front_surface_reconstruction<FrontTriangulation, ShortEdgesFirst> front(
      triangulation, ShortEdgesFirst{longest_edge * longest_edge, &progress});
  front.run();
  std::vector<std::array<std::size_t, 3>> triples;
  CGAL::write_triple_indices(std::back_inserter(triples), front);
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(triples.size()));
  for (std::size_t t = 0; t < triples.size(); ++t)
    for (int c = 0; c < 3; ++c)
      faces(c, static_cast<Eigen::Index>(t)) = static_cast<int>(triples[t][c]);
  return {points, std::move(faces)};
}

}  // namespace handgraft::cloud
