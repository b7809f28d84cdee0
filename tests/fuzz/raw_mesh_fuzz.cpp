// Small meshes straight from bytes, so that nearly every input reaches the geometry: choice of
// questions, number of vertices, kind of coordinates, coordinates, then corners of faces.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/triangle_mesh.h"

#include "tests/fuzz/byte_reader.h"
#include "tests/fuzz/sane_geometry.h"

namespace {

using handgraft::fuzz::ByteReader;

constexpr std::size_t kMostFaces = 200;

/// Coarse lattices make duplicates, slivers and coplanar faces; raw numbers overflow.
double coordinate(ByteReader& bytes, int kind) {
  switch (kind) {
    case 0:
      return bytes.take<std::int8_t>() / 8;
    case 1:
      return bytes.take<std::int16_t>() * 1e-5;
    case 2: {
      // Sizes from 1e-300 to 1e300.
      const double mantissa = bytes.take<std::int8_t>();
      return mantissa * std::pow(10.0, 2.4 * bytes.take<std::int8_t>());
    }
    default:
      return bytes.take<double>();
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteReader bytes(data, size);
  const auto choice = bytes.take<std::uint16_t>();
  const int vertex_count = 3 + bytes.take<std::uint8_t>() % 62;
  const int kind = bytes.take<std::uint8_t>() % 4;
  Eigen::Matrix3Xd vertices(3, vertex_count);
  for (int v = 0; v < vertex_count; ++v) {
    for (int axis = 0; axis < 3; ++axis)
      vertices(axis, v) = coordinate(bytes, kind);
  }
  std::vector<int> corners;
  while (bytes.left() >= 3 && corners.size() < 3 * kMostFaces) {
    std::array<int, 3> face{};
    for (int& corner : face)
      corner = bytes.take<std::uint8_t>() % vertex_count;
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    corners.insert(corners.end(), face.begin(), face.end());
  }
  const auto face_count = static_cast<Eigen::Index>(corners.size() / 3);
  try {
    const handgraft::geometry::TriangleMesh mesh(
        std::move(vertices), Eigen::Map<const Eigen::Matrix3Xi>(corners.data(), 3, face_count));
    handgraft::fuzz::exerciseGeometry(mesh, choice);
  } catch (const handgraft::InvalidInput&) {
    // Coordinates that are not finite.
  }
  return 0;
}
