#include "core/cloud/point_cloud_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/cloud/pinholes.h"
#include "core/cloud/reconstruction.h"
#include "core/geometry/kd_tree.h"
#include "core/geometry/surface_locator.h"

namespace handgraft::cloud {

namespace {

using geometry::KdTree;
using geometry::SurfaceLocator;
using geometry::TriangleMesh;

/// Poisson's cost is per point, and it evens out what lies between: more points add little.
constexpr int kMostPoissonPoints = 15'000;
/// Holes narrower than this many spacings are where the front stumbled, not where nobody
/// looked.
constexpr double kPinhole = 4.0;
/// Roughness, in spacings, above which points are noisy: clean scans have 0.01, see DECISIONS.
constexpr double kNoisy = 0.05;
constexpr double kUneven = 4.0;
constexpr int kUsualHandles = 5;  // a pair of scissors has 2 or 3
constexpr double kMostLost = 0.001;
constexpr double kMostInvented = 0.02;
/// A surface that leaves more of the points behind than this is none of theirs.
constexpr double kMostLeftBehind = 0.5;

double areaOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  return 0.5 * (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                   .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                   .norm();
}

Eigen::Vector3d centreOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  return (mesh.vertex(face[0]) + mesh.vertex(face[1]) + mesh.vertex(face[2])) / 3.0;
}

/// The component with the largest area, and a note on the others.
TriangleMesh largestPiece(const TriangleMesh& mesh, std::vector<std::string>& notes) {
  if (mesh.faceCount() == 0) return mesh;
  const auto [component, count] = mesh.components();
  std::vector<double> area(static_cast<std::size_t>(count), 0.0);
  for (int f = 0; f < mesh.faceCount(); ++f)
    area[component[mesh.face(f)[0]]] += areaOf(mesh, f);
  const auto kept = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());

  std::vector<int> index(static_cast<std::size_t>(mesh.vertexCount()), -1);
  Eigen::Matrix3Xd vertices(3, mesh.vertexCount());
  Eigen::Matrix3Xi faces(3, mesh.faceCount());
  int vertex_count = 0;
  int face_count = 0;
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (component[v] != kept) continue;
    vertices.col(vertex_count) = mesh.vertex(v);
    index[v] = vertex_count++;
  }
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    if (component[face[0]] != kept) continue;
    faces.col(face_count++) << index[face[0]], index[face[1]], index[face[2]];
  }
  const auto others = std::count_if(area.begin(), area.end(),
                                    [](double a) {
                                      return a > 0.0;
                                    }) -
                      1;
  if (others > 0) {
    double total = 0.0;
    for (const double a : area)
      total += a;
    notes.push_back(
        fmt::format("left out {} separate pieces of the surface, {:.2g} % of its area", others,
                    100.0 * (1.0 - area[kept] / total)));
  }
  return {vertices.leftCols(vertex_count), faces.leftCols(face_count)};
}

TriangleMesh turnedRound(const TriangleMesh& mesh) {
  Eigen::Matrix3Xi faces = mesh.faces();
  faces.row(1).swap(faces.row(2));
  return {mesh.vertices(), std::move(faces)};
}

double sixfoldVolume(const TriangleMesh& mesh) {
  const Eigen::Vector3d origin = mesh.vertices().rowwise().mean();
  double volume = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    volume += (mesh.vertex(face[0]) - origin)
                  .dot((mesh.vertex(face[1]) - origin).cross(mesh.vertex(face[2]) - origin));
  }
  return volume;
}

/// Area-weighted agreement of the faces with the normals of the nearest points.
double agreementOf(const TriangleMesh& mesh, const PreparedCloud& cloud, const KdTree& points) {
  double agreement = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int near = points.nearest(centreOf(mesh, f)).index;
    agreement += areaOf(mesh, f) * mesh.faceNormals().col(f).dot(cloud.normals_O.col(near));
  }
  return agreement;
}

TriangleMesh facingOutward(const TriangleMesh& mesh,
                           const PreparedCloud& cloud,
                           const KdTree& points) {
  const double outward =
      mesh.isClosed() ? sixfoldVolume(mesh) : agreementOf(mesh, cloud, points);
  return outward < 0.0 ? turnedRound(mesh) : mesh;
}

TriangleMesh joined(const PreparedCloud& cloud,
                    const Progress& progress,
                    std::vector<std::string>& notes) {
  progress.report("joining the points", 0.2);
  const TriangleMesh front = advancingFrontSurface(cloud.points_O, cloud.gap_m, progress);
  // Crumbs lie in holes: first away with them.
  Mended mended = closePinholes(largestPiece(front, notes), kPinhole * cloud.spacing_m);
  if (mended.closed > 0) {
    notes.push_back(fmt::format("closed {} pinholes, at most {:.2f} mm wide", mended.closed,
                                1e3 * mended.widest));
  }
  return std::move(mended.mesh);
}

