#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/hand/link_surfaces.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using WrapMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Every rung bridges gaps half as wide again as the one before.
constexpr double kLadderStep = 1.5;
constexpr int kLadderRungs = 6;
/// Rungs spent on closing handles once the skin is of one piece.
constexpr int kExtraRungs = 2;
/// A wrap that has less of its vertices within epsilon of a link hides the hand.
constexpr double kCoveringShare = 0.97;
/// A wrap is of one piece when the largest one holds this share of the area: what is left are
/// loose screws and stray triangles.
constexpr double kWholeShare = 0.97;
/// Sizes of a hand; outside them a mesh is in other units than its file says.
constexpr double kSmallestHand_m = 0.01;
constexpr double kLargestHand_m = 2.0;

struct Soup {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> faces;
};

Soup soupOf(const geometry::TriangleMesh& mesh) {
  Soup soup;
  soup.points.reserve(static_cast<std::size_t>(mesh.vertexCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const Eigen::Vector3d p = mesh.vertex(v);
    soup.points.emplace_back(p.x(), p.y(), p.z());
  }
  for (int f = 0; f < mesh.faceCount(); ++f) {
    if (mesh.faceNormals().col(f).isZero()) continue;
    const Eigen::Vector3i face = mesh.face(f);
    soup.faces.push_back({static_cast<std::size_t>(face[0]), static_cast<std::size_t>(face[1]),
                          static_cast<std::size_t>(face[2])});
  }
  return soup;
}

/// Lets a wish to stop into the wrapping.
struct Checkpoint : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
  explicit Checkpoint(const Progress& p) : progress(p) {}

  template <class Wrapper, class Gate>
  void before_facet_treatment(const Wrapper& /*wrapper*/, const Gate& /*gate*/) {
    if (++steps % 1024 == 0) progress.checkpoint();
  }

  const Progress& progress;
  unsigned steps = 0;
};

geometry::TriangleMesh meshOf(const WrapMesh& wrap) {
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(wrap.number_of_vertices()));
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(wrap.number_of_faces()));
  std::vector<int> index(wrap.num_vertices(), -1);
  int count = 0;
  for (const auto v : wrap.vertices()) {
    const Kernel::Point_3& p = wrap.point(v);
    vertices.col(count) << p.x(), p.y(), p.z();
    index[v.idx()] = count++;
  }
  int face = 0;
  for (const auto f : wrap.faces()) {
    int corner = 0;
    for (const auto v : wrap.vertices_around_face(wrap.halfedge(f)))
      faces(corner++, face) = index[v.idx()];
    ++face;
  }
  return {std::move(vertices), std::move(faces)};
}

/// What one rung gave.
struct Candidate {
  geometry::TriangleMesh mesh;
  double share = 1.0;     ///< of the wrap's area that the mesh, its largest piece, holds
  double coverage = 0.0;  ///< share of its vertices within epsilon of a link

  [[nodiscard]] bool isWhole() const { return share >= kWholeShare; }

  [[nodiscard]] bool isCovering() const { return coverage >= kCoveringShare; }

  /// One piece before several, close to the links before far off, then fewer handles.
  [[nodiscard]] bool isBetterThan(const Candidate& other) const {
    if (isWhole() != other.isWhole()) return isWhole();
    if (!isWhole()) return share > other.share;
    if (isCovering() != other.isCovering()) return isCovering();
    if (!isCovering()) return coverage > other.coverage;
    return mesh.eulerCharacteristic() > other.mesh.eulerCharacteristic();
  }
};

double coverageOf(const geometry::TriangleMesh& mesh,
                  const geometry::SurfaceLocator& links,
                  double epsilon_m) {
  int near = 0;
  for (int v = 0; v < mesh.vertexCount(); ++v)
    if (links.nearest(mesh.vertex(v)).distance <= epsilon_m) ++near;
  return mesh.vertexCount() > 0 ? static_cast<double>(near) / mesh.vertexCount() : 0.0;
}

