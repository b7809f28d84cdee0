#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/contact/pose_contacts.h"
#include "core/contact/segmentation.h"
#include "core/hand/finger_coordinates.h"
#include "core/hand/hand.h"
#include "core/hand/hand_model.h"
#include "core/hand/hand_parts.h"
#include "core/hand/kinematics.h"
#include "core/placement/open_roots.h"

namespace handgraft::demonstration {

/// The surface of each link that has one, under the link's name, where the pose puts it: what
/// contact::contactsFromPose needs of a hand.
/// Frames: pose in W, result in O. Cost: linear in the faces.
std::vector<contact::PosedSurface> posedSurfaces(const hand::HandModel& model,
                                                 const hand::HandPose& pose,
                                                 const Pose& X_WO);

struct PosedContacts {
  /// On a mesh of its own: the object's, cut finer where that is coarse. Its segments are the
  /// links.
  contact::ContactMap map;
  contact::ContactSet set;  ///< on the object's mesh; has no name yet
};

/// Where a hand touches an object, pose by pose, as patches: of each segment of a digit and of
/// the palm as contact::segment makes them, with its place on the hand and its direction along
/// the bone towards the wrist (hand/finger_coordinates.h), and how all its parts are turned.
/// Digits that touch nothing, or too little for a patch, are noted.
class ContactCutter {
 public:
  /// What hand and object have in all poses is made once. The object must outlive this.
  /// Errors: InvalidInput where the object cannot be refined (contact::refineEdges). Cost: as
  /// that and some 40 ms.
  ContactCutter(const hand::Hand& hand,
                const geometry::TriangleMesh& object_O,
                const contact::PoseContactOptions& reach);

  /// Frames: pose in W, object and result in O. Errors: InvalidInput as contactsFromPose (the
  /// hand touches nothing: how far it is) and segment. Cancelled on wish. Cost: that of
  /// contactsFromPose.
  [[nodiscard]] PosedContacts at(const hand::HandPose& pose,
                                 const Pose& X_WO,
                                 const contact::SegmentationOptions& segmentation,
                                 const Progress& progress) const;

 private:
  hand::Hand hand_;
  const geometry::TriangleMesh& object_O_;
  contact::PoseContactOptions reach_;
  hand::FingerCoordinates coordinates_;
  hand::HandParts parts_;
  placement::SkinFaces skin_faces_;
  std::vector<std::string> part_of_link_;
  std::vector<int> surface_links_;
  std::vector<contact::PartSurface> surfaces_;  ///< of those, in their frames
  geometry::TriangleMesh refined_O_;
};

/// Of one pose (ContactCutter).
PosedContacts contactsOfPosedHand(const hand::Hand& hand,
                                  const hand::HandPose& pose,
                                  const geometry::TriangleMesh& object_O,
                                  const Pose& X_WO,
                                  const contact::PoseContactOptions& reach,
                                  const contact::SegmentationOptions& segmentation,
                                  const Progress& progress);

}  // namespace handgraft::demonstration
