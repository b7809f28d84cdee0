#include "core/geometry/inward_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/closed_surface.h"
#include "core/geometry/signed_distance.h"
#include "core/geometry/winding_number.h"

namespace handgraft::geometry {
namespace {

/// What a closed piece holds, negative where its faces look into it.
std::vector<double> volumes(const TriangleMesh& mesh,
                            const std::vector<int>& piece_of,
                            int count) {
  // About the middle of the whole, where far origins cost no digits.
  const Eigen::Vector3d middle = mesh.vertices().rowwise().mean();
  std::vector<double> volume(static_cast<std::size_t>(count), 0.0);
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    volume[piece_of[face[0]]] += (mesh.vertex(face[0]) - middle)
                                     .cross(mesh.vertex(face[1]) - middle)
                                     .dot(mesh.vertex(face[2]) - middle) /
                                 6.0;
  }
  return volume;
}

/// Which faces each piece has.
std::vector<std::vector<int>> facesOf(const TriangleMesh& mesh,
                                      const std::vector<int>& piece_of,
                                      int count) {
  std::vector<std::vector<int>> faces(static_cast<std::size_t>(count));
  for (int f = 0; f < mesh.faceCount(); ++f)
    faces[piece_of[mesh.face(f)[0]]].push_back(f);
  return faces;
}

double middleOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Whether there is more of the solids before a piece than behind it, at its largest faces:
/// before a cavity's walls there is nothing, before those of a part within another less than
/// behind them.
bool looksInwards(const TriangleMesh& mesh,
                  std::vector<int> faces,
                  const WindingNumber& winding) {
  constexpr std::ptrdiff_t kPlaces = 15;
  constexpr double kOff = 0.01;  // of a face's size, so that nothing lies between
  const auto twice_area = [&](int f) {
    const Eigen::Vector3i face = mesh.face(f);
    return (mesh.vertex(face[1]) - mesh.vertex(face[0]))
        .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
        .norm();
  };
  const std::ptrdiff_t count = std::min(kPlaces, std::ssize(faces));
  if (count == 0) return false;
  std::partial_sort(faces.begin(), faces.begin() + count, faces.end(), [&](int a, int b) {
    return std::pair(-twice_area(a), a) < std::pair(-twice_area(b), b);
  });
  std::vector<double> before;
  std::vector<double> behind;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const int f = faces[static_cast<std::size_t>(i)];
    const Eigen::Vector3i face = mesh.face(f);
    const Eigen::Vector3d centre =
        (mesh.vertex(face[0]) + mesh.vertex(face[1]) + mesh.vertex(face[2])) / 3.0;
    const Eigen::Vector3d off = kOff * std::sqrt(twice_area(f)) * mesh.faceNormals().col(f);
    before.push_back(std::abs(winding.at(centre + off)));
    behind.push_back(std::abs(winding.at(centre - off)));
  }
  return middleOf(before) > middleOf(behind) + 0.5;
}

}  // namespace

std::vector<char> inwardFaces(const TriangleMesh& mesh_O) {
  const SolidsAndSheets parts = solidsAndSheets(mesh_O, kOpening);
  std::vector<char> turned(static_cast<std::size_t>(mesh_O.faceCount()), 0);
  const auto turn = [&](int part_face, bool is_turned) {
    const int given = parts.given_face[part_face];
    if (given >= 0) turned[given] = is_turned ? 1 : 0;
  };
  for (int f = 0; f < parts.mesh.faceCount(); ++f)
    turn(f, parts.is_turned[f] != 0);

  const TriangleMesh solids(parts.mesh.vertices(),
                            parts.mesh.faces().leftCols(parts.solid_faces));
  const auto [piece_of, count] = solids.components();
  const std::vector<double> volume = volumes(solids, piece_of, count);
  if (std::any_of(volume.begin(), volume.end(), [](double v) {
        return v < 0.0;
      })) {
    const WindingNumber winding(solids);
    for (const std::vector<int>& piece : facesOf(solids, piece_of, count)) {
      if (!looksInwards(solids, piece, winding)) continue;
      for (const int f : piece)
        turn(f, parts.is_turned[f] == 0);
    }
  }
  if (std::count(turned.begin(), turned.end(), 1) == 0) turned.clear();
  return turned;
}

TriangleMesh withTurnedFaces(const TriangleMesh& mesh, const std::vector<char>& turned) {
  HANDGRAFT_REQUIRE(std::ssize(turned) == mesh.faceCount());
  Eigen::Matrix3Xi faces = mesh.faces();
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (turned[f] != 0) std::swap(faces(1, f), faces(2, f));
  return {mesh.vertices(), std::move(faces)};
}

}  // namespace handgraft::geometry
