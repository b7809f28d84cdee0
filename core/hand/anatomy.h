#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

/// A part of a digit between two places where it bends, or from the last one to the tip.
///
/// Frames: S, that of the link poses it was found with.
struct Segment {
  std::string name;        ///< `proximal`, `middle`, `distal`: segmentNames
  std::vector<int> links;  ///< all that moves as it does, side joints before it included
  Eigen::Vector3d base_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_S = Eigen::Vector3d::Zero();
  /// Unit, at right angles to the bone: where the digit closes to.
  Eigen::Vector3d palmar_S = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d boneInSkin() const { return (end_S - base_S).normalized(); }

  [[nodiscard]] double length() const { return (end_S - base_S).norm(); }
};

/// A digit with its name and its segments, from the palm outwards.
struct NamedDigit {
  std::string name;
  // Neither: by the hand's shape.
  bool named_by_site = false;   ///< that lies on it, whatever else would
  bool named_by_parts = false;  ///< its links or joints say so
  Digit digit;
  std::vector<Segment> segments;

  [[nodiscard]] double length() const;
};

/// What the digits spring from. Its axes are those of the fingers side by side; the thumb's
/// side is where its thumb is.
struct Palm {
  std::vector<int> links;                               ///< moving metacarpals included
  Eigen::Vector3d facing_S = Eigen::Vector3d::Zero();   ///< unit, where the fingers close to
  Eigen::Vector3d outward_S = Eigen::Vector3d::Zero();  ///< unit, to the fingers
  Eigen::Vector3d thumb_side_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d first_knuckle_S =
      Eigen::Vector3d::Zero();  ///< of the finger next to the thumb
  Eigen::Vector3d last_knuckle_S = Eigen::Vector3d::Zero();
};

/// A hand read as a hand.
struct Anatomy {
  std::vector<NamedDigit> digits;  ///< thumb to little, then others
  /// Missing where fingers do not stand side by side, as around a Barrett's palm, or there are
  /// fewer than two beside the thumb.
  std::optional<Palm> palm;
  std::vector<int> palm_links;  ///< also where `palm` is missing
  Chirality chirality = Chirality::kUnknown;
  Chirality named_side = Chirality::kUnknown;  ///< what most names of the file say
  std::vector<std::string> notes;              ///< what names do not say or contradict
  /// Where names say the other side than the palm does.
  std::string side_note;

  [[nodiscard]] const NamedDigit* maybeDigit(const std::string& name) const;
};

/// Which hand it is. A claw is as good for either side, unless its maker says which one it is.
Chirality sideOf(const Anatomy& anatomy);

/// `distal`; `proximal`, `distal`; `proximal`, `middle`, `distal`; with more, `middle_2`, ...
std::vector<std::string> segmentNames(std::size_t count);

/// Digits (findDigits), their names (nameDigits, but like the first of `sites` that lies on
/// one), and their segments.
///
/// A segment begins at each joint that bends the digit as its last joint does (a thumb: at any
/// that moves its bone), unless it would be shorter than 8 mm or a tenth of the digit; what
/// turns sideways before belongs to the first, or, from 20 mm on, to the palm.
/// Halves of a rolling joint, with nothing to see between them, are one. A thumb has three
/// behind what is shorter than a quarter of it. A palm looks where its fingers close, or, if
/// one of `sites` is called `palm` and looks more than 60 degrees elsewhere, where that looks.
/// Sides that the names tell (right, left) are checked against the palm. Deterministic.
Anatomy anatomyOf(const HandModel& model,
                  const LinkPoses& X_SL,
                  const std::vector<ContactSite>& sites);

}  // namespace handgraft::hand