/// The component with the largest area.
Candidate largestComponent(const geometry::TriangleMesh& mesh) {
  const auto [component, count] = mesh.components();
  if (count == 1) return {mesh, 1.0, 0.0};
  std::vector<double> area(static_cast<std::size_t>(count), 0.0);
  double total = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    const double part = 0.5 * (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                                  .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                                  .norm();
    area[static_cast<std::size_t>(component[static_cast<std::size_t>(face[0])])] += part;
    total += part;
  }
  const auto best = std::max_element(area.begin(), area.end());
  const int kept = static_cast<int>(best - area.begin());

  std::vector<int> index(static_cast<std::size_t>(mesh.vertexCount()), -1);
  Eigen::Matrix3Xd vertices(3, mesh.vertexCount());
  int vertex_count = 0;
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (component[static_cast<std::size_t>(v)] != kept) continue;
    vertices.col(vertex_count) = mesh.vertex(v);
    index[static_cast<std::size_t>(v)] = vertex_count++;
  }
  Eigen::Matrix3Xi faces(3, mesh.faceCount());
  int face_count = 0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    if (component[static_cast<std::size_t>(face[0])] != kept) continue;
    for (int c = 0; c < 3; ++c)
      faces(c, face_count) = index[static_cast<std::size_t>(face[c])];
    ++face_count;
  }
  return {geometry::TriangleMesh(vertices.leftCols(vertex_count), faces.leftCols(face_count)),
          total > 0.0 ? *best / total : 0.0, 0.0};
}

/// One rung: wrap, then even out the triangles, which log maps are the better for.
geometry::TriangleMesh wrapLinks(const Soup& soup,
                                 double alpha_m,
                                 const SkinOptions& options,
                                 const Progress& progress) {
  WrapMesh wrap;
  Checkpoint checkpoint(progress);
  CGAL::alpha_wrap_3(soup.points, soup.faces, alpha_m, options.offset_m, wrap,
                     CGAL::parameters::visitor(checkpoint));
  progress.checkpoint();
  if (options.edge_m > 0.0) {
    CGAL::Polygon_mesh_processing::isotropic_remeshing(
        wrap.faces(), options.edge_m, wrap,
        CGAL::parameters::number_of_iterations(2).number_of_relaxation_steps(1));
    wrap.collect_garbage();
  }
  return meshOf(wrap);
}

void validate(const SkinOptions& options) {
  const auto check = [](double value, const char* name, double low, double high) {
    if (!(value >= low && value <= high))
      rejectInput("skin: {} {} m lies outside {} to {} m", name, value, low, high);
  };
  check(options.alpha_m, "alpha", 5e-4, 0.05);
  check(options.offset_m, "offset", 5e-5, 0.01);
  check(options.edge_m, "edge", 5e-4, 0.05);
}

}  // namespace

Skin buildSkin(const HandModel& model, const SkinOptions& options, const Progress& progress) {
  validate(options);
  progress.report("opening the hand", 0.0);
  Eigen::VectorXd q = skinReferencePose(model);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), q, X_SL);
  const LinkSurfaces links = linkSurfaces(model, X_SL);
  const Soup soup = soupOf(links.mesh_A);
  if (soup.faces.empty())
    rejectInput("hand {}: none of its links has a surface", quoted(model.name()));
  const geometry::SurfaceLocator links_locator(links.mesh_A);
  const double size = links.mesh_A.diagonal();
  if (!(size >= kSmallestHand_m && size <= kLargestHand_m))
    rejectInput("hand {}: {} m across, outside {} to {} m; are its meshes in another unit?",
                quoted(model.name()), size, kSmallestHand_m, kLargestHand_m);

  // The smallest alpha that gives one closed piece keeps the most detail. A few looser rungs
  // may still close handles, but not at the price of burying the links.
  std::optional<Candidate> best;
  double alpha = options.alpha_m;
  int rungs_left = kLadderRungs;
  for (int rung = 0; rungs_left > 0; ++rung, --rungs_left, alpha *= kLadderStep) {
    progress.checkpoint();
    progress.report(rung == 0 ? "wrapping the skin" : "wrapping the skin more loosely",
                    0.1 + 0.8 * rung / kLadderRungs);
    Candidate candidate = largestComponent(wrapLinks(soup, alpha, options, progress));
    if (!candidate.mesh.isClosed()) continue;
    candidate.coverage = coverageOf(candidate.mesh, links_locator, options.epsilon_m);
    const bool first_whole = candidate.isWhole() && (!best || !best->isWhole());
    if (!best || candidate.isBetterThan(*best)) best = std::move(candidate);
    if (best->isWhole() && best->isCovering() && best->mesh.eulerCharacteristic() == 2) break;
    if (first_whole) rungs_left = std::min(rungs_left, kExtraRungs + 1);
  }
  if (!best) rejectInput("hand {}: no closed skin fits it", quoted(model.name()));

  progress.report("relating skin and links", 0.95);
  return {model, std::move(best->mesh), std::move(q), options.epsilon_m};
}

}  // namespace handgraft::hand
