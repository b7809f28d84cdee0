#include "core/contact/pose_contacts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/contact/edge_refinement.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

constexpr int kBatch = 256;  // vertices between two reports

void validate(const PoseContactOptions& options) {
  if (!(options.reach_m > 0.0) || !std::isfinite(options.reach_m)) {
    rejectInput("contact reach is {} m; it must be above 0", options.reach_m);
  }
  if (!(options.softness_m >= 0.0) || !std::isfinite(options.softness_m)) {
    rejectInput("a contact's softness is {} m; it must be 0 or above", options.softness_m);
  }
}

/// Of a vertex so deep in a part whose deepest vertex is at `deepest`.
double contactAt(double depth, double deepest, const PoseContactOptions& options) {
  const auto reached = [&](double s) {
    return std::clamp(1.0 + s / options.reach_m, 0.0, 1.0);
  };
  if (options.softness_m == 0.0) return reached(depth);
  return reached(deepest) * std::max(0.0, 1.0 - (deepest - depth) / options.softness_m);
}

[[noreturn]] void rejectFarHand(const TriangleMesh& object_O,
                                const std::vector<PartSurface>& parts,
                                const std::vector<Pose>& X_LO,
                                const Progress& progress) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int v = 0; v < object_O.vertexCount(); ++v) {
    if (v % kBatch == 0) progress.checkpoint();
    for (std::size_t i = 0; i < parts.size(); ++i)
      nearest = std::min(nearest, parts[i].distance(X_LO[i] * object_O.vertex(v), nearest));
  }
  rejectInput(
      "the posed hand touches nothing: its nearest part is {:.0f} mm from the object; is the "
      "pose in another frame?",
      1e3 * nearest);
}

/// m; minus infinity where nothing is in reach.
struct Depths {
  Eigen::VectorXd of_vertices;   ///< in the part that is nearest
  std::vector<double> of_parts;  ///< each one's deepest vertex
};

/// Labels each vertex of `map` with the part that it lies deepest in.
Depths measureDepths(const std::vector<PartSurface>& parts,
                     const std::vector<Pose>& X_OL,
                     const std::vector<Pose>& X_LO,
                     const PoseContactOptions& options,
                     const Progress& progress,
                     ContactMap& map) {
  constexpr double kNowhere = -std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3d> centres_O;
  for (std::size_t i = 0; i < parts.size(); ++i)
    centres_O.push_back(X_OL[i] * parts[i].centre());
  Depths depths{Eigen::VectorXd::Constant(map.mesh_O.vertexCount(), kNowhere),
                std::vector<double>(parts.size(), kNowhere)};
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    if (v % kBatch == 0) {
      progress.report("measuring the contact",
                      static_cast<double>(v) / map.mesh_O.vertexCount());
      progress.checkpoint();
    }
    const Eigen::Vector3d p_O = map.mesh_O.vertex(v);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double away = parts[i].radius() + options.reach_m;
      if (!parts[i].hasFaces() || (p_O - centres_O[i]).squaredNorm() > away * away) continue;
      const double d = parts[i].depth(X_LO[i] * p_O, options.reach_m);
      if (!(d > -options.reach_m)) continue;
      depths.of_parts[i] = std::max(depths.of_parts[i], d);
      if (!(d > depths.of_vertices[v])) continue;
      depths.of_vertices[v] = d;
      map.label[static_cast<std::size_t>(v)] = static_cast<int>(i);
    }
  }
  return depths;
}

}  // namespace

PartSurface::PartSurface(std::string name, const TriangleMesh& mesh_L)
    : name_(std::move(name)) {
  if (mesh_L.faceCount() == 0) return;
  locator_.emplace(mesh_L);
  winding_.emplace(mesh_L);
  for (int f = 0; f < mesh_L.faceCount(); ++f) {
    for (const int v : mesh_L.face(f))
      box_L_.extend(mesh_L.vertex(v));
  }
}

double PartSurface::distance(const Eigen::Vector3d& p_L, double reach) const {
  if (!locator_ || box_L_.exteriorDistance(p_L) > reach)
    return std::numeric_limits<double>::infinity();
  const auto hit = locator_->nearest(p_L, reach);
  return hit ? hit->distance : std::numeric_limits<double>::infinity();
}

double PartSurface::depth(const Eigen::Vector3d& p_L, double reach) const {
  return contains(p_L) ? locator_->nearest(p_L).distance : -distance(p_L, reach);
}

bool PartSurface::contains(const Eigen::Vector3d& p_L) const {
  return winding_ && box_L_.contains(p_L) && winding_->at(p_L) > 0.5;
}

ContactMap contactsFromPose(const TriangleMesh& object_O,
                            const std::vector<PosedSurface>& parts_O,
                            const PoseContactOptions& options,
                            const Progress& progress) {
  std::vector<PartSurface> parts;
  parts.reserve(parts_O.size());
  for (const PosedSurface& part : parts_O)
    parts.emplace_back(part.name, part.mesh_O);
  return contactsOnVertices(refineEdges(object_O, options.longest_edge_m), parts,
                            std::vector<Pose>(parts.size(), Pose::Identity()), options,
                            progress);
}

ContactMap contactsOnVertices(const TriangleMesh& mesh_O,
                              const std::vector<PartSurface>& parts,
                              const std::vector<Pose>& X_OL,
                              const PoseContactOptions& options,
                              const Progress& progress) {
  HANDGRAFT_REQUIRE(X_OL.size() == parts.size());
  validate(options);
  if (mesh_O.faceCount() == 0) rejectInput("the object has no face to be touched");
  ContactMap map;
  std::vector<Pose> X_LO;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    map.segment_names.push_back(parts[i].name());
    X_LO.push_back(inverse(X_OL[i]));
  }
  if (std::none_of(parts.begin(), parts.end(), [](const PartSurface& part) {
        return part.hasFaces();
      }))
    rejectInput("the posed hand has no surface: none of its parts has a face");

  map.mesh_O = mesh_O;
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  map.label.assign(static_cast<std::size_t>(map.mesh_O.vertexCount()), -1);
  const Depths depths = measureDepths(parts, X_OL, X_LO, options, progress, map);

  // === What would touch if each part were drawn back to the surface
  bool any_contact = false;
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    int& label = map.label[static_cast<std::size_t>(v)];
    if (label < 0) continue;
    map.value[v] = contactAt(depths.of_vertices[v],
                             depths.of_parts[static_cast<std::size_t>(label)], options);
    if (map.value[v] <= 0.0) label = -1;
    any_contact = any_contact || map.value[v] > 0.0;
  }
  if (!any_contact) rejectFarHand(map.mesh_O, parts, X_LO, progress);
  return map;
}

}  // namespace handgraft::contact
