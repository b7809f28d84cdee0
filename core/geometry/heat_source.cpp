#include "core/geometry/heat_source.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

using Complex = std::complex<double>;

// Moments that a round source has none of. The fourth costs weights and gains nothing.
constexpr int kMoments = 3;
// What a change of weight weighs against a moment, both squared: keeps the source at its
// corners where the apexes cannot make it round. A tenth or a hundredth of it gives the same
// phi.
constexpr double kKeptShare = 1e-2;
constexpr double kRounding = 1e-12;  // of weights and gradients, which are about 1
constexpr int kMostPivots = 20;      // usual sources need three

Complex complexOf(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

const SourceNeighbour* neighbourOf(const SourceLayout& layout, int vertex) {
  const auto place = std::find_if(layout.neighbours.begin(), layout.neighbours.end(),
                                  [&](const SourceNeighbour& neighbour) {
                                    return neighbour.vertex == vertex;
                                  });
  return place == layout.neighbours.end() ? nullptr : &*place;
}

Complex placeOf(const SourceLayout& layout, int vertex) {
  const SourceNeighbour* neighbour = neighbourOf(layout, vertex);
  HANDGRAFT_REQUIRE(neighbour);
  return neighbour->r * complexOf(neighbour->direction_T);
}

bool hasSeed(const std::vector<HeatSeed>& seeds, int vertex) {
  return std::any_of(seeds.begin(), seeds.end(), [&](const HeatSeed& seed) {
    return seed.vertex == vertex;
  });
}

/// A seed at p_T, where halfedge h leaves its vertex for the place `to_T`. The layout says
/// where the source is seen from there, the surface where the same line leaves the vertex.
HeatSeed seedAt(const TriangleMesh& mesh,
                const IntrinsicDelaunay& surface,
                int h,
                const Complex& p_T,
                const Complex& to_T,
                double weight) {
  const Complex edge_T = to_T - p_T;
  const Complex back_T = p_T == 0.0 ? edge_T : -p_T;
  const double turn = std::arg(back_T / edge_T);
  const int v = mesh.from(h);
  return {v, weight, surface.meshDirection(v, h, turn) / (back_T / std::abs(back_T)), p_T};
}

/// The face across h laid flat into T; its apex as a seed without weight.
HeatSeed apexAcross(const TriangleMesh& mesh,
                    const IntrinsicDelaunay& surface,
                    const SourceLayout& layout,
                    int h) {
  const int to_apex = TriangleMesh::next(mesh.twin(h));  // from h's start
  const Complex from_T = placeOf(layout, mesh.from(h));
  const Complex to_T = placeOf(layout, mesh.to(h));
  const Eigen::Vector3d along =
      (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).stableNormalized();
  const Eigen::Vector3d side = mesh.vertex(mesh.to(to_apex)) - mesh.vertex(mesh.from(h));
  const Complex along_T = (to_T - from_T) / std::abs(to_T - from_T);
  const Complex p_T = from_T + along_T * Complex(along.dot(side), -along.cross(side).norm());
  return seedAt(mesh, surface, TriangleMesh::next(to_apex), p_T, to_T, 0.0);
}

/// The weights w >= 0 with sum 1 that minimise |J w|^2 + kept |w - w0|^2; w0 if they are not
/// found.
Eigen::VectorXd leastMoments(const Eigen::MatrixXd& J, const Eigen::VectorXd& w0) {
  const Eigen::Index n = w0.size();
  const Eigen::MatrixXd H = J.transpose() * J + kKeptShare * Eigen::MatrixXd::Identity(n, n);
  std::vector<char> is_free(static_cast<std::size_t>(n), 1);
  for (int pivot = 0; pivot < kMostPivots; ++pivot) {
    // Unknowns that are held at zero keep their place, as rows of the identity.
    Eigen::MatrixXd A = H;
    Eigen::MatrixXd b(n, 2);
    b << kKeptShare * w0, Eigen::VectorXd::Ones(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (is_free[i]) continue;
      A.row(i).setZero();
      A.col(i).setZero();
      A(i, i) = 1.0;
      b.row(i).setZero();
    }
    const Eigen::MatrixXd x = A.ldlt().solve(b);
    const double multiplier = (1.0 - x.col(0).sum()) / x.col(1).sum();
    const Eigen::VectorXd w = x.col(0) + multiplier * x.col(1);
    const Eigen::VectorXd gradient = ((H * w - kKeptShare * w0).array() - multiplier).matrix();
    bool done = true;
    for (Eigen::Index i = 0; i < n; ++i) {
      if ((is_free[i] ? w[i] : gradient[i]) > -kRounding) continue;
      is_free[i] = is_free[i] ? 0 : 1;
      done = false;
    }
    if (done) return w.allFinite() ? Eigen::VectorXd(w.cwiseMax(0.0)) : w0;
  }
  return w0;
}

/// Corners of all faces that the source lies in, those without weight too.
std::vector<HeatSeed> allCorners(const TriangleMesh& mesh,
                                 const IntrinsicDelaunay& surface,
                                 const SurfacePoint& source,
                                 const SourceLayout& layout) {
  std::vector<HeatSeed> seeds;
  // The source's own face first: it knows the weights.
  std::vector<int> faces = {source.face};
  for (const int f : layout.faces) {
    if (f != source.face) faces.push_back(f);
  }
  for (const int f : faces) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      if (hasSeed(seeds, mesh.from(h))) continue;
      const double weight = f == source.face ? std::max(source.barycentric[h % 3], 0.0) : 0.0;
      seeds.push_back(seedAt(mesh, surface, h, placeOf(layout, mesh.from(h)),
                             placeOf(layout, mesh.to(h)), weight));
    }
  }
  return seeds;
}

