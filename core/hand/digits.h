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
  std::vector<int> tip_links;  ///< what the last joint moves, fixed links included
  Eigen::Vector3d base = Eigen::Vector3d::Zero();        ///< origin of the first joint
  Eigen::Vector3d last_joint = Eigen::Vector3d::Zero();  ///< origin of the last joint
  /// What lies farthest from the last joint, the middle of it where that is several points.
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  double tip_radius = 0.0;  ///< m, of these points about their middle: near 0 on a round tip
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();  ///< unit, from the last joint to the tip
  /// Unit axis about which the last joint closes (right-hand rule), and where the pad looks:
  /// the direction in which the tip moves then.
  Eigen::Vector3d flexion_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d closing = Eigen::Vector3d::Zero();
  /// `thumb`, `index`, ... if the names of its links and joints say so; may be empty.
  std::string hint;
};

struct Digits {
  int palm_link = 0;  ///< the link that all digits spring from
  std::vector<Digit> digits;
};

/// What moves with `link`: itself and all links fixed to it, directly or not.
std::vector<int> rigidGroupOf(const HandModel& model, int link);

/// Finds the digits of a hand: chains of movable joints that end in a link with a surface.
///
/// A joint closes towards its limit of larger magnitude; where the joints of a digit are
/// symmetric, it closes as most of the others do. Deterministic. Cost: linear in the vertices.
Digits findDigits(const HandModel& model, const LinkPoses& X_SL);

/// What each digit is called: as the file's names say if every digit has its own; else `thumb`
/// for the one without which the others close most alike, and `index`, `middle`, `ring`,
/// `little` from its side across the palm; `f1`, `f2`, ... where that does not fit.
std::vector<std::string> nameDigits(const std::vector<Digit>& digits);

}  // namespace handgraft::hand
