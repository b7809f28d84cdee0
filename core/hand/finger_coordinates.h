#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/anatomy.h"
#include "core/hand/hand.h"
#include "core/hand/hand_location.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// A place of the skin, and the tangent there that leads along the bone towards the wrist.
struct SkinSpot {
  geometry::SurfacePoint root_S;
  Eigen::Vector3d direction_S = Eigen::Vector3d::Zero();
};

/// Coordinates on a hand's digits and palm that carry places from hand to hand.
///
/// A segment is read as a cylinder about its bone, moved to the middle of its skin; the last
/// one ends in a half ball, on which `along` counts the way over its surface to the tip. So a
/// place near a tip keeps the way it faces on a longer or thicker one.
/// Frames: S, the skin's reference pose. Cost: some milliseconds to make beside anatomyOf; a
/// question looks at the faces of one digit. Const, safe from several threads.
class FingerCoordinates {
 public:
  /// Keeps `skin` by reference; `sites` as anatomyOf takes them.
  FingerCoordinates(const HandModel& model,
                    const Skin& skin,
                    const std::vector<ContactSite>& sites);

  [[nodiscard]] const Anatomy& anatomy() const { return anatomy_; }

  /// The part of each link: (digit, segment), (`palm`, ""), or two empty names.
  struct Part {
    std::string digit;
    std::string segment;
  };

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }

  /// Nothing on faces of no link, of no digit, or of a palm without axes.
  [[nodiscard]] std::optional<HandLocation> placeOf(
      const geometry::SurfacePoint& point_S) const;

  /// The place with these coordinates: in the segment of that name where the digit has as many
  /// as the place was taken from, else as far from the tip by length. Nothing where the hand
  /// has no such digit, or no skin there.
  [[nodiscard]] std::optional<SkinSpot> spotAt(const HandLocation& place) const;

  /// The place on a digit as many metres from its first joint as it is on a human's, whatever
  /// segment that is: where a longer finger meets the same object. Nothing for the palm, and
  /// where spotAt has nothing.
  [[nodiscard]] std::optional<SkinSpot> spotByLength(const HandLocation& place) const;

  /// Unit tangent towards the wrist at a place of the skin, as spotAt gives it.
  [[nodiscard]] std::optional<Eigen::Vector3d> towardsWrist(
      const geometry::SurfacePoint& point_S) const;

 private:
  /// A segment as a cylinder.
  struct Tube {
    Eigen::Vector3d base_S = Eigen::Vector3d::Zero();  ///< on the middle line
    Eigen::Vector3d bone_S = Eigen::Vector3d::Zero();
    Eigen::Vector3d palmar_S = Eigen::Vector3d::Zero();
    Eigen::Vector3d thumbward_S = Eigen::Vector3d::Zero();
    double length = 0.0;
    double radius = 0.0;
    double ball =
        0.0;  ///< height at which the half ball begins; the length where there is none
  };

  /// Cylinder coordinates: height over the base (over the ball: its way over the surface) and
  /// angle, with the ray from the middle line through them.
  struct Ray {
    Eigen::Vector3d origin_S;
    Eigen::Vector3d direction_S;
    Eigen::Vector3d to_wrist_S;
  };

  /// A height over a digit: the share `along` of that segment.
  struct Height {
    std::size_t segment = 0;
    double along = 0.0;
  };

  void measure(std::size_t digit, std::size_t segment, Tube& tube) const;
  void findPalm();
  [[nodiscard]] static Ray rayAt(const Tube& tube, double along, double around_rad);
  [[nodiscard]] static Height heightBySegment(const NamedDigit& digit,
                                              const HandLocation& place);
  [[nodiscard]] static Height heightByLength(const NamedDigit& digit,
                                             const HandLocation& place);
  /// The digit of that name; -1: none.
  [[nodiscard]] int digitNamed(const std::string& name) const;
  [[nodiscard]] std::optional<SkinSpot> spotOnDigit(std::size_t digit,
                                                    const Height& height,
                                                    double around_rad) const;
  [[nodiscard]] std::optional<SkinSpot> spotOnPalm(const HandLocation& place) const;
  [[nodiscard]] SkinSpot spotOf(const geometry::SurfacePoint& root_S,
                                const Eigen::Vector3d& to_wrist_S) const;
  [[nodiscard]] static double waysOver(const Tube& tube);

  const Skin& skin_;
  Anatomy anatomy_;
  std::vector<Part> parts_;               ///< of each link
  std::vector<int> digit_of_link_;        ///< -1: none
  std::vector<int> segment_of_link_;      ///< -1: none
  std::vector<std::vector<int>> faces_;   ///< of each digit
  std::vector<std::vector<Tube>> tubes_;  ///< of each digit's segments
  std::vector<int> palm_faces_;
  double palm_width_ = 0.0;   ///< m, between the first knuckle and the last
  double palm_height_ = 0.0;  ///< m, from the knuckles to the wrist
};

/// Those of a hand, shared by all who ask for the same sites; they must not outlive its skin.
std::shared_ptr<const FingerCoordinates> coordinatesOf(const Hand& hand);

}  // namespace handgraft::hand
