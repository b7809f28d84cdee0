#include "core/io/texture_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/contact/edge_refinement.h"
#include "core/io/file_mesh.h"
#include "core/io/mesh_file.h"
#include "core/io/png_file.h"

namespace handgraft::io {
namespace {

/// Rows of samples across a face, however many pixels it covers.
constexpr int kMostRows = 32;
/// In all; bounds memory (about 70 bytes each) on meshes of many faces or pictures of many
/// pixels. Each face has one at least.
constexpr double kMostSamples = 4e6;
/// A fingertip's patch is 5 to 15 mm across.
constexpr double kFineEdge = 0.0025;  // m

/// The pixel at a texture coordinate: u to the right, v upwards from the lower edge, repeated
/// outside [0, 1].
Eigen::Index pixelAt(const Picture& picture, const Eigen::Vector2d& uv) {
  const auto along = [](double t, int count) {
    const double whole = (t - std::floor(t)) * count;
    return std::clamp(static_cast<int>(whole), 0, count - 1);
  };
  const int x = along(uv.x(), picture.width);
  const int y = picture.height - 1 - along(uv.y(), picture.height);
  return static_cast<Eigen::Index>(y) * picture.width + x;
}

/// A triangle of the mesh that the values are for, and where the picture has its corners.
struct PaintedFace {
  std::array<int, 3> vertices{};
  std::array<Eigen::Vector2d, 3> uv;
  double area = 0.0;
};

struct Sample {
  std::size_t face;
  Eigen::Vector3d barycentric;
  double weight;  ///< m^2
  Eigen::Index pixel;
};

/// Even over each face, at the middles of the n^2 small triangles that n cuts each way make.
std::vector<Sample> samplesOf(const std::vector<PaintedFace>& faces, const Picture& picture) {
  std::vector<Sample> samples;
  const Eigen::Vector2d size(picture.width, picture.height);
  const double face_count = static_cast<double>(faces.size());
  const int most_rows =
      std::min(kMostRows, std::max(1, static_cast<int>(std::sqrt(kMostSamples / face_count))));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const PaintedFace& face = faces[f];
    if (!(face.area > 0.0)) continue;
    double pixels = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d edge = face.uv[(i + 1) % 3] - face.uv[i];
      pixels = std::max(pixels, edge.cwiseProduct(size).cwiseAbs().maxCoeff());
    }
    const int n =
        std::clamp(static_cast<int>(std::lround(std::min(pixels, 1e6))), 1, most_rows);
    const double weight = face.area / (n * n);
    const auto add = [&](double a, double b) {
      const Eigen::Vector3d barycentric(1.0 - (a + b) / n, a / n, b / n);
      const Eigen::Vector2d at = barycentric[0] * face.uv[0] + barycentric[1] * face.uv[1] +
                                 barycentric[2] * face.uv[2];
      samples.push_back({f, barycentric, weight, pixelAt(picture, at)});
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add(i + 1.0 / 3.0, j + 1.0 / 3.0);
        if (i + j + 1 < n) add(i + 2.0 / 3.0, j + 2.0 / 3.0);
      }
    }
  }
  return samples;
}

/// The listed triangle behind each face of the welded mesh, its corners in the face's order.
std::vector<std::array<int, 3>> listedCorners(const MeshFile& welded, const FileMesh& listed) {
  std::map<std::array<int, 3>, std::array<int, 3>> by_corners;
  for (const std::array<int, 3>& triangle : listed.triangles) {
    std::array<std::pair<int, int>, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = {welded.mesh_vertex[static_cast<std::size_t>(triangle[i])], triangle[i]};
    std::sort(corners.begin(), corners.end());
    by_corners.insert({{corners[0].first, corners[1].first, corners[2].first},
                       {corners[0].second, corners[1].second, corners[2].second}});
  }
  std::vector<std::array<int, 3>> result;
  for (int f = 0; f < welded.mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = welded.mesh.face(f);
    std::array<int, 3> sorted{face[0], face[1], face[2]};
    std::sort(sorted.begin(), sorted.end());
    const auto found = by_corners.find(sorted);
    HANDGRAFT_REQUIRE(found != by_corners.end());
    std::array<int, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at =
          std::find(sorted.begin(), sorted.end(), face[static_cast<Eigen::Index>(i)]);
      corners[i] = found->second[static_cast<std::size_t>(at - sorted.begin())];
    }
    result.push_back(corners);
  }
  return result;
}