HeatSeed vertexSeed(const TriangleMesh& mesh,
                    const IntrinsicDelaunay& surface,
                    const SourceLayout& layout) {
  const int h = *mesh.outgoingBegin(layout.vertex);
  return seedAt(mesh, surface, h, 0.0, placeOf(layout, mesh.to(h)), 1.0);
}

void dropEmpty(std::vector<HeatSeed>& seeds) {
  std::erase_if(seeds, [](const HeatSeed& seed) {
    return seed.weight <= 0.0;
  });
}

}  // namespace

std::vector<HeatSeed> cornerSeeds(const TriangleMesh& mesh,
                                  const IntrinsicDelaunay& surface,
                                  const SurfacePoint& source,
                                  const SourceLayout& layout) {
  if (layout.vertex >= 0) return {vertexSeed(mesh, surface, layout)};
  std::vector<HeatSeed> seeds = allCorners(mesh, surface, source, layout);
  dropEmpty(seeds);
  return seeds;
}

std::vector<HeatSeed> roundSeeds(const TriangleMesh& mesh,
                                 const IntrinsicDelaunay& surface,
                                 const SurfacePoint& source,
                                 const SourceLayout& layout,
                                 double unit_length) {
  if (layout.vertex >= 0) return {vertexSeed(mesh, surface, layout)};
  std::vector<HeatSeed> seeds = allCorners(mesh, surface, source, layout);
  double scale = unit_length;
  for (const HeatSeed& seed : seeds)
    scale = std::max(scale, std::abs(seed.p_T));

  // === Apexes behind the faces of the source
  for (const int f : layout.faces) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      const int twin = mesh.twin(h);
      if (twin < 0 || hasSeed(seeds, mesh.to(TriangleMesh::next(twin)))) continue;
      seeds.push_back(apexAcross(mesh, surface, layout, h));
    }
  }

  // === Weights without moments
  const auto n = static_cast<Eigen::Index>(seeds.size());
  Eigen::MatrixXd J(2 * kMoments, n);
  Eigen::VectorXd w0(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Complex p = seeds[i].p_T / scale;
    Complex power = 1.0;
    for (Eigen::Index k = 0; k < kMoments; ++k) {
      // Heat from p fades like exp(s p), |s| about 1: moments count as in its series.
      power *= p / static_cast<double>(k + 1);
      J(2 * k, i) = power.real();
      J(2 * k + 1, i) = power.imag();
    }
    w0[i] = seeds[i].weight;
  }
  const Eigen::VectorXd w = leastMoments(J, w0);
  for (Eigen::Index i = 0; i < n; ++i)
    seeds[i].weight = w[i];
  dropEmpty(seeds);
  return seeds;
}

}  // namespace handgraft::geometry
