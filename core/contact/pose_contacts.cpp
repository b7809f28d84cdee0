#include "core/contact/pose_contacts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/contact/edge_refinement.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/winding_number.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

constexpr int kBatch = 256;  // vertices between two reports

/// One part with what its queries need; parts without faces are in reach of nothing.
class Part {
 public:
  explicit Part(const TriangleMesh& mesh_O) {
    if (mesh_O.faceCount() == 0) return;
    locator_.emplace(mesh_O);
    winding_.emplace(mesh_O);
    for (int f = 0; f < mesh_O.faceCount(); ++f) {
      for (const int v : mesh_O.face(f))
        box_.extend(mesh_O.vertex(v));
    }
  }

  /// Distance to the surface; infinity beyond `reach`.
  [[nodiscard]] double distance(const Eigen::Vector3d& p_O, double reach) const {
    if (!locator_ || box_.exteriorDistance(p_O) > reach)
      return std::numeric_limits<double>::infinity();
    const auto hit = locator_->nearest(p_O, reach);
    return hit ? hit->distance : std::numeric_limits<double>::infinity();
  }

  /// How far inside; below 0 outside, minus infinity beyond `reach`.
  [[nodiscard]] double depth(const Eigen::Vector3d& p_O, double reach) const {
    return contains(p_O) ? locator_->nearest(p_O).distance : -distance(p_O, reach);
  }

  [[nodiscard]] bool contains(const Eigen::Vector3d& p_O) const {
    return winding_ && box_.contains(p_O) && winding_->at(p_O) > 0.5;
  }

 private:
  std::optional<geometry::SurfaceLocator> locator_;
  std::optional<geometry::WindingNumber> winding_;
  Eigen::AlignedBox3d box_;
};

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
                                const std::vector<Part>& parts,
                                const Progress& progress) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int v = 0; v < object_O.vertexCount(); ++v) {
    if (v % kBatch == 0) progress.checkpoint();
    for (const Part& part : parts)
      nearest = std::min(nearest, part.distance(object_O.vertex(v), nearest));
  }
  rejectInput(
      "the posed hand touches nothing: its nearest part is {:.0f} mm from the object; is the "
      "pose in another frame?",
      1e3 * nearest);
}

}  // namespace

ContactMap contactsFromPose(const TriangleMesh& object_O,
                            const std::vector<PosedSurface>& parts_O,
                            const PoseContactOptions& options,
                            const Progress& progress) {
  validate(options);
  if (object_O.faceCount() == 0) rejectInput("the object has no face to be touched");
  std::vector<Part> parts;
  parts.reserve(parts_O.size());
  ContactMap map;
  bool any_face = false;
  for (const PosedSurface& part : parts_O) {
    parts.emplace_back(part.mesh_O);
    map.segment_names.push_back(part.name);
    any_face = any_face || part.mesh_O.faceCount() > 0;
  }
  if (!any_face) rejectInput("the posed hand has no surface: none of its parts has a face");

  map.mesh_O = refineEdges(object_O, options.longest_edge_m);
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  map.label.assign(static_cast<std::size_t>(map.mesh_O.vertexCount()), -1);
  // === How deep each vertex lies in the part that is nearest to it, and each part at all
  constexpr double kNowhere = -std::numeric_limits<double>::infinity();
  Eigen::VectorXd depth = Eigen::VectorXd::Constant(map.mesh_O.vertexCount(), kNowhere);
  std::vector<double> deepest(parts.size(), kNowhere);
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    if (v % kBatch == 0) {
      progress.report("measuring the contact",
                      static_cast<double>(v) / map.mesh_O.vertexCount());
      progress.checkpoint();
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double d = parts[i].depth(map.mesh_O.vertex(v), options.reach_m);
      if (!(d > -options.reach_m)) continue;
      deepest[i] = std::max(deepest[i], d);
      if (!(d > depth[v])) continue;
      depth[v] = d;
      map.label[static_cast<std::size_t>(v)] = static_cast<int>(i);
    }
  }

  // === What would touch if each part were drawn back to the surface
  bool any_contact = false;
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    int& label = map.label[static_cast<std::size_t>(v)];
    if (label < 0) continue;
    map.value[v] = contactAt(depth[v], deepest[static_cast<std::size_t>(label)], options);
    if (map.value[v] <= 0.0) label = -1;
    any_contact = any_contact || map.value[v] > 0.0;
  }
  if (!any_contact) rejectFarHand(map.mesh_O, parts, progress);
  return map;
}

}  // namespace handgraft::contact