/// Weights of the corners of a face at a point in its plane.
Eigen::Vector3d barycentricOf(const geometry::TriangleMesh& mesh,
                              int f,
                              const Eigen::Vector3d& p) {
  const Eigen::Vector3i face = mesh.face(f);
  const Eigen::Vector3d a = mesh.vertex(face[0]);
  const Eigen::Vector3d ab = mesh.vertex(face[1]) - a;
  const Eigen::Vector3d ac = mesh.vertex(face[2]) - a;
  const Eigen::Vector3d n = ab.cross(ac);
  const double whole = n.squaredNorm();
  if (!(whole > 0.0)) return {1.0, 0.0, 0.0};
  const double v = (p - a).cross(ac).dot(n) / whole;
  const double w = ab.cross(p - a).dot(n) / whole;
  return {1.0 - v - w, v, w};
}

/// The faces of `fine`, each inside the face of the welded mesh that `parents` names, with
/// their corners' places in the picture.
std::vector<PaintedFace> paintedFaces(const geometry::TriangleMesh& fine,
                                      const std::vector<int>& parents,
                                      const MeshFile& welded,
                                      const FileMesh& listed) {
  const std::vector<std::array<int, 3>> corners = listedCorners(welded, listed);
  std::vector<PaintedFace> faces(static_cast<std::size_t>(fine.faceCount()));
  for (int f = 0; f < fine.faceCount(); ++f) {
    PaintedFace& painted = faces[static_cast<std::size_t>(f)];
    const int parent = parents[static_cast<std::size_t>(f)];
    std::array<Eigen::Vector2d, 3> uv;
    for (std::size_t i = 0; i < 3; ++i) {
      uv[i] = listed.uv[static_cast<std::size_t>(corners[static_cast<std::size_t>(parent)][i])];
      if (!uv[i].allFinite()) {
        rejectInput("face {} has no texture coordinates",
                    welded.file_face[static_cast<std::size_t>(parent)]);
      }
    }
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      painted.vertices[i] = fine.face(f)[static_cast<Eigen::Index>(i)];
      p[i] = fine.vertex(painted.vertices[i]);
      const Eigen::Vector3d weights = barycentricOf(welded.mesh, parent, p[i]);
      painted.uv[i] = weights[0] * uv[0] + weights[1] * uv[1] + weights[2] * uv[2];
    }
    painted.area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
  }
  return faces;
}

/// Edges of the mesh that the values are for: as fine as a finger's patch asks, coarser on
/// objects so large that this would be too many.
double longestEdge(const geometry::TriangleMesh& mesh) {
  constexpr double kFaceShare = 0.3;  // of the square of the longest edge, as faces are cut
  constexpr double kMostFaces = 4e5;
  return std::max(kFineEdge, std::sqrt(mesh.area() / (kFaceShare * kMostFaces)));
}

}  // namespace

contact::ContactMap readTextureMap(const std::filesystem::path& mesh_path,
                                   const std::filesystem::path& picture_path,
                                   const ColorMap& scale) {
  const FileMesh listed = readScene(mesh_path);
  const Picture picture = readPng(picture_path);
  try {
    if (listed.uv.empty()) rejectInput("has no texture coordinates");
    const MeshFile welded = weldedMesh(listed);
    std::vector<int> parents;
    contact::ContactMap map;
    map.mesh_O = contact::refineEdges(welded.mesh, longestEdge(welded.mesh), &parents);
    const std::vector<PaintedFace> faces = paintedFaces(map.mesh_O, parents, welded, listed);
    const std::vector<Sample> samples = samplesOf(faces, picture);
    Eigen::Matrix3Xd rgb(3, static_cast<Eigen::Index>(samples.size()));
    for (std::size_t k = 0; k < samples.size(); ++k)
      rgb.col(static_cast<Eigen::Index>(k)) = picture.rgb.col(samples[k].pixel).cast<double>();
    const ColorValues values = valuesOfColors(scale, rgb);

    map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const Sample& sample = samples[k];
      for (std::size_t i = 0; i < 3; ++i) {
        const int v = faces[sample.face].vertices[i];
        const double weight = sample.weight * sample.barycentric[static_cast<Eigen::Index>(i)];
        map.value[v] += weight * values.value[static_cast<Eigen::Index>(k)];
        weights[v] += weight;
      }
    }
    map.value = (weights.array() > 0.0).select(map.value.array() / weights.array(), 0.0);
    validate(map);
    return map;
  } catch (const InvalidInput& error) {
    rejectInput("{} with {}: {}", quoted(mesh_path.string()), quoted(picture_path.string()),
                error.what());
  }
}

}  // namespace handgraft::io