TriangleMesh fitted(const PreparedCloud& cloud,
                    const Progress& progress,
                    std::vector<std::string>& notes) {
  progress.report("fitting a closed surface", 0.4);
  const std::vector<Eigen::Index> few =
      evenSelection(cloud.points_O, kMostPoissonPoints, progress);
  const Eigen::Index count = cloud.points_O.cols();
  if (std::ssize(few) == count) {
    return largestPiece(poissonSurface(cloud.points_O, cloud.normals_O, cloud.spacing_m,
                                       cloud.spacing_m, progress),
                        notes);
  }
  notes.push_back(fmt::format("fitted to {} of {} points, evenly picked", few.size(), count));
  const double spacing =
      cloud.spacing_m * std::sqrt(static_cast<double>(count) / static_cast<double>(few.size()));
  return largestPiece(
      poissonSurface(cloud.points_O(Eigen::all, few), cloud.normals_O(Eigen::all, few), spacing,
                     spacing, progress),
      notes);
}

void measure(CloudSurface& surface,
             const PreparedCloud& cloud,
             const KdTree& points,
             double far_m,
             const Progress& progress) {
  const SurfaceLocator locator(surface.mesh_O);
  const Eigen::Index count = cloud.points_O.cols();
  Eigen::VectorXd distance(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i % 4096 == 0) progress.checkpoint();
    distance[i] = locator.nearest(cloud.points_O.col(i)).distance;
  }
  surface.mean_m = distance.mean();
  surface.rms_m = std::sqrt(distance.squaredNorm() / static_cast<double>(count));
  surface.max_m = distance.maxCoeff();
  surface.astray_share = (distance.array() > cloud.spacing_m).cast<double>().mean();
  surface.lost_share = (distance.array() > far_m).cast<double>().mean();

  double invented = 0.0;
  double total = 0.0;
  for (int f = 0; f < surface.mesh_O.faceCount(); ++f) {
    if (f % 4096 == 0) progress.checkpoint();
    const double area = areaOf(surface.mesh_O, f);
    total += area;
    const double reach = points.nearest(centreOf(surface.mesh_O, f)).distance;
    surface.reach_m = std::max(surface.reach_m, reach);
    if (reach > far_m) invented += area;
  }
  surface.invented_share = total > 0.0 ? invented / total : 0.0;

  const auto holes = borderLoops(surface.mesh_O);
  surface.hole_count = static_cast<int>(holes.size());
  for (const std::vector<int>& hole : holes)
    surface.widest_hole_m = std::max(surface.widest_hole_m, widthOf(surface.mesh_O, hole));
  surface.handle_count = (2 - surface.hole_count - surface.mesh_O.eulerCharacteristic()) / 2;
}

bool isTrue(const CloudSurface& surface) {
  return surface.mesh_O.faceCount() > 0 && surface.mesh_O.isClosed() &&
         surface.lost_share <= kMostLost && surface.invented_share <= kMostInvented;
}

/// Why Poisson's surface was not taken.
std::string faultOf(const CloudSurface& surface) {
  if (surface.mesh_O.faceCount() == 0 || !surface.mesh_O.isClosed())
    return "no closed surface fits the points";
  if (surface.invented_share > kMostInvented) {
    return fmt::format("an open scan: a closed surface would be {:.1f} % invented",
                       100.0 * surface.invented_share);
  }
  return fmt::format("a closed surface would miss {:.1f} % of the points",
                     100.0 * surface.lost_share);
}

