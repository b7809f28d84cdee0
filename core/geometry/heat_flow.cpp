#include "core/geometry/heat_flow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "core/base/error.h"
#include "core/geometry/sparse_factor.h"

namespace handgraft::geometry {

namespace {

using Complex = std::complex<double>;
using RealMatrix = Eigen::SparseMatrix<double>;
using ComplexMatrix = Eigen::SparseMatrix<Complex>;

// Heat below this is too near to double's smallest number to keep its digits.
constexpr double kLeastHeat = 1e-280;
// Mean edges beyond a disk from where heat still counts. It fades by about e per edge and has
// to go there and back: 1e-11 of the radius (seen: 1e-12) is left out.
constexpr double kHeatReach = 10.0;

Complex normalised(const Complex& z) {
  const double size = std::abs(z);
  return size > 0.0 ? z / size : Complex(0.0);
}

Eigen::Matrix2Xd columnsOf(const Eigen::VectorXcd& p, double scale) {
  Eigen::Matrix2Xd columns(2, p.size());
  columns.row(0) = scale * p.real().transpose();
  columns.row(1) = scale * p.imag().transpose();
  return columns;
}

}  // namespace

/// Directions and lengths of one edge, seen from both ends.
struct HeatFlow::Edge {
  int a = -1;
  int b = -1;
  Complex from_a;  ///< unit, in a's basis, towards b
  Complex from_b;  ///< unit, in b's basis, towards a
  double length = 0.0;
  /// Half the cotangents opposite; `conductance` is without the negative ones that obtuse
  /// triangles leave on the surface's edge. Diffusion with it keeps every sign, and planes stay
  /// exact with any symmetric weights.
  double cotan = 0.0;
  double conductance = 0.0;

  /// Turns a vector at b into a's basis.
  [[nodiscard]] Complex fromBToA() const { return -from_a * std::conj(from_b); }
};

struct HeatFlow::Factors {
  SparseFactor<double> scalar;
  SparseFactor<Complex> connection;
  // The Poisson system serves the vector heat method alone, and is factored on its first call.
  std::once_flag poisson_once;
  SparseFactor<double> poisson;
  bool has_poisson = false;

