#include "core/geometry/flat_faces.h"

#include <algorithm>
#include <cmath>

namespace handgraft::geometry {

namespace {

constexpr double kShortest = 1e-150;  // m; whose inverse and square stay finite

}  // namespace

int FlatFaces::add(int f) {
  const auto [number, is_new] = faces_.add(f);
  const int first = 3 * number;
  if (!is_new) return first;
  Eigen::Vector3d edges[3];
  int numbers[3];
  for (int c = 0; c < 3; ++c) {
    const int from = mesh_.faces()(c, f);
    edges[c] = mesh_.vertex(mesh_.faces()((c + 1) % 3, f)) - mesh_.vertex(from);
    numbers[c] = addVertex(from);
  }
  for (int c = 0; c < 3; ++c) {
    Side side;
    side.length = edges[c].norm();
    side.inverse_length = side.length > kShortest ? 1.0 / side.length : 0.0;
    const Eigen::Vector3d along = side.inverse_length * edges[c];
    const Eigen::Vector3d to_apex = -edges[(c + 2) % 3];
    side.apex_x = to_apex.dot(along);
    side.apex_y = (to_apex - side.apex_x * along).norm();
    side.apex = numbers[(c + 2) % 3];
    if (mesh_.twin(3 * f + c) < 0) side.across = kNoFace;
    longest_side_ = std::max(longest_side_, side.length);
    sides_.push_back(side);
  }
  return first;
}

int FlatFaces::cross(int s) {
  const int twin = mesh_.twin(halfedgeOf(s));
  const int other = add(TriangleMesh::faceOf(twin)) + twin % 3;
  sides_[s].across = other;
  sides_[other].across = s;
  return other;
}

double FlatFaces::cornerAngle(int s) const {
  // From the opposite side: sides without length have no x axis.
  const Side& opposite = side(next(s));
  return std::atan2(opposite.apex_y * opposite.length,
                    opposite.apex_y * opposite.apex_y -
                        opposite.apex_x * (opposite.length - opposite.apex_x));
}

}  // namespace handgraft::geometry
