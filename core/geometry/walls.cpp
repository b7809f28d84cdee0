#include "core/geometry/walls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "core/geometry/sample_thinning.h"

namespace handgraft::geometry {

namespace {

using Eigen::Vector3d;

// Random packings with a least distance r hold about 0.8 points an area of r^2.
constexpr double kPacking = 0.8;

// Cosine: sides of a wall whose normals differ by less from opposite ones bound it.
constexpr double kOpposite = -0.5;

/// A place that may become a sample. Of corners first, then of edges, since thinning keeps what
/// comes first.
struct Candidate {
  Vector3d p;
  Vector3d n;
  double area_m2 = 0.0;
  bool is_sheet = false;
  bool is_edge = false;
};

/// Corners and tips: of a cone, say, whose sides meet at no sharp edge.
void addCorners(const SignedDistance& exact, std::vector<Candidate>& candidates) {
  const TriangleMesh& mesh = exact.surface();
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (mesh.isBoundaryVertex(v) || mesh.outgoingBegin(v) == mesh.outgoingEnd(v)) continue;
    if (2.0 * std::numbers::pi - mesh.angleSum(v) < Walls::kSharp) continue;
    Candidate candidate;
    candidate.p = mesh.vertex(v);
    candidate.n = mesh.vertexNormals().col(v);
    candidate.is_sheet = exact.isSheet(TriangleMesh::faceOf(*mesh.outgoingBegin(v)));
    candidate.is_edge = true;
    candidates.push_back(candidate);
  }
}

void addEdges(const SignedDistance& exact, double spacing, std::vector<Candidate>& candidates) {
  const TriangleMesh& mesh = exact.surface();
  for (int h = 0; h < 3 * mesh.faceCount(); ++h) {
    const int twin = mesh.twin(h);
    if (twin < h) continue;  // of both halves one
    const Vector3d n = mesh.faceNormals().col(TriangleMesh::faceOf(h));
    const Vector3d other = mesh.faceNormals().col(TriangleMesh::faceOf(twin));
    if (n.dot(other) > std::cos(Walls::kSharp)) continue;
    const Vector3d a = mesh.vertex(mesh.from(h));
    const Vector3d b = mesh.vertex(mesh.to(h));
    const int count = static_cast<int>(std::ceil((b - a).norm() / spacing));
    for (int i = 0; i <= count; ++i) {
      Candidate candidate;
      candidate.p = a + (b - a) * i / std::max(1, count);
      candidate.n = (n + other).norm() > 1e-6 ? Vector3d((n + other).normalized()) : n;
      candidate.is_sheet = exact.isSheet(TriangleMesh::faceOf(h));
      candidate.is_edge = true;
      candidates.push_back(candidate);
    }
  }
}

void addFaces(const SignedDistance& exact, double spacing, std::vector<Candidate>& candidates) {
  const TriangleMesh& mesh = exact.surface();
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const Vector3d a = mesh.vertex(face[0]);
    const Vector3d ab = mesh.vertex(face[1]) - a;
    const Vector3d ac = mesh.vertex(face[2]) - a;
    const double area = 0.5 * ab.cross(ac).norm();
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int count = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    Candidate candidate;
    candidate.n = mesh.faceNormals().col(f);
    candidate.area_m2 = area / (count * count);
    candidate.is_sheet = exact.isSheet(f);
    // The middles of count^2 triangles like this one.
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j + i < count; ++j) {
        for (int upside_down = 0; upside_down < (i + j + 1 < count ? 2 : 1); ++upside_down) {
          const double shift = upside_down == 1 ? 2.0 / 3.0 : 1.0 / 3.0;
          candidate.p = a + ab * ((i + shift) / count) + ac * ((j + shift) / count);
          candidates.push_back(candidate);
        }
      }
    }
  }
}

/// Sides that look the same way thin each other out, those of a thin wall do not.
int groupOf(const Candidate& candidate) {
  int axis = 0;
  candidate.n.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (candidate.n[axis] < 0.0 ? 1 : 0);
}

std::vector<WallSample> thinned(const std::vector<Candidate>& candidates,
                                double spacing,
                                std::vector<char>& is_edge) {
  Eigen::Matrix3Xd points(3, std::ssize(candidates));
  std::vector<int> groups;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    points.col(i) = candidates[static_cast<std::size_t>(i)].p;
    groups.push_back(groupOf(candidates[static_cast<std::size_t>(i)]));
  }
  const Thinned thinned = thinOut(points, groups, spacing);
  std::vector<WallSample> samples;
  for (const int kept : thinned.kept) {
    const Candidate& candidate = candidates[static_cast<std::size_t>(kept)];
    samples.push_back({candidate.p, candidate.n, 0.0,
                       candidate.is_sheet ? 0.0 : std::numeric_limits<double>::infinity()});
    is_edge.push_back(candidate.is_edge ? 1 : 0);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (thinned.nearest[i] < 0) continue;
    samples[static_cast<std::size_t>(thinned.nearest[i])].area_m2 += candidates[i].area_m2;
  }
  return samples;
}

/// The least way beneath each sample to one of the other side.
void measureThickness(double spacing, std::vector<WallSample>& samples) {
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return samples[static_cast<std::size_t>(a)].p.x() <
           samples[static_cast<std::size_t>(b)].p.x();
  });
  const double reach = Walls::kThin + spacing;
  std::size_t begin = 0;
  for (const int i : order) {
    WallSample& own = samples[static_cast<std::size_t>(i)];
    if (own.thickness_m == 0.0) continue;
    const auto at = [&](std::size_t k) -> const WallSample& {
      return samples[static_cast<std::size_t>(order[k])];
    };
    while (at(begin).p.x() < own.p.x() - reach)
      ++begin;
    for (std::size_t k = begin; k < order.size() && at(k).p.x() <= own.p.x() + reach; ++k) {
      const WallSample& other = at(k);
      if (own.n.dot(other.n) > kOpposite) continue;
      const Vector3d way = own.p - other.p;
      const double beneath = way.dot(own.n);
      if (beneath < 0.0 || beneath > Walls::kThin) continue;
      if ((way - beneath * own.n).squaredNorm() > spacing * spacing) continue;
      own.thickness_m = std::min(own.thickness_m, beneath);
    }
  }
}

}  // namespace

Walls::Walls(const SignedDistance& exact, const Options& options, const Progress& progress) {
  const TriangleMesh& mesh = exact.surface();
  double area = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const Vector3d a = mesh.vertex(face[0]);
    area += 0.5 * (mesh.vertex(face[1]) - a).cross(mesh.vertex(face[2]) - a).norm();
  }
  const double spacing =
      std::max(options.spacing_m, std::sqrt(area / (kPacking * options.most_samples)));
  std::vector<Candidate> candidates;
  addCorners(exact, candidates);
  addEdges(exact, 0.5 * spacing, candidates);
  addFaces(exact, spacing, candidates);
  progress.checkpoint();
  std::vector<char> is_edge;
  std::vector<WallSample> all = thinned(candidates, spacing, is_edge);
  progress.checkpoint();
  measureThickness(spacing, all);
  std::vector<WallSample> chosen;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (is_edge[i] != 0 || all[i].thickness_m <= kThin) chosen.push_back(all[i]);
  Eigen::Matrix3Xd points(3, std::ssize(chosen));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = chosen[static_cast<std::size_t>(i)].p;
  std::vector<int> order;
  tree_ = BallTree(points, order);
  for (const int i : order)
    samples_.push_back(chosen[static_cast<std::size_t>(i)]);
}

}  // namespace handgraft::geometry
