#include "tests/bench/retargeting/exact_solid.h"

#include <algorithm>
#include <cmath>

namespace handgraft::bench {

namespace {

using Eigen::Vector3d;

/// A triangle's places no farther apart than `spacing_m`, its first corner left out where a
/// grid of one triangle would only repeat the vertices.
void sampleFace(const geometry::TriangleMesh& mesh,
                int f,
                double spacing_m,
                std::vector<Vector3d>& samples) {
  const Eigen::Vector3i face = mesh.face(f);
  const Vector3d a = mesh.vertex(face[0]);
  const Vector3d ab = mesh.vertex(face[1]) - a;
  const Vector3d ac = mesh.vertex(face[2]) - a;
  const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
  const int n = static_cast<int>(std::ceil(longest / spacing_m));
  if (n < 2) return;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const bool is_corner = i == n || j == n || i + j == 0;
      if (!is_corner) samples.emplace_back(a + (i * ab + j * ac) / n);
    }
  }
}

}  // namespace

ExactSolid::ExactSolid(const geometry::TriangleMesh& mesh, double spacing_m, double standoff_m)
    : locator_(std::make_unique<geometry::SurfaceLocator>(mesh)), standoff_m_(standoff_m) {
  if (mesh.isClosed()) winding_ = std::make_unique<geometry::WindingNumber>(mesh);
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    samples_.push_back(mesh.vertex(v));
    box_.extend(mesh.vertex(v));
  }
  for (int f = 0; f < mesh.faceCount(); ++f)
    sampleFace(mesh, f, spacing_m, samples_);
}

double ExactSolid::depth(const Vector3d& p) const {
  if (!winding_ || !box_.contains(p) || std::abs(winding_->at(p)) <= 0.5) return 0.0;
  return std::max(0.0, locator_->nearest(p).distance - standoff_m_);
}

double ExactSolid::distance(const Vector3d& p) const {
  const double d = locator_->nearest(p).distance;
  if (standoff_m_ == 0.0) return d;
  const bool is_inside = winding_ && box_.contains(p) && std::abs(winding_->at(p)) > 0.5;
  return std::abs(is_inside ? d - standoff_m_ : d + standoff_m_);
}

std::vector<Vector3d> ExactSolid::cells(double edge_m) const {
  std::vector<Vector3d> inside;
  if (!winding_) return inside;
  const Eigen::Array3i counts = (box_.sizes() / edge_m).array().ceil().cast<int>();
  for (int i = 0; i < counts[0]; ++i) {
    for (int j = 0; j < counts[1]; ++j) {
      for (int k = 0; k < counts[2]; ++k) {
        const Vector3d p = box_.min() + edge_m * Vector3d(i + 0.5, j + 0.5, k + 0.5);
        if (depth(p) > 0.0) inside.push_back(p);
      }
    }
  }
  return inside;
}

}  // namespace handgraft::bench
