#include "core/session/posed_hand_contacts.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/contact/carry.h"
#include "core/hand/hand_parts.h"

namespace handgraft::session {

namespace {

/// Gives the patches of `set`, on the map's mesh, the directions that the touching links know.
void pointTowardsWrist(contact::ContactSet& set,
                       const contact::ContactMap& map,
                       const std::vector<int>& link_of_segment,
                       const hand::HandParts& parts,
                       const hand::LinkPoses& X_OL) {
  for (contact::Patch& patch : set.patches) {
    const int root = geometry::vertexAt(map.mesh_O, patch.root);
    HANDGRAFT_REQUIRE(root >= 0);
    const int segment = map.label[static_cast<std::size_t>(root)];
    if (segment < 0) continue;  // a region that was grown over its border
    const int link = link_of_segment[static_cast<std::size_t>(segment)];
    const Eigen::Matrix3d R_OL = X_OL[static_cast<std::size_t>(link)].linear();
    // Contact is face to face.
    const Eigen::Vector3d n_L =
        -(R_OL.transpose() * geometry::normalOf(map.mesh_O, patch.root));
    if (const auto d_L = parts.towardsWrist(link, n_L)) patch.direction_O = R_OL * *d_L;
  }
}

}  // namespace

std::vector<contact::PosedSurface> posedSurfaces(const hand::HandModel& model,
                                                 const hand::HandPose& pose,
                                                 const Pose& X_WO) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, pose);
  const Pose X_OW = X_WO.inverse();
  std::vector<contact::PosedSurface> parts;
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    const hand::Link& link = model.links()[i];
    if (link.surface().empty()) continue;
    const Eigen::Affine3d X_OL(Eigen::Isometry3d(X_OW * X_WL[i]));
    std::vector<geometry::TriangleMesh> shapes_O;
    for (const hand::Shape& shape : link.surface())
      shapes_O.push_back(geometry::transformed(shape.mesh_L, X_OL));
    parts.push_back({link.name, geometry::merged(shapes_O)});
  }
  return parts;
}

PosedContacts contactsOfPosedHand(const hand::HandModel& model,
                                  const std::vector<hand::ContactSite>& sites,
                                  const hand::HandPose& pose,
                                  const geometry::TriangleMesh& object_O,
                                  const Pose& X_WO,
                                  const contact::PoseContactOptions& reach,
                                  const contact::SegmentationOptions& segmentation,
                                  const Progress& progress) {
  const hand::HandParts parts(model, sites);
  const std::vector<contact::PosedSurface> surfaces_O = posedSurfaces(model, pose, X_WO);
  PosedContacts result;
  contact::ContactMap& map = result.map;
  map = contact::contactsFromPose(object_O, surfaces_O, reach, progress);
  std::vector<int> link_of_segment;
  for (const contact::PosedSurface& surface : surfaces_O) {
    const int link = model.linkIndex(surface.name);
    link_of_segment.push_back(link);
    const std::string& part = parts.names()[static_cast<std::size_t>(link)];
    map.segment_parts.push_back(part.empty() ? contact::fingerOfSegment(surface.name) : part);
  }
  result.set = contact::segment(map, segmentation);

  hand::LinkPoses X_OL = hand::forwardKinematics(model, pose);
  for (Pose& X : X_OL)
    X = X_WO.inverse() * X;
  pointTowardsWrist(result.set, map, link_of_segment, parts, X_OL);
  const bool is_refined = map.mesh_O.vertexCount() != object_O.vertexCount() ||
                          map.mesh_O.faces() != object_O.faces();
  if (is_refined) result.set = contact::carry(result.set, map.mesh_O, object_O);
  return result;
}

}  // namespace handgraft::session
