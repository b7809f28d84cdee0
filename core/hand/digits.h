#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

/// A finger or thumb: a chain of movable joints from the palm to a fingertip.
///
/// Everything is given in the frame of the link poses (S: the skin's reference pose).
struct Digit {
  std::vector<int> nodes;      ///< movable nodes of the model, from the palm outwards
  std::vector<int> carriers;   ///< movable ones before them, which other digits share
  std::vector<int> tip_links;  ///< what the last joint moves, fixed links included
  Eigen::Vector3d base = Eigen::Vector3d::Zero();        ///< origin of the first joint
  Eigen::Vector3d knuckle = Eigen::Vector3d::Zero();     ///< where it first bends as it closes
  Eigen::Vector3d last_joint = Eigen::Vector3d::Zero();  ///< origin of the last joint
  /// What lies farthest from the last joint, the middle of it where that is several points.
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  double tip_radius = 0.0;  ///< m, of these points about their middle: near 0 on a round tip
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();  ///< unit, from the last joint to the tip
  /// Unit axis about which the last joint closes (right-hand rule), and where the pad looks:
  /// the direction in which the tip moves then.
  Eigen::Vector3d flexion_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d closing = Eigen::Vector3d::Zero();
  /// The same of its first bone, from the knuckle to the next joint: what faces an object with
  /// the palm, also where the last joint is bent in the reference pose.
  Eigen::Vector3d bone_outward = Eigen::Vector3d::Zero();
  Eigen::Vector3d bone_closing = Eigen::Vector3d::Zero();
  /// `thumb`, `index`, ... as most names of its links and joints say (part_words.h), the ones
  /// nearer to the tip where they are as many; empty if none says any.
  std::string hint;
};

struct Digits {
  int palm_link = 0;  ///< the link that all digits spring from
  /// That and what is fixed to it (palmBodyOf), and parts of it that carry several digits.
  std::vector<int> palm_links;
  std::vector<Digit> digits;
};

/// What moves with `link`: itself and all links fixed to it, directly or not.
std::vector<int> rigidGroupOf(const HandModel& model, int link);

/// The palm and what is fixed to it, but for links that have visuals and no collision geometry
/// where the palm has both: a camera, a badge.
std::vector<int> palmBodyOf(const HandModel& model, int palm_link);

/// Finds the digits of a hand: chains of movable joints that end in a link with a surface.
///
/// A joint closes towards its limit of larger magnitude, but for a finger that is bent where
/// its joints are 0 and straightens towards that limit: it is shut there, and opens. Of two
/// digits each closes towards the other. Where the joints of a digit are symmetric, it closes
/// as most of the others do. Jaws that slide close towards each other. Bars that guide a
/// gripper's fingers are none, nor is what carries less than a fingertip.
/// Deterministic. Cost: linear in the vertices.
Digits findDigits(const HandModel& model, const LinkPoses& X_SL);

/// A thumb and two fingers: a claw, which takes what either hand touched.
inline constexpr std::size_t kClawDigits = 3;

enum class Chirality { kUnknown, kRight, kLeft };

/// "right", "left"; "" for unknown.
const char* nameOf(Chirality side);

/// The way back. Errors: InvalidInput naming the field for another text than those.
Chirality sideNamed(const std::string& text, const char* field);

/// What the digits of a hand are called, and how that is known.
struct DigitNames {
  std::vector<std::string> names;  ///< of each digit
  std::vector<char> from_file;     ///< whether its own names said so
  /// As the palm has it: where the thumb is, seen on the side that the fingers close to.
  Chirality chirality = Chirality::kUnknown;
  std::vector<std::string> notes;  ///< what was left to the shape, or contradicts it
};

/// Names digits: as their own names say, where no other digit's say the same, and not of one
/// alone that stands against the others; the rest by shape: `thumb` for the one without which
/// the others close most alike, and `index`, `middle`, `ring`, `little` from its side across
/// the palm; `f1`, `f2`, ... where that does not fit.
DigitNames nameDigits(const std::vector<Digit>& digits);

}  // namespace handgraft::hand