  void factorPoisson(int vertex_count, const std::vector<Edge>& edges);
};

HeatFlow::HeatFlow(const TriangleMesh& mesh)
    : mesh_(mesh), surface_(mesh), factors_(std::make_unique<Factors>()) {
  double length_sum = 0.0;
  for (int h = 0; h < surface_.halfedgeCount(); ++h) {
    if (!surface_.isFirstOfEdge(h)) continue;
    const double cotan = surface_.cotanWeight(h);
    edges_.push_back({surface_.from(h), surface_.to(h), surface_.direction(h),
                      surface_.directionBack(h), surface_.length(h), cotan,
                      std::max(cotan, 0.0)});
    length_sum += edges_.back().length;
  }
  unit_length_ = length_sum / static_cast<double>(edges_.size());
  for (Edge& edge : edges_)
    edge.length /= unit_length_;

  // === M + t L, with t = 1 in units of the mean edge
  const int n = surface_.vertexCount();
  std::vector<Eigen::Triplet<double>> real;
  std::vector<Eigen::Triplet<Complex>> complex;
  real.reserve(static_cast<std::size_t>(n) + 3 * edges_.size());
  complex.reserve(real.capacity());
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  for (int f = 0; f < surface_.faceCount(); ++f) {
    const double mass = surface_.area(f) / (3.0 * unit_length_ * unit_length_);
    for (int h = 3 * f; h < 3 * f + 3; ++h)
      diagonal[surface_.from(h)] += mass;
  }
  for (const Edge& edge : edges_) {
    diagonal[edge.a] += edge.conductance;
    diagonal[edge.b] += edge.conductance;
    // Lower triangle; an edge from a vertex to itself counts in both directions.
    const Complex turned = -edge.conductance * edge.fromBToA();
    if (edge.a == edge.b) {
      real.emplace_back(edge.a, edge.a, -2.0 * edge.conductance);
      complex.emplace_back(edge.a, edge.a, 2.0 * turned.real());
    } else {
      const bool a_below = edge.a > edge.b;
      real.emplace_back(std::max(edge.a, edge.b), std::min(edge.a, edge.b), -edge.conductance);
      complex.emplace_back(std::max(edge.a, edge.b), std::min(edge.a, edge.b),
                           a_below ? turned : std::conj(turned));
    }
  }
  for (int v = 0; v < n; ++v) {
    real.emplace_back(v, v, diagonal[v]);
    complex.emplace_back(v, v, diagonal[v]);
  }
  RealMatrix scalar(n, n);
  scalar.setFromTriplets(real.begin(), real.end());
  ComplexMatrix connection(n, n);
  connection.setFromTriplets(complex.begin(), complex.end());
  if (!factors_->scalar.factor(scalar) || !factors_->connection.factor(connection)) {
    rejectInput(
        "the heat operators of a mesh of {} vertices cannot be factored; its faces are too "
        "thin, remesh it or use another log map method",
        n);
  }
}

HeatFlow::~HeatFlow() = default;

/// Corners of all faces that a ball about `origin` may reach into.
std::vector<char> HeatFlow::verticesNear(const Eigen::Vector3d& origin, double radius) const {
  const int n = surface_.vertexCount();
  if (std::isinf(radius)) return std::vector<char>(static_cast<std::size_t>(n), 1);
  const Eigen::VectorXd distances =
      (mesh_.vertices().colwise() - origin).colwise().norm().transpose();
  std::vector<char> near(static_cast<std::size_t>(n), 0);
  for (int f = 0; f < mesh_.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh_.face(f);
    const double least = std::min({distances[face[0]], distances[face[1]], distances[face[2]]});
    double longest = 0.0;
    if (least > radius) {
      for (int c = 0; c < 3; ++c) {
        longest =
            std::max(longest, (mesh_.vertex(face[c]) - mesh_.vertex(face[(c + 1) % 3])).norm());
      }
    }
    if (least - longest > radius) continue;
    for (const int v : face)
      near[v] = 1;
  }
  return near;
}

Eigen::VectorXcd HeatFlow::parallelField(const std::vector<HeatSeed>& seeds,
                                         const std::vector<char>& wanted) const {
  Eigen::VectorXcd field = Eigen::VectorXcd::Zero(surface_.vertexCount());
  for (const HeatSeed& seed : seeds)
    field[seed.vertex] += seed.weight * seed.axis;
  return factors_->connection.solve(field, wanted).unaryExpr(&normalised);
}

Eigen::Matrix2Xd HeatFlow::affineLog(const std::vector<HeatSeed>& seeds,
                                     const Eigen::Vector3d& origin,
                                     double radius) const {
  const int n = surface_.vertexCount();
  Eigen::VectorXd w = Eigen::VectorXd::Zero(n);
  Eigen::VectorXcd u = Eigen::VectorXcd::Zero(n);
  for (const HeatSeed& seed : seeds) {
    w[seed.vertex] += seed.weight;
    u[seed.vertex] += seed.weight * seed.axis * seed.p_T / unit_length_;
  }
  // No geodesic is shorter than the straight line: the disk lies in a ball.
  const std::vector<char> wanted = verticesNear(origin, radius);
  const std::vector<char> felt = verticesNear(origin, radius + kHeatReach * unit_length_);
  w = factors_->scalar.solve(w, felt);

  // Heat that crosses an edge carries where it came from: the edge itself, backwards.
  for (const Edge& edge : edges_) {
    const double carried = edge.conductance * edge.length;
    u[edge.a] -= carried * w[edge.b] * edge.from_a;
    u[edge.b] -= carried * w[edge.a] * edge.from_b;
  }
  u = factors_->connection.solve(u, wanted);
  const Eigen::VectorXcd axes = parallelField(seeds, wanted);

  Eigen::VectorXcd p(n);
  for (int v = 0; v < n; ++v) {
    // Dividing by zero, or by heat without digits, is no place.
    p[v] = wanted[v] && w[v] > kLeastHeat ? u[v] / w[v] / axes[v]
                                          : Complex(std::numeric_limits<double>::quiet_NaN());
  }
  return columnsOf(p, unit_length_);
}

void HeatFlow::Factors::factorPoisson(int vertex_count, const std::vector<Edge>& edges) {
  // Distances are known up to a constant: the last vertex is pinned to zero.
  const int n = vertex_count - 1;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * edges.size());
  for (const Edge& edge : edges) {
    if (edge.a == edge.b) continue;
    for (const int v : {edge.a, edge.b}) {
      if (v < n) entries.emplace_back(v, v, edge.cotan);
    }
    if (std::max(edge.a, edge.b) < n) {
      entries.emplace_back(std::max(edge.a, edge.b), std::min(edge.a, edge.b), -edge.cotan);
    }
  }
  RealMatrix laplacian(n, n);
  laplacian.setFromTriplets(entries.begin(), entries.end());
  has_poisson = poisson.factor(laplacian);
}

