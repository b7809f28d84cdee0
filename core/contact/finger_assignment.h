#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/contact/contact_map.h"
#include "core/hand/hand_location.h"

namespace handgraft::contact {

/// Where the joints of the hand that touched were.
struct HandJoints {
  /// Columns: wrist, then thumb, index, middle, ring, little, each four from base to tip (the
  /// order of OpenPose, ContactPose and DexYCB). In O, metres.
  Eigen::Matrix<double, 3, 21> p_O;
};

/// Index into kHandParts.
inline constexpr int kPalm = 5;
inline constexpr const char* kHandParts[] = {"thumb", "index",  "middle",
                                             "ring",  "little", "palm"};

struct NearestBone {
  int part = kPalm;  ///< whose bone it is, an index into kHandParts
  double distance_m = 0.0;
  /// Unit, along the bone to its end nearer to the wrist; zero for a bone without length.
  Eigen::Vector3d towards_wrist_O = Eigen::Vector3d::Zero();
};

/// The nearest of the hand's 20 bones: three of each finger and five of the palm, from the
/// wrist to each finger's base. With `part`, the nearest of that part.
NearestBone nearestBone(const HandJoints& joints,
                        const Eigen::Vector3d& p_O,
                        std::optional<int> part = std::nullopt);

/// Errors: InvalidInput naming the joint that is not finite, or if all are in one place.
void validate(const HandJoints& joints);

/// Labels every vertex in contact with the segment of the hand whose bone is nearest
/// (`index_middle`, `palm`), and names the segments so.
///
/// A region in contact that hangs together is a whole first: a part of the hand counts there if
/// at least `minimum_area_m2` and 15 % of the region is nearest to it; the rest goes to the
/// nearest of those that count. So joints that are a few millimetres off do not cut slivers
/// from a finger's patch, and a region that two fingers touch is split between them.
/// Shapes: `touches` one flag per vertex. Errors: as validate. Cost: O(V).
void assignFingers(ContactMap& map,
                   const std::vector<char>& touches,
                   const HandJoints& joints,
                   double minimum_area_m2);

/// Where on the hand a patch of `part` with its root at `p_O` was: along the nearest bone of
/// that segment, and round it as the object's outward unit normal there was looked at. Nothing
/// for other parts than segments and the palm. Cost: constant.
std::optional<hand::HandLocation> placeByJoints(const HandJoints& joints,
                                                const std::string& part,
                                                const Eigen::Vector3d& p_O,
                                                const Eigen::Vector3d& n_O);

/// The tangent at a place with unit normal `n_O` along the finger towards the wrist; missing
/// where the bones stand on the surface there.
std::optional<Eigen::Vector3d> directionTowardsWrist(const HandJoints& joints,
                                                     const std::string& part,
                                                     const Eigen::Vector3d& p_O,
                                                     const Eigen::Vector3d& n_O);

}  // namespace handgraft::contact
