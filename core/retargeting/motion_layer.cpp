#include "core/retargeting/motion_layer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/tangent.h"
#include "core/hand/skin_planes.h"
#include "core/manipulation/patch_path.h"
#include "core/manipulation/transfer_points.h"
#include "core/retargeting/motion_solving.h"
#include "core/transfer/draft_charts.h"

namespace handgraft::retargeting {

namespace {

using manipulation::Motion;
using manipulation::PatchKey;
using manipulation::PatchTrack;
using manipulation::TransferredMotion;

/// Whether the motion's points are of this very hand: all lie on links that it has. A name that
/// two hands have by chance (`wrist`) makes them no points of it, unless nothing else tells
/// where they belong.
bool liesOnLinksOf(const hand::HandModel& model, const Motion& motion) {
  bool has_one = false;
  bool lacks_one = false;
  bool has_places = false;
  for (const PatchTrack& track : motion.tracks) {
    for (const PatchKey& key : track.keys) {
      has_places = has_places || key.patch.place.has_value();
      for (const manipulation::HandPoint& point : key.hand_points)
        (model.maybeLinkIndex(point.link) ? has_one : lacks_one) = true;
    }
  }
  return has_one && !(lacks_one && has_places);
}

}  // namespace

contact::Patch withDirection(const geometry::TriangleMesh& mesh, contact::Patch patch) {
  if (!patch.direction_O) patch.direction_O = anyTangentAt(mesh, patch.root);
  return patch;
}

/// Log coordinates of `to` about `from`, x along `direction`.
Eigen::Vector2d wayTo(const geometry::TriangleMesh& mesh,
                      const geometry::SurfacePoint& from,
                      const Eigen::Vector3d& direction,
                      const geometry::SurfacePoint& to,
                      const std::string& patch) {
  const double apart = (positionOf(mesh, to) - positionOf(mesh, from)).norm();
  if (apart == 0.0) return Eigen::Vector2d::Zero();
  const geometry::LogMap map =
      geometry::computeLogMap(mesh, from, direction, std::numeric_limits<double>::infinity(),
                              geometry::LogMapMethod::kFast);
  Eigen::Vector2d way = logCoordinates(mesh, map, to);
  if (!way.allFinite())
    rejectInput("patch {}: no way over the surface leads to its new root", quoted(patch));
  return way;
}

/// A key's patch, moved over the object.
contact::Patch movedOver(const geometry::TriangleMesh& object_O,
                         const contact::Patch& patch,
                         const Shift& shift) {
  if (shift.isNone()) return patch;
  contact::Patch result =
      manipulation::slid(object_O, withDirection(object_O, patch), shift.way_T);
  if (shift.turn_rad == 0.0) return result;
  const geometry::TriangleMesh& mesh = object_O;
  // The outline turns with the direction: its points keep their coordinates.
  const Eigen::Vector3d before = *result.direction_O;
  const Eigen::Vector3d root = positionOf(mesh, result.root);
  const Eigen::Vector3d n = normalOf(mesh, result.root);
  const Eigen::AngleAxisd turn(shift.turn_rad, n);
  const geometry::SurfaceLocator locator(mesh);
  result.direction_O = tangentTurned(mesh, result.root, before, shift.turn_rad);
  for (geometry::SurfacePoint& point : result.interpolation_boundary)
    point = locator.nearest(root + turn * (positionOf(mesh, point) - root)).point;
  return result;
}

MotionLayer::MotionLayer(const session::Document& document,
                         const hand::Hand& hand,
                         const geometry::TriangleMesh& object_O,
                         const Motion& motion)
    : document_(document),
      hand_(hand),
      object_O_(object_O),
      coordinates_(*hand.model, *hand.skin, hand.sites),
      surfaces_(transfer::borrowedSurfaces(object_O, *hand.skin)),
      lies_on_links_(liesOnLinksOf(*hand.model, motion)),
      has_points_(
          std::any_of(motion.tracks.begin(), motion.tracks.end(), [](const PatchTrack& track) {
            return isRecorded(track.keys.front());
          })) {
  surfaces_.planes_S = hand::planesOf(hand.skin);
  surfaces_.drafts_S = transfer::draftChartsOf(hand.skin);
}

TransferredMotion MotionLayer::lay(const Motion& motion,
                                   const Progress& progress,
                                   const manipulation::MovePlacement& move,
                                   manipulation::MotionCharts* charts) const {
  if (lies_on_links_) return transferPoints(motion, object_O_, *hand_.model);
  if (has_points_) {
    return transferPointsByPlace(motion, object_O_, *hand_.model, *hand_.skin, coordinates_,
                                 progress);
  }
  return transferPatches(motion, surfaces_, *hand_.model, hand_.sites, coordinates_,
                         document_.transfer, progress, move, charts);
}

std::vector<optimize::PointPair> MotionLayer::layKey(const Motion& motion,
                                                     int track,
                                                     const PatchKey& key,
                                                     const Shifts& shifts,
                                                     const Progress& progress) const {
  if (!shifts.on_hand.isNone() && (lies_on_links_ || has_points_)) {
    rejectInput(
        "patch {}: a recorded point has no outline on the hand; its root there cannot be "
        "moved",
        quoted(motion.tracks[static_cast<std::size_t>(track)].name));
  }
  Motion alone;
  alone.name = motion.name;
  alone.hand = motion.hand;
  alone.side = motion.side;
  alone.time_s = {0.0};
  alone.X_WO = {Pose::Identity()};
  PatchTrack one = motion.tracks[static_cast<std::size_t>(track)];
  one.keys = {key};
  one.keys[0].frame = 0;
  one.keys[0].patch = movedOver(object_O_, key.patch, shifts.on_object);
  one.end = 1;
  alone.tracks = {std::move(one)};
  const geometry::TriangleMesh& skin_S = hand_.skin->mesh();
  const TransferredMotion laid = lay(
      alone, progress,
      [&](const transfer::PatchPlacement& placement) -> transfer::PatchPlacement {
        if (shifts.on_hand.isNone()) return placement;
        const geometry::LogMap map = geometry::computeLogMap(
            skin_S, placement.root_S, placement.direction_S,
            std::max(1e-3, 1.5 * shifts.on_hand.way_T.norm()), geometry::LogMapMethod::kAuto);
        const auto place = geometry::LogMapInverse(skin_S, map).at(shifts.on_hand.way_T);
        if (!place.point.valid()) {
          rejectInput("patch {}: no skin {:.1f} mm from its root on the hand",
                      quoted(alone.tracks[0].name), 1e3 * shifts.on_hand.way_T.norm());
        }
        return turned(skin_S, movedTo(skin_S, placement, place.point), shifts.on_hand.turn_rad);
      });
  return laid.tracks.front().spans.front().pairs;
}

std::optional<transfer::PatchPlacement> MotionLayer::placementOf(const PatchKey& key) const {
  return manipulation::placementOf(key, surfaces_, *hand_.model, hand_.sites, coordinates_);
}

}  // namespace handgraft::retargeting
