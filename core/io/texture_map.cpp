#include "core/io/texture_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/error.h"
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

struct Sample {
  int face;
  Eigen::Vector3d barycentric;
  double weight;  ///< m^2
  Eigen::Index pixel;
};

/// Even over each face, at the middles of the n^2 small triangles that n cuts each way make.
std::vector<Sample> samplesOf(const FileMesh& mesh, const Picture& picture) {
  std::vector<Sample> samples;
  const Eigen::Vector2d size(picture.width, picture.height);
  const double face_count = static_cast<double>(mesh.triangles.size());
  const int most_rows =
      std::min(kMostRows, std::max(1, static_cast<int>(std::sqrt(kMostSamples / face_count))));
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::array<Eigen::Vector3d, 3> p;
    std::array<Eigen::Vector2d, 3> uv;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(mesh.triangles[f][i]);
      p[i] = mesh.vertices[v];
      uv[i] = mesh.uv[v];
      if (!uv[i].allFinite()) rejectInput("face {} has no texture coordinates", f);
    }
    const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
    if (!(area > 0.0)) continue;
    double pixels = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
      pixels =
          std::max(pixels, (uv[(i + 1) % 3] - uv[i]).cwiseProduct(size).cwiseAbs().maxCoeff());
    }
    const int n =
        std::clamp(static_cast<int>(std::lround(std::min(pixels, 1e6))), 1, most_rows);
    const double weight = area / (n * n);
    const auto add = [&](double a, double b) {
      const Eigen::Vector3d barycentric(1.0 - (a + b) / n, a / n, b / n);
      const Eigen::Vector2d at =
          barycentric[0] * uv[0] + barycentric[1] * uv[1] + barycentric[2] * uv[2];
      samples.push_back({static_cast<int>(f), barycentric, weight, pixelAt(picture, at)});
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

}  // namespace

contact::ContactMap readTextureMap(const std::filesystem::path& mesh_path,
                                   const std::filesystem::path& picture_path,
                                   const ColorMap& scale) {
  MeshFile welded = readMesh(mesh_path);
  const FileMesh listed = readScene(mesh_path);
  const Picture picture = readPng(picture_path);
  try {
    if (listed.uv.empty()) rejectInput("has no texture coordinates");
    const std::vector<Sample> samples = samplesOf(listed, picture);
    Eigen::Matrix3Xd rgb(3, static_cast<Eigen::Index>(samples.size()));
    for (std::size_t k = 0; k < samples.size(); ++k)
      rgb.col(static_cast<Eigen::Index>(k)) = picture.rgb.col(samples[k].pixel).cast<double>();
    const ColorValues values = valuesOfColors(scale, rgb);

    contact::ContactMap map;
    map.mesh_O = std::move(welded.mesh);
    map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const Sample& sample = samples[k];
      for (int i = 0; i < 3; ++i) {
        const int listed_vertex =
            listed
                .triangles[static_cast<std::size_t>(sample.face)][static_cast<std::size_t>(i)];
        const int v = welded.mesh_vertex[static_cast<std::size_t>(listed_vertex)];
        if (v < 0) continue;
        const double weight = sample.weight * sample.barycentric[i];
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
