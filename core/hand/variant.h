#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// What may be changed of a hand that is not built yet (idl/studies.idl says the same).
enum class HandProperty {
  kLower,   ///< limit of a joint, rad or m
  kUpper,   ///< likewise
  kRange,   ///< factor of both limits about the joint's rest value
  kLength,  ///< factor along a link, from its own joint to the next ones
  kSize,    ///< factor of a link in all directions; of the whole hand if there is no target
};

struct HandChange {
  HandProperty property = HandProperty::kSize;
  std::string target;  ///< joint or link
  double value = 1.0;  ///< rad or m, or a factor
};

inline constexpr double kSmallestFactor = 0.1;
inline constexpr double kLargestFactor = 10.0;
inline constexpr double kLargestLimit = 1e3;  ///< rad or m

/// `lower`, `upper`, `range`, `length`, `size`.
std::string nameOf(HandProperty property);

/// Lengths and sizes change the shape, so that contacts are laid anew; limits do not.
bool changesShape(HandProperty property);

/// What can be said of one change on its own: the target exists, the value is in range.
/// Errors: InvalidInput, as makeVariant, but for limits that cross.
void validate(const HandModel& model, const HandChange& change);

/// A hand like another one but for some changes.
struct HandVariant {
  HandModel model;
  /// By link: what is at p_L of the original's link is at stretch_L[link] * p_L of the
  /// variant's.
  std::vector<Eigen::Matrix3d> stretch_L;
  /// By dof: the original's value times this is the same pose of the variant. 1 but for sliders
  /// of a hand whose size changed.
  Eigen::VectorXd joint_scale;
  /// Some link or joint is elsewhere than on the original.
  bool shape_changed = false;
};

/// What to make of the links' surfaces: many solves need none, and they are what costs.
enum class VariantSurfaces { kStretched, kLeftOut };

/// Applies `changes` in order. Fixed parts beyond a link move with it; they stretch by changes
/// of their own alone. The rest pose is moved into the limits.
///
/// A limit of a joint is that of all that follows it: where a follower's own limit would be
/// narrower, it gives way. A link's length runs towards the mean of its next joints; where
/// these lie at its own joint, towards the middle of its surface. A last link's runs across the
/// axis of the joint that it slides or bends by, as its finger does, so that faces along the
/// finger stay straight; unless it lies along that axis itself. No change at all, and factors
/// of 1, give the same hand, bit for bit.
///
/// Errors: InvalidInput names the joint or link and what is permitted: one that does not exist,
///   that follows another or is fixed, limits beyond 1000 rad or m or not in order, the range
///   of a joint without limits, factors outside 0.1 to 10, the length of a link that has none.
/// Cost: O(links), and with surfaces O(triangles).
HandVariant makeVariant(const HandModel& model,
                        const std::string& name,
                        const std::vector<HandChange>& changes,
                        VariantSurfaces surfaces = VariantSurfaces::kStretched);

/// Joint values of the original as the variant has them, moved into its limits.
Eigen::VectorXd poseOfVariant(const HandVariant& variant, const Eigen::VectorXd& q);

/// The original's sites where they are on the variant.
std::vector<ContactSite> sitesOfVariant(const HandVariant& variant,
                                        const std::vector<ContactSite>& sites);

}  // namespace handgraft::hand
