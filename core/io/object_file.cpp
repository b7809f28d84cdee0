#include "core/io/object_file.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/inward_faces.h"
#include "core/geometry/kd_tree.h"
#include "core/geometry/main_extent.h"
#include "core/io/file_bytes.h"
#include "core/io/ply_file.h"

namespace handgraft::io {

namespace {

constexpr double kReach = 0.005;  // m; from a point to the surface laid through it

bool isNamedPly(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension == ".ply";
}

Eigen::Matrix3Xd columns(const PlyFile& ply, const char* x, const char* y, const char* z) {
  Eigen::Matrix3Xd columns(3, ply.vertex_count);
  columns.row(0) = ply.vertex.at(x).transpose();
  columns.row(1) = ply.vertex.at(y).transpose();
  columns.row(2) = ply.vertex.at(z).transpose();
  return columns;
}

bool has(const PlyFile& ply, std::initializer_list<const char*> properties) {
  return std::all_of(properties.begin(), properties.end(), [&](const char* property) {
    return ply.vertex.count(property) != 0;
  });
}

/// Says so where no piece is most of the surface: contacts do not spread from one to the next.
void notePieces(MeshFile& file) {
  const auto [piece_of, count] = file.mesh.components();
  if (count < 2) return;
  std::vector<double> area(static_cast<std::size_t>(count), 0.0);
  for (int f = 0; f < file.mesh.faceCount(); ++f) {
    const Eigen::Vector3i corners = file.mesh.face(f);
    const Eigen::Vector3d a = file.mesh.vertex(corners[0]);
    area[piece_of[corners[0]]] +=
        0.5 * (file.mesh.vertex(corners[1]) - a).cross(file.mesh.vertex(corners[2]) - a).norm();
  }
  const double most = *std::max_element(area.begin(), area.end());
  if (most >= 0.5 * file.mesh.area()) return;
  file.notes.push_back(
      fmt::format("falls into {} pieces that share no corner, the largest {:.2g} % of the "
                  "surface: a contact ends where its piece ends",
                  count, 100.0 * most / file.mesh.area()));
}

/// A file's mesh in metres, its faces to the outside.
MeshFile asObject(MeshFile file, const LengthScale& scale) {
  notePieces(file);
  const double factor = scale ? scale(geometry::mainExtent(file.mesh)) : 1.0;
  if (factor != 1.0)
    file.mesh = geometry::transformed(file.mesh, Eigen::Affine3d(Eigen::Scaling(factor)));
  file.is_turned = geometry::inwardFaces(file.mesh);
  if (file.is_turned.empty()) return file;
  file.mesh = geometry::withTurnedFaces(file.mesh, file.is_turned);
  const auto count = std::count(file.is_turned.begin(), file.is_turned.end(), 1);
  file.notes.push_back(
      count == file.mesh.faceCount()
          ? "turned all faces: they looked inwards"
          : fmt::format("turned {} of {} faces, which looked inwards or disagreed with "
                        "their neighbours",
                        count, file.mesh.faceCount()));
  return file;
}

}  // namespace

MeshFile readObject(const std::filesystem::path& path,
                    const Progress& progress,
                    const cloud::SurfaceOptions& options,
                    const LengthScale& scale) {
  if (!isNamedPly(path)) return asObject(readMesh(path), scale);
  requireFile(path);
  const PlyFile ply = readPly(path);
  if (ply.faces.cols() > 0 || ply.vertex_count == 0 || !has(ply, {"x", "y", "z"}))
    return asObject(readMesh(path), scale);
  cloud::PointCloud cloud;
  cloud.points_O = columns(ply, "x", "y", "z");
  if (scale && cloud.points_O.allFinite())
    cloud.points_O *= scale(geometry::mainExtent(cloud.points_O));
  if (has(ply, {"nx", "ny", "nz"})) cloud.normals_O = columns(ply, "nx", "ny", "nz");
  try {
    cloud::CloudSurface surface = cloud::surfaceOf(cloud, options, progress);
    MeshFile file;
    file.mesh = std::move(surface.mesh_O);
    file.cloud_O = std::move(cloud.points_O);
    file.notes = std::move(surface.notes);
    return file;
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

contact::ContactMap onSurface(const contact::ContactMap& points,
                              const geometry::TriangleMesh& mesh_O,
                              double most_reach_m) {
  constexpr int kNeighbours = 4;
  const Eigen::Matrix3Xd& places = points.mesh_O.vertices();
  const geometry::KdTree tree(places);
  // A map may list the touched points alone: its contact must not spread over what is bare.
  double spacing = 0.0;
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    spacing += tree.nearestFew(places.col(i), kNeighbours).back().distance;
  spacing /= static_cast<double>(places.cols());
  const double reach_m = spacing > 0.0 ? std::min(most_reach_m, 2.0 * spacing) : most_reach_m;
  contact::ContactMap map;
  map.mesh_O = mesh_O;
  map.segment_names = points.segment_names;
  map.value = Eigen::VectorXd::Zero(mesh_O.vertexCount());
  if (!points.label.empty()) map.label.assign(static_cast<std::size_t>(map.value.size()), -1);
  bool any = false;
  for (int v = 0; v < mesh_O.vertexCount(); ++v) {
    double weights = 0.0;
    int label = -1;
    for (const auto& hit : tree.nearestFew(mesh_O.vertex(v), kNeighbours)) {
      if (hit.distance > reach_m) break;
      // A point at the vertex outweighs all others without dividing by zero.
      const double distance = hit.distance + 1e-9 * reach_m;
      const double weight = reach_m * reach_m / (distance * distance);
      weights += weight;
      map.value[v] += weight * points.value[hit.index];
      if (label < 0 && !points.label.empty())
        label = points.label[static_cast<std::size_t>(hit.index)];
    }
    if (weights > 0.0) map.value[v] /= weights;
    if (!map.label.empty()) map.label[static_cast<std::size_t>(v)] = label;
    any = any || weights > 0.0;
  }
  if (!any) {
    rejectInput(
        "contact map: none of its points lies within {:.1f} mm of the object's surface; is it "
        "another object, or another frame?",
        1e3 * reach_m);
  }
  return map;
}

contact::ContactMap onFaces(contact::ContactMap map, const MeshFile& object) {
  if (map.mesh_O.faceCount() > 0) {
    const std::vector<char> turned = geometry::inwardFaces(map.mesh_O);
    if (!turned.empty()) map.mesh_O = geometry::withTurnedFaces(map.mesh_O, turned);
    return map;
  }
  if (object.cloud_O.cols() > 0) return onSurface(map, object.mesh, kReach);
  const cloud::CloudSurface surface = cloud::surfaceOf({map.mesh_O.vertices(), {}});
  return onSurface(map, surface.mesh_O, kReach);
}

}  // namespace handgraft::io