Eigen::VectorXcd HeatFlow::vectorLogFrom(const HeatSeed& seed) const {
  const int n = surface_.vertexCount();
  const int source = seed.vertex;
  Eigen::VectorXcd radial = Eigen::VectorXcd::Zero(n);
  for (const Edge& edge : edges_) {
    // Edges outward from the source, as the heat crosses them: their sum vanishes where the
    // surface is flat, so that no direction is favoured.
    const double crossed = edge.conductance * edge.length;
    if (edge.a == source) radial[edge.b] -= crossed * edge.from_b;
    if (edge.b == source) radial[edge.a] -= crossed * edge.from_a;
  }
  radial = factors_->connection.solve(radial).unaryExpr(&normalised).eval();
  const Eigen::VectorXcd axes = parallelField({{source, 1.0, seed.axis, 0.0}}, {});

  // === The distance whose gradient is the radial field
  Eigen::VectorXd divergence = Eigen::VectorXd::Zero(n);
  for (const Edge& edge : edges_) {
    if (edge.a == edge.b) continue;
    const double at_a = (std::conj(radial[edge.a]) * edge.from_a).real();
    const double at_b = -(std::conj(radial[edge.b]) * edge.from_b).real();
    const double along = edge.a == source   ? at_b
                         : edge.b == source ? at_a
                                            : (at_a + at_b) / 2.0;
    divergence[edge.b] += edge.cotan * edge.length * along;
    divergence[edge.a] -= edge.cotan * edge.length * along;
  }
  Eigen::VectorXd distance = Eigen::VectorXd::Zero(n);
  distance.head(n - 1) = factors_->poisson.solve(divergence.head(n - 1));
  distance.array() -= distance[source];

  Eigen::VectorXcd p(n);
  for (int v = 0; v < n; ++v)
    p[v] = distance[v] * radial[v] / axes[v];
  p[source] = 0.0;
  return p;
}

Eigen::Matrix2Xd HeatFlow::vectorLog(const std::vector<HeatSeed>& seeds) const {
  std::call_once(factors_->poisson_once, [&] {
    factors_->factorPoisson(surface_.vertexCount(), edges_);
  });
  if (!factors_->has_poisson) {
    rejectInput(
        "the Poisson system of a mesh of {} vertices cannot be factored; its faces are too "
        "thin, remesh it or use another log map method",
        surface_.vertexCount());
  }
  // The place of a vertex as each seed sees it: its own place, plus what it measures.
  Eigen::VectorXcd p = Eigen::VectorXcd::Zero(surface_.vertexCount());
  for (const HeatSeed& seed : seeds) {
    p += seed.weight * (vectorLogFrom(seed).array() + seed.p_T / unit_length_).matrix();
  }
  return columnsOf(p, unit_length_);
}

}  // namespace handgraft::geometry