void describe(CloudSurface& surface, const PreparedCloud& cloud, double far_m) {
  const TriangleMesh& mesh = surface.mesh_O;
  std::vector<std::string>& notes = surface.notes;
  notes.push_back(
      fmt::format("surface of {} points, {:.2f} mm apart, by {}: {}, handles: {}, {} faces, "
                  "edges of {:.2f} "
                  "mm",
                  surface.point_count, 1e3 * surface.spacing_m, nameOf(surface.method),
                  mesh.isClosed() ? "closed" : "open", surface.handle_count, mesh.faceCount(),
                  1e3 * mesh.meanEdgeLength()));
  notes.push_back(fmt::format(
      "the points are {:.3f} mm from it on average (RMS {:.3f}, at most {:.3f} mm), {:.1f} % "
      "of "
      "them farther than their spacing; {:.1f} % of it is farther than {:.2f} mm from all "
      "points, at most {:.2f} mm",
      1e3 * surface.mean_m, 1e3 * surface.rms_m, 1e3 * surface.max_m,
      100.0 * surface.astray_share, 100.0 * surface.invented_share, 1e3 * far_m,
      1e3 * surface.reach_m));
  if (surface.hole_count > 0) {
    notes.push_back(fmt::format("check: the surface has {} {}, up to {:.1f} mm wide",
                                surface.hole_count, surface.hole_count == 1 ? "hole" : "holes",
                                1e3 * surface.widest_hole_m));
  }
  if (surface.handle_count > kUsualHandles) {
    notes.push_back(fmt::format("check: the surface has {} handles; few objects have as many",
                                surface.handle_count));
  }
  if (cloud.unevenness > kUneven) {
    notes.push_back(fmt::format(
        "check: the points are uneven: their widest gaps are {:.0f} times the usual "
        "ones, and what lies between is a guess",
        cloud.unevenness));
  }
  if (surface.astray_share > kMostLost) {
    notes.push_back(fmt::format(
        "check: the surface misses {:.1f} % of the points by more than their spacing",
        100.0 * surface.astray_share));
  }
  if (!mesh.isClosed() && !cloud.normals_given) {
    notes.emplace_back(
        "check: without normals nothing says which side of an open scan is out: the side that "
        "it bulges to was taken");
  }
}

CloudSurface candidateBy(Method method,
                         const PreparedCloud& cloud,
                         const KdTree& points,
                         double far_m,
                         const Progress& progress) {
  CloudSurface surface;
  surface.method = method;
  surface.point_count = static_cast<int>(cloud.points_O.cols());
  surface.spacing_m = cloud.spacing_m;
  surface.notes = cloud.notes;
  const TriangleMesh mesh = method == Method::kAdvancingFront
                                ? joined(cloud, progress, surface.notes)
                                : fitted(cloud, progress, surface.notes);
  if (mesh.faceCount() == 0) return surface;
  surface.mesh_O = facingOutward(mesh, cloud, points);
  progress.report("measuring the surface", method == Method::kPoisson ? 0.8 : 0.3);
  measure(surface, cloud, points, far_m, progress);
  return surface;
}

/// The points joined, where that is true to them and they are not noisy; else a closed surface,
/// where one is.
template <class Candidate>
CloudSurface bestOf(const Candidate& candidate, const PreparedCloud& cloud) {
  CloudSurface surface;
  const bool noisy = cloud.roughness_m > kNoisy * cloud.spacing_m;
  if (!noisy) surface = candidate(Method::kAdvancingFront);
  if (!isTrue(surface)) {
    CloudSurface closed = candidate(Method::kPoisson);
    if (isTrue(closed)) {
      surface = std::move(closed);
    } else {
      if (noisy) surface = candidate(Method::kAdvancingFront);
      surface.notes.push_back(faultOf(closed));
    }
  }
  if (noisy) {
    surface.notes.push_back(
        fmt::format("the points are noisy: {:.3f} mm from where their "
                    "neighbours put them",
                    1e3 * cloud.roughness_m));
  }
  return surface;
}

}  // namespace

const char* nameOf(Method method) {
  switch (method) {
    case Method::kAuto:
      return "auto";
    case Method::kPoisson:
      return "Poisson";
    case Method::kAdvancingFront:
      return "advancing front";
  }
  return "?";
}

CloudSurface surfaceOf(const PointCloud& given,
                       const SurfaceOptions& options,
                       const Progress& progress) {
  if (options.most_points < kFewestPoints)
    rejectInput("most points is {}; it must be at least {}", options.most_points,
                kFewestPoints);
  if (!(options.far_spacings > 0.0))
    rejectInput("far is {} spacings; it must be above 0", options.far_spacings);
  const PreparedCloud cloud = prepare(given, options.most_points, progress);
  const KdTree points(cloud.points_O);
  const double far_m = options.far_spacings * cloud.spacing_m;

  const auto candidate = [&](Method method) {
    return candidateBy(method, cloud, points, far_m, progress);
  };
  CloudSurface surface =
      options.method != Method::kAuto ? candidate(options.method) : bestOf(candidate, cloud);
  if (surface.mesh_O.faceCount() == 0 || surface.lost_share > kMostLeftBehind) {
    rejectInput(
        "point cloud of {} points gives no surface by {} ({:.0f} % of the points would be "
        "farther "
        "than {:.2g} mm from it, permitted are {:.0f} %); are the points on one surface?",
        surface.point_count, nameOf(surface.method),
        surface.mesh_O.faceCount() == 0 ? 100.0 : 100.0 * surface.lost_share, 1e3 * far_m,
        100.0 * kMostLeftBehind);
  }
  describe(surface, cloud, far_m);
  return surface;
}

}  // namespace handgraft::cloud
