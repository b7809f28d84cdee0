#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/hand/hand_model.h"

namespace handgraft::io {

/// A URDF reduced to what a hand needs, ready for urdfdom.
struct UrdfText {
  std::string xml;
  std::string robot_name;
  /// In the order of the file, which urdfdom forgets.
  std::vector<std::string> links;
  /// Names, types, parents, children and hand::kJointNumbers but the range; the rest is
  /// urdfdom's to read.
  std::vector<hand::Joint> joints;
  std::vector<std::string> unlimited_joints;  ///< movable, but the file gives no range
  std::set<std::string> solid_links;          ///< those with a visual or a collision
  std::vector<std::string> notes;
};

/// Parses `text` and amends what urdfdom refuses although it is harmless: limits without effort
/// or velocity become 0, a movable joint without a range gets one. A planar joint `j` becomes
/// the joints `j_x`, `j_y` (sliders in the plane) and `j_yaw`, a floating one `j_x`, `j_y`,
/// `j_z`, `j_roll`, `j_pitch` and `j_yaw`, with links of the same names between them. Inertias,
/// materials, sensors and extensions are left out, and with them everything urdfdom could
/// stumble over for no reason; so are shapes unless `with_shapes`.
///
/// Entities that the file defines itself are not expanded; nesting is bounded by tinyxml2.
/// Errors: InvalidInput for XML that is not well-formed, unnamed links and joints, unknown
/// joint types, a capsule, one of hand::kJointNumbers that is no number, a planar or floating
/// joint that mimics, more than kMostUrdfLinks links or joints, names longer than
/// kLongestUrdfName.
UrdfText prepareUrdf(const std::string& text, bool with_shapes);

/// What `<limit effort>` says of each joint that has one, by the joint's name: N, or N m. A
/// hand keeps no efforts; whoever writes its URDF anew takes them from its own. Errors: none;
/// what cannot be read has none.
std::map<std::string, double> effortLimitsOf(const std::string& urdf_text);

/// A humanoid has a few hundred; some of what is asked of a hand costs their square.
inline constexpr int kMostUrdfLinks = 2000;
inline constexpr std::size_t kLongestUrdfName = 256;

}  // namespace handgraft::io
